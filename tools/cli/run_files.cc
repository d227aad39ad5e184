#include "tools/cli/run_files.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "model/core/errors.h"
#include "model/core/run_record.h"

namespace lipoid::cli {
namespace {

// Pipes, terminals and /dev/null hold nothing that could be lost.
bool IsSpecial(const std::string& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode);
}

}  // namespace

bool RunFiles::WriteToStandardOutput() const {
  return std::any_of(outputs_.begin(), outputs_.end(), [](const NamedOutput& output) {
    return output.path == kStandardOutput;
  });
}

void RunFiles::CheckNothingIsLost() const {
  std::vector<NamedOutput> outputs;
  // What the shell made of standard output is an output as well.
  const NamedOutput standard_output{"standard output", std::string(kStandardOutput)};
  std::error_code none;
  if (!WriteToStandardOutput() && std::filesystem::is_regular_file(standard_output.path, none))
    outputs.push_back(standard_output);
  for (const NamedOutput& output : outputs_) {
    if (output.path == kStandardOutput || !IsSpecial(output.path)) outputs.push_back(output);
  }
  std::vector<FilePlace> places;
  for (const NamedOutput& output : outputs) places.push_back(PlaceOfFile(output.path));
  for (std::size_t k = 0; k < outputs.size(); ++k) {
    for (std::size_t other = 0; other < k; ++other) {
      if (!(places[other] == places[k])) continue;
      throw OptionError(fmt::format("options {} and {}: '{}' is named twice; name two files",
                                    outputs[other].shown,
                                    outputs[k].shown,
                                    outputs[k].path));
    }
  }
  RefuseInputs(outputs, inputs_);
}

void RunFiles::CheckInputsOf(const Json& summary) const {
  const Json& known = summary.at("run").at("inputs");
  for (const std::string& input : inputs_) {
    std::error_code none;
    // The name of something shipped, or a folder, whose files are inputs of their own.
    if (!std::filesystem::exists(input, none) || std::filesystem::is_directory(input, none))
      continue;
    if (std::none_of(
            known.begin(), known.end(), [&](const Json& one) { return one.at("file") == input; })) {
      throw OptionError(fmt::format("'{}' is not among the inputs that the summary names", input));
    }
  }
}

void RunFiles::AddOutputs(std::string_view shown, const std::vector<std::string>& paths) {
  for (const std::string& path : paths) AddOutput(shown, path);
  CheckNothingIsLost();
  for (const std::string& path : paths) {
    std::error_code none;
    const auto folder = std::filesystem::absolute(path, none).parent_path();
    if (std::filesystem::exists(folder, none)) CheckWritable(path);  // or it is made later
  }
}

void RunFiles::CheckOutputsAreWritable() const {
  for (const NamedOutput& output : outputs_) CheckWritable(output.path);
}

void RunFiles::AddHashes(const std::vector<std::string>& files,
                         const std::vector<std::string>& sha256) {
  for (std::size_t k = 0; k < files.size(); ++k) sha256_[files[k]] = sha256[k];
}

Json RunFiles::InputsToJson() const {
  std::vector<std::string> files;
  for (const std::string& input : inputs_) {
    std::error_code none;
    const bool twice = std::find(files.begin(), files.end(), input) != files.end();
    if (!twice && std::filesystem::is_regular_file(input, none)) files.push_back(input);
  }
  std::vector<std::string> sha256(files.size());
  tbb::parallel_for(std::size_t{0}, files.size(), [&](std::size_t k) {
    const auto known = sha256_.find(files[k]);
    sha256[k] = known != sha256_.end() ? known->second : Sha256OfFile(files[k]);
  });
  Json inputs = Json::array();
  for (std::size_t k = 0; k < files.size(); ++k)
    inputs.push_back({{"file", files[k]}, {"sha256", sha256[k]}});
  return inputs;
}

std::vector<std::string> RunFiles::Commit() {
  const auto& all = written_.replaced_one_name_of();
  const auto said = static_cast<std::ptrdiff_t>(all.size());
  written_.Commit();
  return {all.begin() + said, all.end()};
}

void CheckWritable(const std::string& file) {
  struct stat status {};
  const bool exists = ::stat(file.c_str(), &status) == 0;
  const bool special = exists && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
  if (!special) AtomicFile probe(file);  // opening a pipe would wait for its reader
}

std::string OutputPath(const std::string& text) {
  const bool is_standard_output = text == "-" || text == "/dev/fd/1" || text == "/proc/self/fd/1";
  return is_standard_output ? std::string(kStandardOutput) : text;
}

}  // namespace lipoid::cli
