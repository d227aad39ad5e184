#include "tools/commands/loaded_cell.h"

#include <filesystem>

#include "model/battery/cell_file.h"
#include "model/battery/fit_record.h"

namespace lipoid {

void TellAboutFit(cli::CommandLine& line, const Cell& cell, const std::string& name) {
  if (const auto doubt = DoubtAboutFit(cell); !doubt.empty()) line.Message("{}: {}", name, doubt);
}

Cell LoadCell(cli::CommandLine& line, const std::string& name_or_file) {
  Cell cell = LoadCell(name_or_file);
  TellAboutFit(line, cell, name_or_file);
  if (cell.name.empty()) cell.name = std::filesystem::path(name_or_file).stem();
  return cell;
}

}  // namespace lipoid
