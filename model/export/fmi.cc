#include "model/export/fmi.h"

#include <fmt/format.h>

#include <boost/algorithm/string/replace.hpp>

#include "generated/fmi_libraries.h"
#include "model/core/errors.h"
#include "model/core/foreign_text.h"
#include "model/core/run_record.h"
#include "model/export/cell_numbers.h"
#include "model/export/folded_branches.h"
#include "model/export/provenance.h"
#include "model/export/zip_archive.h"

namespace lipoid {
namespace {

// As in runtime/fmu_cell.h.
constexpr std::size_t kFirstState = 1000;
constexpr std::size_t kFirstDerivative = 200000;
constexpr int kCurrent = 1;
constexpr int kPower = 2;
constexpr int kVoltage = 3;
constexpr int kSoc = 4;
constexpr int kOpenCircuit = 5;
constexpr int kDrawn = 6;
constexpr int kSeries = 7;
constexpr int kParallel = 8;
constexpr int kInitialSoc = 9;
constexpr int kScale = 10;
constexpr const char* kMark = "lipoid.c";  // of resources/cell.bin

std::string XmlText(std::string_view text) {
  std::string safe = ForeignText(text);
  for (const auto& [sign, name] : {std::pair{"&", "&amp;"},  // first: the others bring one
                                   std::pair{"<", "&lt;"},
                                   std::pair{">", "&gt;"},
                                   std::pair{"\"", "&quot;"}}) {
    boost::replace_all(safe, sign, name);
  }
  return safe;
}

struct State {
  std::string name;
  std::string unit;
  std::string rate_unit;
  std::string description;
};

std::vector<State> StatesOf(const CellNumbers& numbers) {
  std::vector<State> states{{"delivered_C", "C", "A", "charge that left one cell"}};
  for (std::size_t m = 1; m <= numbers.rate_per_s.size(); ++m) {
    states.push_back({fmt::format("unavailable_C[{}]", m),
                      "C",
                      "A",
                      "charge that mode m of the diffusion holds back"});
  }
  for (std::size_t j = 1; j <= numbers.branch.size(); ++j)
    states.push_back({fmt::format("branch_V[{}]", j), "V", "V/s", "voltage of an RC branch"});
  if (numbers.self_heating)
    states.push_back({"thermal_state_A2", "A2", "A2/s", "square of the current, low-passed"});
  return states;
}

// Only the attributes differ between the versions: `real` is the element of a real number,
// `integer` of a whole one. FMI 2 counts variables from 1, FMI 3 calls them by their value
// reference.
class Description {
 public:
  Description(const ExportRequest& request, const CellNumbers& numbers, bool three)
      : cell_(request.cell), states_(StatesOf(numbers)), three_(three) {
    Add(0, "time", "s", R"(causality="independent" variability="continuous")", "", "time");
    Add(kCurrent,
        "current_A",
        "A",
        kInput,
        R"(start="0")",
        "current of the pack, discharge positive");
    Add(kPower,
        "power_W",
        "W",
        kInput,
        R"(start="0")",
        "power of the pack, discharge positive; its current comes on top of current_A");
    Add(kVoltage, "voltage_V", "V", kOutput, "", "terminal voltage of the pack");
    Add(kSoc, "soc", "1", kOutput, "", "state of charge: 1 full, 0 empty at vanishing current");
    Add(kOpenCircuit, "open_circuit_V", "V", kOutput, "", "open-circuit voltage of the pack");
    Add(kDrawn,
        "drawn_current_A",
        "A",
        kOutput,
        "",
        "current of the pack, that of power_W included");
    AddCount(kSeries, "series", cell_.series, "cells in series");
    AddCount(kParallel, "parallel", cell_.parallel, "cells in parallel");
    Add(kInitialSoc,
        "initial_soc",
        "1",
        kParameter,
        R"(min="-0.5" max="1.5" start="1")",
        "state of charge at the start, relaxed");
    Add(kScale,
        "series_resistance_scale",
        "1",
        R"(causality="parameter" variability="tunable" initial="exact")",
        R"(min="0" start="1")",
        "multiplies the series resistance of the cells");
    const std::size_t first = indices_.size() + 1;
    for (std::size_t k = 0; k < states_.size(); ++k) {
      Add(kFirstState + k, states_[k].name, states_[k].unit, kLocal, "", states_[k].description);
    }
    for (std::size_t k = 0; k < states_.size(); ++k) {
      const std::size_t of = three_ ? kFirstState + k : first + k;
      Add(kFirstDerivative + k,
          "der(" + states_[k].name + ")",
          states_[k].rate_unit,
          kLocal,
          fmt::format(R"(derivative="{}")", of),
          "its derivative");
    }
  }

  [[nodiscard]] std::string Text(const ExportRequest& request,
                                 const Exported& exported,
                                 const std::string& name,
                                 const std::string& token) const {
    std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!--\n";
    text += Commented(ProvenanceLines(request, exported), "  ");
    text += "-->\n";
    const auto description =
        XmlText(fmt::format("Lithium-polymer cell {}, {} in series and {} in parallel",
                            request.cell.name,
                            cell_.series,
                            cell_.parallel));
    text += fmt::format(
        "<fmiModelDescription fmiVersion=\"{}\" modelName=\"{}\" {}=\"{}\"\n"
        "  description=\"{}\" generationTool=\"lipoid {}\"\n"
        "  variableNamingConvention=\"structured\"{}>\n",
        three_ ? "3.0" : "2.0",
        name,
        three_ ? "instantiationToken" : "guid",
        token,
        description,
        Version(),
        three_ ? "" : " numberOfEventIndicators=\"0\"");
    for (const bool exchange : {true, false}) {
      text += fmt::format("  <{} modelIdentifier=\"{}\"{}\n    {}=\"true\" {}=\"true\"",
                          exchange ? "ModelExchange" : "CoSimulation",
                          name,
                          exchange ? "" : " canHandleVariableCommunicationStepSize=\"true\"",
                          three_ ? "canGetAndSetFMUState" : "canGetAndSetFMUstate",
                          three_ ? "canSerializeFMUState" : "canSerializeFMUstate");
      text += three_ ? "/>\n"
                     : ">\n    <SourceFiles><File name=\"fmi2.c\"/></SourceFiles>\n  </" +
                           std::string(exchange ? "ModelExchange" : "CoSimulation") + ">\n";
    }
    text += kUnits;
    text += "  <LogCategories>\n";
    text += "    <Category name=\"logStatusDiscard\" description=\"more power than there is\"/>\n";
    text += "    <Category name=\"logStatusError\" description=\"what cannot be done\"/>\n";
    text += "  </LogCategories>\n";
    const auto& time_s = request.mission.time_s;
    text += fmt::format(
        "  <DefaultExperiment startTime=\"0\" stopTime=\"{}\" tolerance=\"1e-8\" "
        "stepSize=\"0.01\"/>\n",
        CNumber(time_s.empty() || !(time_s.back() > 0.0) ? 60.0 : time_s.back()));
    text += "  <ModelVariables>\n" + variables_ + "  </ModelVariables>\n";
    text += Structure();
    return text + "</fmiModelDescription>\n";
  }

 private:
  static constexpr const char* kInput = R"(causality="input" variability="continuous")";
  static constexpr const char* kOutput =
      R"(causality="output" variability="continuous" initial="calculated")";
  static constexpr const char* kLocal =
      R"(causality="local" variability="continuous" initial="calculated")";
  static constexpr const char* kParameter =
      R"(causality="parameter" variability="fixed" initial="exact")";
  static constexpr const char* kUnits =
      "  <UnitDefinitions>\n"
      "    <Unit name=\"1\"><BaseUnit/></Unit>\n"
      "    <Unit name=\"s\"><BaseUnit s=\"1\"/></Unit>\n"
      "    <Unit name=\"A\"><BaseUnit A=\"1\"/></Unit>\n"
      "    <Unit name=\"C\"><BaseUnit A=\"1\" s=\"1\"/></Unit>\n"
      "    <Unit name=\"V\"><BaseUnit kg=\"1\" m=\"2\" s=\"-3\" A=\"-1\"/></Unit>\n"
      "    <Unit name=\"V/s\"><BaseUnit kg=\"1\" m=\"2\" s=\"-4\" A=\"-1\"/></Unit>\n"
      "    <Unit name=\"W\"><BaseUnit kg=\"1\" m=\"2\" s=\"-3\"/></Unit>\n"
      "    <Unit name=\"A2\"><BaseUnit A=\"2\"/></Unit>\n"
      "    <Unit name=\"A2/s\"><BaseUnit A=\"2\" s=\"-1\"/></Unit>\n"
      "  </UnitDefinitions>\n";

  void Add(std::size_t reference,
           const std::string& name,
           const std::string& unit,
           const std::string& kind,
           const std::string& value,
           const std::string& description) {
    indices_.push_back(reference);
    if (three_) {
      variables_ += fmt::format(
          "    <Float64 name=\"{}\" valueReference=\"{}\" {}\n      {}{}unit=\"{}\" "
          "description=\"{}\"/>\n",
          name,
          reference,
          kind,
          value,
          value.empty() ? "" : " ",
          unit,
          description);
    } else {
      variables_ += fmt::format(
          "    <ScalarVariable name=\"{}\" valueReference=\"{}\" {}\n      "
          "description=\"{}\"><Real {}{}unit=\"{}\"/></ScalarVariable>\n",
          name,
          reference,
          kind,
          description,
          value,
          value.empty() ? "" : " ",
          unit);
    }
  }

  void AddCount(int reference, const std::string& name, int value, const std::string& description) {
    indices_.push_back(static_cast<std::size_t>(reference));
    const char* const format =
        three_ ? "    <Int32 name=\"{}\" valueReference=\"{}\" {}\n      description=\"{}\" "
                 "min=\"1\" start=\"{}\"/>\n"
               : "    <ScalarVariable name=\"{}\" valueReference=\"{}\" {}\n      "
                 "description=\"{}\"><Integer min=\"1\" start=\"{}\"/></ScalarVariable>\n";
    variables_ +=
        fmt::format(fmt::runtime(format), name, reference, kParameter, description, value);
  }

  // How the structure calls a variable.
  [[nodiscard]] std::size_t Name(std::size_t reference) const {
    if (three_) return reference;
    std::size_t index = 1;
    for (const std::size_t other : indices_) {
      if (other == reference) return index;
      ++index;
    }
    return 0;
  }

  [[nodiscard]] std::string Structure() const {
    const char* const key = three_ ? "valueReference" : "index";
    std::string inputs_and_states = fmt::format("{} {}", Name(kCurrent), Name(kPower));
    std::string derivatives;
    std::string initial;
    for (const int output : {kVoltage, kSoc, kOpenCircuit, kDrawn}) {
      initial += fmt::format("{}=\"{}\"/>\n", key, Name(static_cast<std::size_t>(output)));
    }
    // The states in one go, their names found once.
    const std::size_t first_state = Name(kFirstState);
    const std::size_t first_derivative = Name(kFirstDerivative);
    for (std::size_t k = 0; k < states_.size(); ++k)
      inputs_and_states += fmt::format(" {}", first_state + k);
    const auto rows = [&](const char* element, std::string_view lines) {
      std::string text;
      while (!lines.empty()) {
        const std::size_t end = lines.find('\n') + 1;
        text += fmt::format("    {}<{} {}", three_ ? "" : "  ", element, lines.substr(0, end));
        lines.remove_prefix(end);
      }
      return text;
    };
    std::string outputs;
    for (const int output : {kVoltage, kSoc, kOpenCircuit, kDrawn}) {
      outputs += fmt::format("{}=\"{}\" dependencies=\"{}\"/>\n",
                             key,
                             Name(static_cast<std::size_t>(output)),
                             inputs_and_states);
    }
    for (std::size_t k = 0; k < states_.size(); ++k) {
      derivatives += fmt::format("{}=\"{}\"/>\n", key, first_derivative + k);
      initial += fmt::format("{}=\"{}\"/>\n", key, first_state + k);
    }
    for (std::size_t k = 0; k < states_.size(); ++k)
      initial += fmt::format("{}=\"{}\"/>\n", key, first_derivative + k);
    if (three_) {
      return "  <ModelStructure>\n" + rows("Output", outputs) +
             rows("ContinuousStateDerivative", derivatives) + rows("InitialUnknown", initial) +
             "  </ModelStructure>\n";
    }
    return "  <ModelStructure>\n    <Outputs>\n" + rows("Unknown", outputs) +
           "    </Outputs>\n    <Derivatives>\n" + rows("Unknown", derivatives) +
           "    </Derivatives>\n    <InitialUnknowns>\n" + rows("Unknown", initial) +
           "    </InitialUnknowns>\n  </ModelStructure>\n";
  }

  const Cell& cell_;
  std::vector<State> states_;
  bool three_;
  std::vector<std::size_t> indices_;  // value references in the order of the variables
  std::string variables_;
};

// 8-4-4-4-12 hexadecimal digits in braces, the same for the same cell.
std::string Token(const std::string& content) {
  const std::string hash = Sha256OfBytes(content);
  return fmt::format("{{{}-{}-{}-{}-{}}}",
                     hash.substr(0, 8),
                     hash.substr(8, 4),
                     hash.substr(12, 4),
                     hash.substr(16, 4),
                     hash.substr(20, 12));
}

std::string Bytes(const unsigned char* data, std::size_t size) { return {data, data + size}; }

}  // namespace

Exported ExportFmi(const ExportRequest& request) {
  const std::string version = request.target_version.empty() ? "2" : request.target_version;
  if (version != "2" && version != "3") {
    throw OptionError(
        fmt::format("the target fmi has the versions 2 and 3, found '{}'", ForeignText(version)));
  }
  const bool three = version == "3";
  const FoldedCell folded = FoldFastBranches(request.cell);
  const CellNumbers numbers = NumbersOf(folded.cell);
  const std::string name = Identifier(request.name);

  Exported exported;
  exported.error =
      MissionError(request, RunCellLaw(folded.cell, request.mission, LawNumbers::kDouble));
  exported.parameters = {{"series", static_cast<double>(request.cell.series), "1"},
                         {"parallel", static_cast<double>(request.cell.parallel), "1"},
                         {"initial_soc", 1.0, "1"},
                         {"series_resistance_scale", 1.0, "1"}};
  exported.notes = folded.notes;
  exported.notes.push_back(fmt::format(
      "The law is the cell's own{}; the error is that of co-simulation, whose step is exact for an input "
      "that is held, whatever its length{}; in model exchange the tolerance of the solver comes on top{}.",
      WithoutWhatNoTargetHolds(request),
      ButForTables(folded.cell),
      ButForTables(folded.cell).empty()
          ? ""
          : ", and that resistance is followed within a step, as by fine rows"));
  exported.notes.emplace_back(
      "Under power_W a step is divided into parts of at most 0.05 s, each with the mean of the "
      "currents at its ends. More power than the pack can give is answered by fmi" +
      version + "Discard.");
  exported.notes.emplace_back(
      "voltage_V depends on current_A at once: where a motor's model makes the current of the "
      "voltage, that is an algebraic loop, which power_W or a step of delay avoids.");

  const std::string cell_bytes = NumberAsBytes(request.cell.series) +
                                 NumberAsBytes(request.cell.parallel) + NumbersAsBytes(numbers);
  constexpr std::size_t kTokenBytes = 40;
  const std::string token = Token(name + version + Version() + request.cell.name + cell_bytes);
  std::string padded = token;
  padded.resize(kTokenBytes, '\0');

  const std::string comment = Commented(ProvenanceLines(request, exported), "// ");
  const std::string header = comment + fmt::format(
                                           "#define FMU_TOKEN \"{}\"\n"
                                           "#define FMU_SERIES_OF_FILE {}\n"
                                           "#define FMU_PARALLEL_OF_FILE {}\n",
                                           token,
                                           request.cell.series,
                                           request.cell.parallel);
  const std::string processor = LIPOID_PROCESSOR;
  const std::string platform =
      three ? processor + "-linux" : (processor == "x86_64" ? "linux64" : processor + "-linux");
  std::vector<ZipEntry> entries;
  entries.push_back({"modelDescription.xml",
                     Description(request, numbers, three).Text(request, exported, name, token)});
  entries.push_back({fmt::format("binaries/{}/{}.so", platform, name),
                     three ? Bytes(kFmi3Library, sizeof kFmi3Library)
                           : Bytes(kFmi2Library, sizeof kFmi2Library)});
  entries.push_back({"resources/cell.bin", kMark + padded + cell_bytes});
  entries.push_back({"sources/cell_law.h", std::string(RuntimeText("cell_law"))});
  entries.push_back({"sources/cell_numbers.h", header + NumbersAsC(numbers)});
  entries.push_back({"sources/fmu_cell.h", std::string(RuntimeText("fmu_cell"))});
  entries.push_back({"sources/fmu_functions.h", std::string(RuntimeText("fmu_functions"))});
  if (three) {
    entries.push_back({"sources/fmi3.c", std::string(RuntimeText("fmi3"))});
    entries.push_back({"sources/buildDescription.xml",
                       fmt::format("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
                                   "<fmiBuildDescription fmiVersion=\"3.0\">\n"
                                   "  <BuildConfiguration modelIdentifier=\"{}\">\n"
                                   "    <SourceFileSet language=\"C99\">\n"
                                   "      <SourceFile name=\"fmi3.c\"/>\n"
                                   "    </SourceFileSet>\n"
                                   "  </BuildConfiguration>\n"
                                   "</fmiBuildDescription>\n",
                                   name)});
  } else {
    entries.push_back({"sources/fmi2.c", std::string(RuntimeText("fmi2"))});
  }
  exported.files.push_back({".fmu", ZipArchive(entries)});
  return exported;
}

}  // namespace lipoid
