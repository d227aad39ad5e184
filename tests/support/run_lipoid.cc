#include "tests/support/run_lipoid.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "model/core/atomic_file.h"
#include "model/core/json.h"
#include "tests/support/paths.h"

namespace lipoid::test {
namespace {

std::string Quoted(const std::string& word) {
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace

std::string TestFolder() {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  auto name = std::string(info->test_suite_name()) + "." + info->name();
  std::replace(name.begin(), name.end(), '/', '_');
  return FreshFolder(name);
}

RunResult RunShell(const std::string& folder, const std::string& command) {
  // What the shell wrote lies beside the folder, so that the folder shows what lipoid left.
  const auto out = folder + ".out";
  const auto err = folder + ".err";
  const auto line = "cd " + Quoted(folder) + " && LIPOID=" + Quoted(LIPOID_PROGRAM) +
                    "; export LIPOID; { " + command + "; } >" + Quoted(out) + " 2>" + Quoted(err) +
                    " </dev/null";
  const int status = std::system(line.c_str());
  RunResult result;
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result.out = ReadTextFile(out);
  result.err = ReadTextFile(err);
  return result;
}

RunResult RunLipoid(const std::string& folder, const std::vector<std::string>& arguments) {
  std::string command = "\"$LIPOID\"";
  for (const auto& argument : arguments) command += " " + Quoted(argument);
  return RunShell(folder, command);
}

void WriteFlownCell(const std::string& folder,
                    const std::vector<double>& soc,
                    const std::vector<double>& voltage_V) {
  Json cell = Json::parse(ReadTextFile(SourcePath("fixtures/cells/gifi-600mAh-1.json")));
  cell["name"] = "flown";
  cell["diffusion"] = nullptr;
  cell["open_circuit_voltage"] = {{"method", "linear"}, {"soc", soc}, {"voltage_V", voltage_V}};
  WriteFileAtomically(folder + "/flown.json", cell.dump());
}

Json ReadJson(const std::string& folder, const std::string& file) {
  const auto path = folder + "/" + file;
  return ParseJson(ReadTextFile(path), path);
}

std::vector<std::string> FilesIn(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace lipoid::test
