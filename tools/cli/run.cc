#include "tools/cli/run.h"

#include <pthread.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <memory>
#include <mutex>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <thread>

#include "model/battery/cell_schema.h"
#include "model/core/atomic_file.h"
#include "model/core/errors.h"
#include "model/core/foreign_text.h"
#include "model/core/json_text.h"
#include "model/core/nearest_name.h"
#include "model/core/one_file.h"
#include "model/core/run_record.h"
#include "tools/cli/completion.h"
#include "tools/cli/manual_page.h"
#include "tools/cli/progress.h"
#include "tools/cli/text_table.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace lipoid::cli {
namespace {

// What stopped a command.
struct Failure {
  ExitCode exit_code = ExitCode::kInternal;
  const char* kind = "internal";
  std::string message;
  std::vector<Diagnostic> diagnostics = {};
};

Failure Internal(std::string_view what) {
  return {
      .message = fmt::format(
          "this should not have happened, and is a mistake of lipoid {} ({}); please report it{}",
          Version(),
          GitCommit(),
          what.empty() ? "" : ": " + ForeignText(what, kMostBytesOfMessage))};
}

// The one place where whatever happens inside becomes a sentence and an exit code.
template <class Function>
std::optional<Failure> Guarded(Function&& function) {
  try {
    function();
    return std::nullopt;
  } catch (const LoadError& error) {
    return Failure{ExitCode::kBadInput, "bad-input", error.what(), error.diagnostics()};
  } catch (const OptionError& error) {
    return Failure{ExitCode::kUsage, "usage", ForeignLines(error.what())};
  } catch (const std::bad_alloc&) {
    return Failure{ExitCode::kIncomplete,
                   "not-completed",
                   "out of memory; give it less at once, or a machine with more"};
  } catch (const std::exception& error) {
    return Internal(error.what());
  } catch (...) {
    return Internal("");
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

Json SummaryJson(const std::string& command,
                 ExitCode exit_code,
                 const Json& results,
                 const Failure* failure) {
  Json json = {{"command", command}, {"exit_code", static_cast<int>(exit_code)}};
  if (failure != nullptr) {
    Json error = {
        {"kind", failure->kind}, {"message", failure->message}, {"diagnostics", Json::array()}};
    for (const auto& [position, message] : failure->diagnostics) {
      error["diagnostics"].push_back({{"file", position.file},
                                      {"line", std::max<std::size_t>(position.line, 1)},
                                      {"column", std::max<std::size_t>(position.column, 1)},
                                      {"message", message}});
    }
    json["error"] = std::move(error);
  } else {
    json.update(results);
  }
  return json;
}

// Data reach standard output whole. A reader who left early had enough; a full disk is an error.
void WriteStandardOutput(const std::string& text, std::FILE* stream = stdout) {
  if (text.empty() || stream == nullptr) return;
  errno = 0;
  const std::string shown = ForeignLines(text);
  const bool written = std::fwrite(shown.data(), 1, shown.size(), stream) == shown.size() &&
                       std::fflush(stream) == 0;
  if (!written && errno != EPIPE) {
    throw OptionError(std::string("cannot write to standard output: ") + std::strerror(errno));
  }
}

// The tables, with which lipoid made them by which command.
std::string Paper(const CommandLine& line, const TablesForPaper& tables) {
  return fmt::format("% lipoid {} ({}): {}\n% \\usepackage{{booktabs}}\n{}",
                     Version(),
                     GitCommit(),
                     ForeignText(line.CommandText(), std::string::npos),
                     tables.latex());
}

void PrintFailure(const std::string& program, const Failure& failure) {
  std::string text;
  if (failure.exit_code == ExitCode::kBadInput) {
    text = failure.message;  // file:line:column: error: ...
  } else {
    text = program + ": error: " + failure.message;
  }
  if (ErrorIsTerminal()) text = WrappedLines(text);
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
  std::size_t width = 0;
  for (const auto& command : commands) width = std::max(width, command.name.size());
  for (const auto& command : commands)
    text += fmt::format("  {:<{}}  {}\n", command.name, width, command.summary);
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

// Why a command that failed may not write its summary to this file; "" where it may. It may have
// failed before it knew all of its inputs: only an earlier summary is replaced, and what is empty or
// not there.
std::string WhyNoSummary(const std::string& file,
                         const std::vector<std::string>& arguments,
                         const std::vector<std::string>& inputs) {
  struct stat status {};
  const bool exists = ::stat(file.c_str(), &status) == 0;
  if (exists && !S_ISREG(status.st_mode)) return "";
  auto paths = inputs;
  for (const std::string& word : arguments) {
    paths.push_back(word);
    if (const auto equals = word.find('='); equals != std::string::npos)
      paths.push_back(word.substr(equals + 1));
  }
  const auto times = std::count_if(paths.begin(), paths.end(), [&](const std::string& path) {
    return LeadToOneFile(path, file);
  });
  if (times > 1) return "stands for another file, too";  // once as the summary itself
  if (!exists || status.st_size == 0) return "";
  constexpr std::string_view kBegins = "{\n  \"command\": \"";
  char begins[kBegins.size()];
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "rb"),
                                                               &std::fclose);
  const bool summary = stream &&
                       std::fread(begins, 1, sizeof begins, stream.get()) == sizeof begins &&
                       std::string_view(begins, sizeof begins) == kBegins;
  return summary ? "" : "holds something else than an earlier summary";
}

int RunChecked(std::span<const Command> commands, std::vector<std::string> arguments) {
  // A closed pipe, or a file that may not grow further, is an error code to be seen, not a signal
  // to die of.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  if (arguments.size() >= 2 && arguments[0] == "help") arguments = {arguments[1], "--help"};
  const std::string name = arguments.empty() ? "" : arguments[0];
  const std::string summary_file = SummaryFile(arguments);
  std::string program = "lipoid";
  ExitCode exit_code = ExitCode::kDone;
  std::unique_ptr<CommandLine> line;

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
      if (arguments.size() != 2)
        throw OptionError("option --completion: expected bash, zsh or fish");
      return WriteStandardOutput(CompletionScript(arguments[1], DescribeCommands(commands)));
    }
    if (name == "--version" || name == "-V") {
      return WriteStandardOutput(fmt::format("lipoid {} ({})\n", Version(), GitCommit()));
    }
    const Command& command = Find(commands, name);
    program = fmt::format("lipoid {}", command.name);
    line = std::make_unique<CommandLine>(
        command, std::vector<std::string>(arguments.begin() + 1, arguments.end()));
    const TablesForPaper tables;
    exit_code = command.run(*line);
    line->progress().Wipe();  // a result is not printed behind a bar
    WriteStandardOutput(line->output(), line->OutputStream());
    if (line->parsed() && !(summary_file.empty() && line->report_file().empty())) {
      if (line->can_report()) line->summary()["run"] = line->RunJson();
      ReportResult result{SummaryJson(name, exit_code, line->summary(), nullptr),
                          std::move(line->report_series()),
                          {},
                          ""};
      if (!summary_file.empty()) WriteFileAtomically(summary_file, JsonText(result.summary));
      if (!line->report_file().empty())
        WriteFileAtomically(line->report_file(), ReportPage({&result, 1}));
    }
    if (!line->latex_file().empty()) {
      if (tables.latex().empty()) {
        line->Message("{}: not written, for this result has no table", line->latex_file());
      } else {
        WriteFileAtomically(line->latex_file(), Paper(*line, tables));
      }
    }
    line->CommitOutputs();
  });
  if (!failure) return static_cast<int>(exit_code);
  const auto inputs = line ? line->inputs() : std::vector<std::string>();
  line.reset();  // and with it all that it wrote
  if (!summary_file.empty() && !unwritable) {
    const std::string why = WhyNoSummary(summary_file, arguments, inputs);
    if (why.empty()) {
      (void)Guarded([&] {
        WriteFileAtomically(
            summary_file,
            JsonText(SummaryJson(name, failure->exit_code, Json::object(), &*failure)));
      });
    } else {
      failure->message += fmt::format(
          "\n{}: no summary is written: '{}' {}", program, ForeignText(summary_file), why);
    }
  }
  PrintFailure(program, *failure);
  return static_cast<int>(failure->exit_code);
}

// What StopRequest is to call; empty: signals end the process.
std::mutex stop_mutex;
std::function<void()> stop_request;

bool AskedToStop() {
  const std::lock_guard lock(stop_mutex);
  if (!stop_request) return false;
  stop_request();
  stop_request = nullptr;
  return true;
}

}  // namespace

StopRequest::StopRequest(std::function<void()> stop) {
  const std::lock_guard lock(stop_mutex);
  stop_request = std::move(stop);
}

StopRequest::~StopRequest() {
  const std::lock_guard lock(stop_mutex);
  stop_request = nullptr;
}

void CleanUpWhenEnded() {
  sigset_t ending;
  sigemptyset(&ending);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGXCPU}) {
    // What the caller had ignored (nohup) stays ignored.
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    if (before.sa_handler != SIG_IGN) sigaddset(&ending, signal);
  }
  pthread_sigmask(SIG_BLOCK, &ending, nullptr);  // in this thread and in all that it starts
  const auto clean_up = [ending] {
    int signal = 0;
    do {
      sigwait(&ending, &signal);
    } while ((signal == SIGINT || signal == SIGTERM || signal == SIGHUP) && AskedToStop());
    RemoveUncommitted();
    std::signal(signal, SIG_DFL);
    pthread_sigmask(SIG_UNBLOCK, &ending, nullptr);
    std::raise(signal);
  };
  try {
    std::thread(clean_up).detach();
  } catch (const std::system_error&) {
    // No further process or thread is allowed: signals end the program as they always do, and what
    // is half-written stays under its hidden name.
    pthread_sigmask(SIG_UNBLOCK, &ending, nullptr);
  }
}

void KeepFreedMemory() {
#ifdef __GLIBC__
  constexpr int kBlock_bytes = 32 << 20;  // glibc takes no more
  constexpr int kKept_bytes = 128 << 20;
  constexpr int kAtOnce_bytes = 16 << 20;
  ::mallopt(M_MMAP_THRESHOLD, kBlock_bytes);
  ::mallopt(M_TRIM_THRESHOLD, kKept_bytes);
  ::mallopt(M_TOP_PAD, kAtOnce_bytes);
#endif
}

int OnLargeStack(const std::function<int()>& task) {
  constexpr std::size_t kStackBytes = std::size_t{16} << 20;
  struct Work {
    const std::function<int()>& task;
    int result;
  } work{task, 0};
  pthread_attr_t attributes;
  pthread_t thread;
  bool started = false;
  if (pthread_attr_init(&attributes) == 0) {
    const auto run = [](void* of) -> void* {
      auto* const its = static_cast<Work*>(of);
      its->result = its->task();
      return nullptr;
    };
    started = pthread_attr_setstacksize(&attributes, kStackBytes) == 0 &&
              pthread_create(&thread, &attributes, run, &work) == 0;
    pthread_attr_destroy(&attributes);
  }
  if (!started) return task();
  pthread_join(thread, nullptr);
  return work.result;
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
