// lipoid list WHAT: from the tables themselves.
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "identify/export/targets.h"
#include "identify/logs/flight/autopilot_log.h"
#include "identify/logs/formats/formats.h"
#include "identify/optimizers/optimizers.h"
#include "identify/synthesis/protocols.h"
#include "model/battery/cell_file.h"
#include "model/control/gains.h"
#include "model/control/laws/control_laws.h"
#include "model/core/errors.h"
#include "model/core/nearest_name.h"
#include "model/flight/maneuvers/maneuvers.h"
#include "model/vehicle/motor.h"
#include "model/vehicle/vehicle_file.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"

namespace lipoid {
namespace {

using cli::Align;
using cli::Significant;

Json ListCells(cli::CommandLine& line) {
  cli::TextTable table({{"cell", Align::kLeft},
                        {"capacity / Ah"},
                        {"cut-off / V"},
                        {"alpha / C"},
                        {"/ Ah"},
                        {"beta / s^-1/2"},
                        {"r_s / Ohm"},
                        {"v_oc(A)", Align::kLeft}});
  Json rows = Json::array();
  for (const auto& name : ShippedCellNames()) {
    const Cell cell = LoadCell(name);
    const double beta = cell.diffusion ? cell.diffusion->beta_per_sqrt_s : 0.0;
    table.Row({name,
               fmt::format("{}", cell.capacity_Ah),
               fmt::format("{}", cell.cutoff_V),
               fmt::format("{}", cell.alpha_C()),
               fmt::format("{:.4g}", cell.alpha_C() / 3600.0),
               cell.diffusion ? Significant(beta) : "none",
               Significant(cell.series_resistance_Ohm(1.0)),
               cell.open_circuit_voltage_assumed ? "assumed, a typical curve" : "measured"});
    rows.push_back(
        {{"name", name}, {"capacity_Ah", cell.capacity_Ah}, {"alpha_C", cell.alpha_C()}});
  }
  line.Print("{}", table.Text());
  return rows;
}

// Rows of a name, a summary and, where there is one, a source.
using Words = std::vector<std::vector<std::string_view>>;

Json ListWords(cli::CommandLine& line, const std::vector<std::string>& headers, const Words& rows) {
  constexpr const char* kKeys[] = {"name", "summary", "source"};
  std::vector<cli::TextTable::Column> columns;
  for (const std::string& header : headers) columns.push_back({header, Align::kLeft});
  cli::TextTable table(columns);
  Json json = Json::array();
  for (const auto& words : rows) {
    table.Row({words.begin(), words.end()});
    Json& row = json.emplace_back(Json::object());
    for (std::size_t k = 0; k < words.size(); ++k) row[kKeys[k]] = words[k];
  }
  line.Print("{}", table.Text());
  return json;
}

Json ListFormats(cli::CommandLine& line) {
  Words rows;
  for (const Layout* format : LogFormats()) rows.push_back({format->name, format->summary});
  for (const AutopilotFormat& format : AutopilotFormats())
    rows.push_back({format.name, format.summary});
  return ListWords(line, {"format", "what it is"}, rows);
}

Json ListControllers(cli::CommandLine& line) {
  Words rows;
  for (const ControlLaw& law : ControlLaws()) rows.push_back({law.name, law.summary, law.source});
  return ListWords(line, {"controller", "what it does", "from"}, rows);
}

Json ListManeuvers(cli::CommandLine& line) {
  Words rows;
  for (const Maneuver& one : Maneuvers()) rows.push_back({one.name, one.summary, one.source});
  return ListWords(line, {"maneuver", "what it flies", "from"}, rows);
}

Json ListOptimizers(cli::CommandLine& line) {
  cli::TextTable table(
      {{"optimizer", Align::kLeft}, {"library", Align::kLeft}, {"what it does", Align::kLeft}});
  Json rows = Json::array();
  std::string all_options;
  for (const auto& optimizer : Optimizers()) {
    table.Row({std::string(optimizer.name),
               std::string(optimizer.library),
               std::string(optimizer.summary)});
    Json options = Json::array();
    all_options += fmt::format("\nOptions of {}:\n", optimizer.name);
    for (const auto& option : optimizer.options()) {
      options.push_back({{"name", option.name},
                         {"default", option.default_text},
                         {"valid", option.valid},
                         {"help", option.help}});
      all_options += "  " +
                     cli::Wrapped(fmt::format("{}: {}; {} (default {})",
                                              option.name,
                                              option.help,
                                              option.valid,
                                              option.default_text),
                                  4) +
                     "\n";
    }
    rows.push_back({{"name", optimizer.name},
                    {"library", optimizer.library},
                    {"summary", optimizer.summary},
                    {"options", std::move(options)}});
  }
  line.Print("{}{}", table.Text(), all_options);
  return rows;
}

Json ListProtocols(cli::CommandLine& line) {
  Words rows;
  for (const Protocol& protocol : kProtocols) rows.push_back({protocol.name, protocol.summary});
  return ListWords(line, {"protocol", "what the lab does"}, rows);
}

Json ListGains(cli::CommandLine& line) {
  cli::TextTable loops({{"gains", Align::kLeft},
                        {"loop", Align::kLeft},
                        {"K_e / s^-2"},
                        {"K_eI / s^-3"},
                        {"K_edot / s^-1"}});
  cli::TextTable position({{"gains", Align::kLeft},
                           {"loop", Align::kLeft},
                           {"K_p / rad/m"},
                           {"K_d / rad s/m"},
                           {"tilt at most / deg"}});
  Json rows = Json::array();
  for (const auto& name : ShippedGainsNames()) {
    const Gains gains = LoadGains(name);
    const std::pair<const char*, const ErrorGains*> all[] = {
        {"altitude", &gains.altitude}, {"roll, pitch", &gains.attitude}, {"yaw", &gains.yaw}};
    for (const auto& [loop, k] : all) {
      loops.Row({name,
                 loop,
                 fmt::format("{}", k->proportional),
                 fmt::format("{}", k->integral),
                 fmt::format("{}", k->derivative)});
    }
    position.Row({name,
                  "position",
                  Significant(gains.position.proportional_rad_per_m),
                  Significant(gains.position.derivative_rad_s_per_m),
                  Significant(gains.position.tilt_limit_rad * 180.0 / std::numbers::pi, 3)});
    rows.push_back(GainsToJson(gains));
  }
  line.Print("{}\n{}", loops.Text(), position.Text());
  return rows;
}

Json ListTargets(cli::CommandLine& line) {
  cli::TextTable table({{"target", Align::kLeft},
                        {"kind", Align::kLeft},
                        {"what it is", Align::kLeft},
                        {"versions", Align::kLeft}});
  Json rows = Json::array();
  for (const ExportTarget& target : ExportTargets()) {
    const auto versions = target.Versions();
    table.Row({std::string(target.name),
               options_internal::ToText(target.kind),
               std::string(target.summary),
               versions.empty() ? "-" : fmt::format("{}", fmt::join(versions, ", "))});
    rows.push_back({{"name", target.name},
                    {"kind", options_internal::ToText(target.kind)},
                    {"summary", target.summary},
                    {"versions", versions},
                    {"extension", target.extension}});
  }
  line.Print(
      "{}\nexact: the law is the cell's own, but for temperature and hysteresis, which no target holds;\n"
      "projected: its numbers are fitted over a mission;\n"
      "data: a table. The first version is the default of --target-version.\n",
      table.Text());
  return rows;
}

// Hover as its motors need it, whatever supplies them: a duty above 1 says that none can.
Json ListVehicles(cli::CommandLine& line) {
  cli::TextTable table({{"vehicle", Align::kLeft},
                        {"mass / g"},
                        {"hover / rad/s"},
                        {"motor / V"},
                        {"motor / A"},
                        {"duty"},
                        {"at / V"},
                        {"what it is", Align::kLeft}});
  Json rows = Json::array();
  for (const auto& name : ShippedVehicleNames()) {
    const Vehicle v = LoadVehicle(name);
    const double speed =
        std::sqrt(v.mass_kg * kGravity_m_per_s2 / v.total_thrust_coefficient_N_s2());
    const double voltage = HoldingVoltage(v, speed);
    const double current = HoldingCurrent(v, speed);
    const double duty = voltage / v.nominal_voltage_V;
    table.Row({name,
               fmt::format("{:.6g}", 1e3 * v.mass_kg),
               Significant(speed),
               Significant(voltage),
               Significant(current),
               Significant(duty, 3),
               fmt::format("{}", v.nominal_voltage_V),
               v.summary});
    rows.push_back({{"name", name},
                    {"summary", v.summary},
                    {"mass_kg", v.mass_kg},
                    {"nominal_voltage_V", v.nominal_voltage_V},
                    {"hover_speed_rad_per_s", speed},
                    {"hover_motor_voltage_V", voltage},
                    {"hover_motor_current_A", current},
                    {"hover_duty", duty}});
  }
  line.Print("{}", table.Text());
  return rows;
}

struct Topic {
  std::string_view name;
  Json (*list)(cli::CommandLine&);
};
constexpr Topic kTopics[] = {
    {"cells", &ListCells},
    {"controllers", &ListControllers},
    {"formats", &ListFormats},
    {"gains", &ListGains},
    {"maneuvers", &ListManeuvers},
    {"optimizers", &ListOptimizers},
    {"protocols", &ListProtocols},
    {"targets", &ListTargets},
    {"vehicles", &ListVehicles},
};

}  // namespace

cli::ExitCode ListCommand(cli::CommandLine& line) {
  std::string what;
  std::vector<std::string> known;
  for (const auto& topic : kTopics) known.emplace_back(topic.name);
  line.Describe("Lists what lipoid knows by name.", "lipoid list cells");
  line.Argument("WHAT", what, "one of: " + fmt::format("{}", fmt::join(known, ", ")));
  if (!line.Parse()) return cli::ExitCode::kDone;
  for (const auto& topic : kTopics) {
    if (topic.name != what) continue;
    line.summary()[what] = topic.list(line);
    return cli::ExitCode::kDone;
  }
  throw OptionError(UnknownName("list", what, known));
}

}  // namespace lipoid
