#include "tools/cli/foreign_files.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <system_error>

#include "model/core/errors.h"
#include "model/export/provenance.h"

namespace lipoid::cli {

bool IsExportOfLipoid(const std::string& file) {
  std::string begin(kProvenanceBytes, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<std::size_t>(stream.gcount()));
  return HasProvenance(begin);
}

void RefuseToReplace(const CommandLine& line, const std::vector<std::string>& files) {
  if (line.earlier() != nullptr) return;  // nothing is written
  for (const std::string& file : files) {
    std::error_code none;
    if (!std::filesystem::is_regular_file(file, none) ||
        std::filesystem::file_size(file, none) == 0)
      continue;
    throw OptionError(fmt::format(
        "option -o: '{}' is there already and would be replaced, though lipoid did not write it; "
        "name another place, or move that file away",
        file));
  }
}

}  // namespace lipoid::cli
