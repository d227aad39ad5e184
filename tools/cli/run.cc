#include "tools/cli/run.h"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "model/battery/cell_schema.h"
#include "model/core/json_text.h"
#include "model/core/atomic_file.h"
#include "model/core/errors.h"
#include "model/core/run_record.h"
#include "tools/cli/completion.h"
#include "tools/cli/manual_page.h"
#include "tools/cli/suggest.h"

namespace lipoid::cli {
namespace {

// What stopped a command.
struct Failure {
  ExitCode exit_code = ExitCode::kIncomplete;
  const char* kind = "not-completed";
  std::string message;
  std::vector<Diagnostic> diagnostics = {};
};

// Whatever happens inside becomes a Failure.
template <class Function>
std::optional<Failure> Guarded(Function&& function) {
  try {
    function();
    return std::nullopt;
  } catch (const LoadError& error) {
    return Failure{ExitCode::kBadInput, "bad-input", error.what(), error.diagnostics()};
  } catch (const OptionError& error) {
    return Failure{ExitCode::kUsage, "usage", error.what()};
  } catch (const std::bad_alloc&) {
    return Failure{.message = "out of memory; give it less at once, or a machine with more"};
  } catch (const std::exception& error) {
    return Failure{.message = std::string("this should not have happened: ") + error.what()};
  } catch (...) {
    return Failure{.message = "this should not have happened"};
  }
}

// The file after --summary, found even where the rest of the command line is wrong.
std::string SummaryFile(const std::vector<std::string>& arguments) {
  constexpr std::string_view kOption = "--summary";
  for (std::size_t k = 0; k < arguments.size() && arguments[k] != "--"; ++k) {
    if (arguments[k] == kOption && k + 1 < arguments.size()) return OutputPath(arguments[k + 1]);
    if (arguments[k].starts_with("--summary="))
      return OutputPath(arguments[k].substr(kOption.size() + 1));
  }
  return "";
}

std::string SummaryText(const std::string& command,
                        ExitCode exit_code,
                        const Json& results,
                        const Failure* failure) {
  Json json = {{"command", command}, {"exit_code", static_cast<int>(exit_code)}};
  if (failure != nullptr) {
    Json error = {
        {"kind", failure->kind}, {"message", failure->message}, {"diagnostics", Json::array()}};
    for (const auto& [position, message] : failure->diagnostics) {
      error["diagnostics"].push_back({{"file", position.file},
                                      {"line", position.line},
                                      {"column", position.column},
                                      {"message", message}});
    }
    json["error"] = std::move(error);
  } else {
    json.update(results);
  }
  // Names of files may be anything but UTF-8: JSON must not.
  return JsonText(json);
}

// Data reach standard output whole. A reader who left early had enough; a full disk is an error.
void WriteStandardOutput(const std::string& text) {
  if (text.empty()) return;
  errno = 0;
  const bool written =
      std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  if (!written && errno != EPIPE) {
    throw OptionError(std::string("cannot write to standard output: ") + std::strerror(errno));
  }
}

void PrintFailure(const std::string& program, const Failure& failure) {
  std::string text;
  if (failure.exit_code == ExitCode::kBadInput) {
    text = failure.message;  // file:line:column: error: ...
  } else {
    text = program + ": error: " + failure.message;
  }
  if (ErrorIsColoured()) {
    constexpr std::string_view kWord = "error:";
    for (auto at = text.find(kWord); at != std::string::npos; at = text.find(kWord, at + 16)) {
      text.replace(at, kWord.size(), "\033[1;31merror:\033[0m");
    }
  }
  text += '\n';
  if (failure.exit_code == ExitCode::kUsage) text += fmt::format("Try '{} --help'.\n", program);
  std::fwrite(text.data(), 1, text.size(), stderr);
}

std::string ProgramHelp(std::span<const Command> commands) {
  std::string text =
      "Usage: lipoid COMMAND [arguments] [options]\n\n"
      "Identifies lithium-polymer cells from lab logs, and flies the result.\n\n"
      "Commands:\n";
  for (const auto& command : commands)
    text += fmt::format("  {:<12} {}\n", command.name, command.summary);
  text +=
      "\nlipoid COMMAND --help explains a command; lipoid --version (-V) says which lipoid this is.\n"
      "lipoid --manual prints the manual page, lipoid --completion SHELL what bash, zsh or fish need\n"
      "to complete commands and options, lipoid --schema the JSON Schema of the cell file.\n\n"
      "Example:\n"
      "  lipoid list cells\n\n";
  return text + fmt::format("Exit codes: {}\n", kExitCodes);
}

// The command of that name; OptionError names the nearest.
const Command& Find(std::span<const Command> commands, const std::string& name) {
  std::vector<std::string> known;
  for (const auto& command : commands) {
    if (command.name == name) return command;
    known.emplace_back(command.name);
  }
  const bool option = name.starts_with('-');
  if (option) known = {"--completion", "--help", "--manual", "--schema", "--version"};
  throw OptionError(UnknownName(option ? "option" : "command", name, known));
}

int RunChecked(std::span<const Command> commands, std::vector<std::string> arguments) {
  // A closed pipe is an error code to be seen, not a signal to die of.
  std::signal(SIGPIPE, SIG_IGN);
  if (arguments.size() >= 2 && arguments[0] == "help") arguments = {arguments[1], "--help"};
  const std::string name = arguments.empty() ? "" : arguments[0];
  const std::string summary_file = SummaryFile(arguments);
  std::string program = "lipoid";
  ExitCode exit_code = ExitCode::kDone;
  Json results = Json::object();

  const auto unwritable = Guarded([&] {
    if (!summary_file.empty()) CheckWritable(summary_file);
  });
  auto failure = unwritable ? unwritable : Guarded([&] {
    if (name.empty()) throw OptionError("a command is missing");
    if (name == "--help" || name == "-h" || name == "help") {
      return WriteStandardOutput(ProgramHelp(commands));
    }
    if (name == "--manual") {
      return WriteStandardOutput(ManualPage(DescribeCommands(commands)));
    }
    if (name == "--schema") return WriteStandardOutput(JsonText(CellSchema()));
    if (name == "--completion") {
      if (arguments.size() != 2) throw OptionError("option --completion: expected bash, zsh or fish");
      return WriteStandardOutput(CompletionScript(arguments[1], DescribeCommands(commands)));
    }
    if (name == "--version" || name == "-V") {
      return WriteStandardOutput(fmt::format("lipoid {} ({})\n", Version(), GitCommit()));
    }
    const Command& command = Find(commands, name);
    program = fmt::format("lipoid {}", command.name);
    CommandLine line(command, {arguments.begin() + 1, arguments.end()});
    exit_code = command.run(line);
    results = std::move(line.summary());
    WriteStandardOutput(line.output());
  });
  if (failure) exit_code = failure->exit_code;
  if (!summary_file.empty() && !unwritable) {
    const auto unwritten = Guarded([&] {
      WriteFileAtomically(summary_file,
                          SummaryText(name, exit_code, results, failure ? &*failure : nullptr));
    });
    if (unwritten && !failure) failure = unwritten;
  }
  if (!failure) return static_cast<int>(exit_code);
  PrintFailure(program, *failure);
  return static_cast<int>(failure->exit_code);
}

}  // namespace

void CleanUpWhenEnded() {
  sigset_t ending;
  sigemptyset(&ending);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    // What the caller had ignored (nohup) stays ignored.
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    if (before.sa_handler != SIG_IGN) sigaddset(&ending, signal);
  }
  pthread_sigmask(SIG_BLOCK, &ending, nullptr);  // in this thread and in all that it starts
  std::thread([ending] {
    int signal = 0;
    sigwait(&ending, &signal);
    RemoveUncommitted();
    std::signal(signal, SIG_DFL);
    pthread_sigmask(SIG_UNBLOCK, &ending, nullptr);
    std::raise(signal);
  }).detach();
}

int Run(std::span<const Command> commands, std::vector<std::string> arguments) noexcept {
  try {
    return RunChecked(commands, std::move(arguments));
  } catch (...) {  // no memory even for the message
    std::fputs("lipoid: error: out of memory\n", stderr);
    return static_cast<int>(ExitCode::kIncomplete);
  }
}

}  // namespace lipoid::cli
