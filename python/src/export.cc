#include "python/src/export.h"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "identify/export/export_report.h"
#include "identify/export/law_limits.h"
#include "identify/export/mission.h"
#include "identify/export/targets.h"
#include "identify/logs/reading_request.h"
#include "identify/pack_request.h"
#include "model/battery/cell_file.h"
#include "model/core/atomic_file.h"
#include "model/core/errors.h"
#include "model/core/json_text.h"
#include "model/core/one_file.h"
#include "model/core/run_record.h"
#include "python/src/cell.h"
#include "python/src/convert.h"
#include "python/src/keywords.h"
#include "python/src/log.h"
#include "python/src/work.h"

namespace lipoid::python {
namespace {

struct ExportKeywords {
  ExportRequest request;
  PackRequest pack;
  StartRequest start;
  std::optional<nb::object> mission;

  void Declare(Keywords& keywords) {
    mission =
        keywords.Take("mission",
                      "Log | Path",
                      "what the numbers are fitted and compared over, or its file, which may hold "
                      "time_s,power_W, too; not given: two levels of current with rests");
    keywords.Each(pack);
    keywords.Each(start);
    keywords.Each(request);
  }
};

nb::tuple ExportCell(const PythonCell& cell,
                     const std::string& target_name,
                     nb::handle output,
                     const nb::dict& given,
                     const nb::list& inputs) {
  const ExportTarget& target = FindExportTarget(target_name);
  ExportKeywords made;
  Keywords keywords(given);
  made.Declare(keywords);
  keywords.Finish();
  ExportRequest& request = made.request;
  const std::string path = PathOf(output);
  std::vector<NamedOutput> outputs{{"output", path}};
  for (const auto& suffix : target.FurtherSuffixes())
    outputs.push_back({"output", FileBeside(path, suffix)});
  RefuseInputs(outputs, PathsOf(inputs));
  Cell pack = cell.cell;
  made.pack.ApplyTo(pack);
  SetCell(request, pack);
  request.source = cell.cell.name;
  request.sha256 =
      cell.sha256.empty() ? Sha256OfBytes(JsonText(CellToJson(cell.cell))) : cell.sha256;
  request.name = IdentifierOf(cell.cell.name);
  request.stem = std::filesystem::path(path).stem().string();
  std::vector<std::string> warnings;
  if (made.mission) {
    ReadMission read =
        nb::isinstance<PythonLog>(*made.mission)
            ? MissionOfLog(
                  request.Whole(), nb::cast<const PythonLog&>(*made.mission).Lent(), made.start)
            : ReadMissionFile(
                  request.Whole(), PathOf(*made.mission), ReadingRequest{}.Resolve(), made.start);
    request.mission = std::move(read.mission);
    warnings = std::move(read.warnings);
  } else if (made.start.given()) {
    throw OptionError("the mission made here starts full: give a mission, or no start");
  } else if (DefaultCurrent_A(request.cell) > 0.0) {
    request.mission = DefaultMission(request.cell);
  } else {
    throw OptionError("the cell is at its cut-off under any current; give a mission");
  }
  Exported exported;
  Work([&](const Tell&) { exported = Export(target, request); });
  Json summary = ExportToJson(target, request, exported);
  summary["files"] = Json::array();
  FileSet files;
  for (std::size_t k = 0; k < exported.files.size(); ++k) {
    const std::string file = k == 0 ? path : FileBeside(path, exported.files[k].suffix);
    WriteFileAtomically(file, exported.files[k].content);
    summary["files"].push_back(file);
  }
  files.Commit();
  return nb::make_tuple(ToPython(summary), warnings);
}

}  // namespace

void AddExport(nb::module_& module) {
  module.def("export",
             &ExportCell,
             nb::arg("cell"),
             nb::arg("target"),
             nb::arg("output"),
             nb::arg("options"),
             nb::arg("inputs"));
  module.def("describe_export", [] {
    ExportKeywords made;
    Keywords keywords;
    made.Declare(keywords);
    return keywords.Described();
  });
  module.def("target_names", [] {
    nb::list names;
    for (const auto& target : ExportTargets()) names.append(std::string(target.name));
    return names;
  });
}

}  // namespace lipoid::python
