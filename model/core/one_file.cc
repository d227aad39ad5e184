#include "model/core/one_file.h"

#include <fmt/format.h>
#include <strings.h>
#include <sys/stat.h>

#include <filesystem>
#include <system_error>
#include <vector>

#include "model/core/atomic_file.h"
#include "model/core/errors.h"

namespace lipoid {

bool operator==(const FilePlace& a, const FilePlace& b) {
  return a.device == b.device && a.file == b.file &&
         ::strcasecmp(a.name.c_str(), b.name.c_str()) == 0;
}

FilePlace PlaceOfFile(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0) return {status.st_dev, status.st_ino, ""};
  std::error_code none;
  const std::filesystem::path file =
      std::filesystem::weakly_canonical(std::filesystem::absolute(BehindLinks(path), none), none);
  if (none) return {0, 0, path};
  const std::string folder = file.parent_path().string();
  if (::stat(folder.c_str(), &status) != 0) return {0, 0, file.string()};
  return {status.st_dev, status.st_ino, file.filename().string()};
}

bool LeadToOneFile(const std::string& a, const std::string& b) {
  return PlaceOfFile(a) == PlaceOfFile(b);
}

void RefuseInputs(std::span<const NamedOutput> outputs, std::span<const std::string> inputs) {
  std::vector<FilePlace> places;
  for (const NamedOutput& output : outputs) places.push_back(PlaceOfFile(output.path));
  std::error_code none;
  for (const std::string& input : inputs) {
    if (outputs.empty() || !std::filesystem::is_regular_file(input, none)) continue;
    const FilePlace read = PlaceOfFile(input);
    for (std::size_t k = 0; k < outputs.size(); ++k) {
      if (!(places[k] == read)) continue;
      throw OptionError(
          outputs[k].path == kStandardOutput
              ? fmt::format("standard output is '{}', which is also an input; name another file",
                            input)
              : fmt::format("option {}: '{}' is also an input; name another file",
                            outputs[k].shown,
                            outputs[k].path));
    }
  }
}

}  // namespace lipoid
