#pragma once

/// @file
/// What a command sees of the command line: it declares its arguments and options, parses, and has
/// places for its results.
///
///   ExitCode Validate(CommandLine& line) {
///     std::string cell;
///     double initial_soc = 1.0;
///     line.Describe("Predicts the voltage of logs.", "lipoid validate gifi-600mAh-1 cc_1C.csv");
///     line.Argument("CELL", cell, "a cell file, or the name of a shipped cell");
///     line.Option("initial-soc", initial_soc, Range{-0.1, 1.1}, "state of charge at the start");
///     line.Group("pulses", pulse_options);       // --set pulses.branches=2, all of them in --help
///     if (!line.Parse()) return ExitCode::kDone;  // --help was printed
///     ...
///     line.summary()["logs"] = ...;
///     line.Print("{}", table.Text());
///     return ExitCode::kDone;
///   }
///
/// Nothing is lost: every file that is read is declared as an input, every file that is written as
/// an output; those that show only when a campaign or a folder was read are added by AddInputs()
/// and AddOutputs(), before anything is computed. run_files.h says how an
/// output is kept from replacing an input.
///
/// Wrong input is thrown as LoadError, wrong options as OptionError; Run() turns them into exit
/// codes and messages. Common to all commands: --summary, --seed, --threads, --quiet, --set,
/// --help. Tests: tests/tools/.

#include <fmt/format.h>

#include <concepts>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/core/errors.h"
#include "model/core/json.h"
#include "model/core/option_kinds.h"
#include "model/core/options.h"
#include "tools/cli/command_description.h"
#include "tools/cli/progress.h"
#include "tools/cli/run_files.h"
#include "tools/report/report.h"

namespace lipoid::cli {

enum class ExitCode {
  kDone = 0,
  kIncomplete = 1,  ///< not converged, or not completed
  kUsage = 2,
  kBadInput = 3,
  kInternal = 4,  ///< a mistake of lipoid
};

class CommandLine;

struct Command {
  std::string_view name;
  std::string_view summary;  ///< one line for `lipoid --help`
  ExitCode (*run)(CommandLine&);
};

class CommandLine {
 public:
  CommandLine(const Command& command, std::vector<std::string> arguments);
  ~CommandLine();

  // Declaration: all before Parse().

  /// What the command does, and an example to type; more examples by further calls of Example().
  void Describe(std::string_view what, std::string_view example);
  void Example(std::string_view example) { examples_.emplace_back(example); }

  /// A word that must be there; in the order of declaration.
  void Argument(std::string_view name, std::string& value, std::string_view help);
  /// The same of a file that is read.
  void InputArgument(std::string_view name, std::string& value, std::string_view help);
  /// The words that remain, at least so many.
  void Arguments(std::string_view name,
                 std::vector<std::string>& values,
                 std::string_view help,
                 std::size_t at_least = 1);
  /// The same of files that are read.
  void InputArguments(std::string_view name,
                      std::vector<std::string>& values,
                      std::string_view help,
                      std::size_t at_least = 1);

  /// --name VALUE, checked as in model/core/options.h. `name` may end in a letter: "output,o".
  template <class T, class Valid>
  void Option(std::string_view name, T& value, const Valid& valid, std::string_view help) {
    Declare(name, options_internal::DescribeValid<T>(valid), options_internal::ToText(value), help)
        .set = [&value, valid](const std::string& shown, const std::string& text) {
      options_internal::FromText(shown, text, valid, value);
    };
  }
  /// The same, where not giving it means something.
  template <class T, class Valid>
  void Option(std::string_view name,
              std::optional<T>& value,
              const Valid& valid,
              std::string_view help) {
    Declare(name,
            options_internal::DescribeValid<T>(valid),
            value ? options_internal::ToText(*value) : "",
            help)
        .set = [&value, valid](const std::string& shown, const std::string& text) {
      options_internal::FromText(shown, text, valid, value.emplace());
    };
  }
  /// --name WORD, free text; `word` says in help what is expected: "FILE".
  void Text(std::string_view name,
            std::string& value,
            std::string_view word,
            std::string_view help);
  /// The same, and it must be given.
  void RequiredText(std::string_view name,
                    std::string& value,
                    std::string_view word,
                    std::string_view help);
  /// --name WORD..., several words at once or the option several times.
  void Texts(std::string_view name,
             std::vector<std::string>& values,
             std::string_view word,
             std::string_view help);
  /// --name, without a value.
  void Flag(std::string_view name, bool& value, std::string_view help);
  /// --name FILE, a file that is read: no output may be the same file.
  void Input(std::string_view name,
             std::string& value,
             std::string_view word,
             std::string_view help);
  void RequiredInput(std::string_view name,
                     std::string& value,
                     std::string_view word,
                     std::string_view help);
  /// --name FILE..., files that are read.
  void Inputs(std::string_view name,
              std::vector<std::string>& values,
              std::string_view word,
              std::string_view help);
  /// -o FILE: required; Parse() checks that it can be written and is not one of the inputs. "-"
  /// is standard output.
  void Output(std::string& value, std::string_view word, std::string_view help);
  /// A further file to write, not required, with the same checks: --residuals CSV.
  void OutputOption(std::string_view name,
                    std::string& value,
                    std::string_view word,
                    std::string_view help);

  /// --report HTML and --latex TEX: the result as one page with plots, and its tables for a paper.
  /// Both are written when the command is done.
  void ReportOption();

  /// Before Parse(): the command runs again only for its series, as a page needs them beside a
  /// summary that is there. It is quiet, reads no file but those of the summary's run record, its
  /// options that name outputs do nothing, and what it writes all the same never appears.
  void Replay(const Json& summary) { earlier_ = &summary; }
  [[nodiscard]] const Json* earlier() const { return earlier_; }

  /// Options of a struct (model/core/options.h) for --set prefix.name=value; no dot where prefix is
  /// empty.
  template <class Options>
  void Group(std::string_view prefix, Options& options) {
    Group(prefix,
          DescribeOptions<Options>(),
          [&options](std::string_view name, std::string_view text) {
            SetOption(options, name, text);
          });
  }
  /// The same of a row of a table, which knows its options and sets them.
  void Group(std::string_view prefix,
             std::vector<OptionDescription> options,
             std::function<void(std::string_view name, std::string_view text)> set);
  /// Options of a struct as --name-of-it each, and for --set name_of_it=value too;
  /// model/core/option_kinds.h has what they may be.
  template <class Options>
  void Each(Options& options) {
    const std::size_t first = options_.size();
    Options::Visit(
        options, [this](std::string_view name, auto& member, const auto& valid, const char* help) {
          this->OfKind(Dashed(name), member, valid, help);  // Clang 14 would not see it used
        });
    for (std::size_t k = first; k < options_.size(); ++k) options_[k]->by_set = true;
  }

  /// Reads the command line into the declared variables. False: --help was asked for and is
  /// printed. OptionError where it is not right.
  [[nodiscard]] bool Parse();
  [[nodiscard]] bool parsed() const { return parsed_; }

  // After Parse().

  /// The command as typed, for run records.
  [[nodiscard]] std::string CommandText() const;
  [[nodiscard]] std::uint64_t seed() const { return seed_; }
  /// Whether the option was given ("initial-soc").
  [[nodiscard]] bool Given(std::string_view name) const;
  /// Whether --set names an option that begins so: "sensors.".
  [[nodiscard]] bool Sets(std::string_view prefix) const;

  /// What was declared (command_description.h).
  [[nodiscard]] CommandDescription Description() const;

  /// Further files that are read: logs that a campaign names, files of a folder. OptionError where
  /// one of them is an output. Files that are not there are no inputs.
  void AddInputs(const std::vector<std::string>& paths);
  /// Further files that are written, for the option shown ("-o"): files of a folder. OptionError
  /// where one is an input or another output, or cannot be written.
  void AddOutputs(std::string_view shown, const std::vector<std::string>& paths);
  /// All that is read so far.
  [[nodiscard]] const std::vector<std::string>& inputs() const { return files_.inputs(); }
  /// What was written so far appears now and not at the end: for a command whose later files do not
  /// belong to the earlier ones. Says where a file had other names (hard links).
  void CommitOutputs();

  /// Results for --summary; docs/formats.md has the keys.
  [[nodiscard]] Json& summary() { return summary_; }

  /// How the summary was made, for those who take it up again: arguments, seed, version, and the
  /// inputs with their SHA-256.
  [[nodiscard]] Json RunJson() const;
  /// Whether ReportOption() was called.
  [[nodiscard]] bool can_report() const { return can_report_; }
  /// SHA-256 of inputs that the command knows anyway, in their order: they are not read again.
  void AddHashes(const std::vector<std::string>& files, const std::vector<std::string>& sha256) {
    files_.AddHashes(files, sha256);
  }

  /// Where --report asks for a page: "" where it does not, and no series need be made.
  [[nodiscard]] const std::string& report_file() const { return report_file_; }
  [[nodiscard]] const std::string& latex_file() const { return latex_file_; }
  /// What the charts of the page need beside the summary.
  [[nodiscard]] std::vector<Series>& report_series() { return report_series_; }

  /// Data for standard output. Kept until the command is done: a command that fails prints nothing.
  template <class... Args>
  void Print(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(output_), format, std::forward<Args>(args)...);
  }
  [[nodiscard]] const std::string& output() const { return output_; }
  /// Where it goes: to standard error like a message, null where that is silent, if a file of this command is
  /// standard output.
  [[nodiscard]] std::FILE* OutputStream() const;

  /// A message on standard error, silenced by --quiet.
  template <class... Args>
  void Message(fmt::format_string<Args...> format, Args&&... args) {
    messages_.push_back(fmt::format(format, std::forward<Args>(args)...));
    if (!quiet_) WriteMessage(messages_.back());
  }
  /// All messages so far, for a summary: also those that --quiet silenced.
  [[nodiscard]] const std::vector<std::string>& messages() const { return messages_; }
  /// Wrong input that does not stop the command; --quiet does not silence it.
  void Problem(const LoadError& error) { WriteMessage(error.what()); }
  [[nodiscard]] Progress& progress() { return *progress_; }

 private:
  struct Declared : DescribedOption {
    bool by_set = false;  // for --set, too
    bool given = false;
    std::function<void(const std::string& shown, const std::string& text)> set;
  };
  struct Positional : CommandDescription::Argument {
    std::string* one = nullptr;
    std::vector<std::string>* rest = nullptr;
    std::size_t at_least = 1;
    bool input = false;
  };
  struct OptionGroup {
    std::string prefix;
    std::vector<OptionDescription> options;
    std::function<void(std::string_view, std::string_view)> set;
    std::set<std::string> given = {};  // by their full names

    [[nodiscard]] std::string FullName(const OptionDescription& option) const {
      return prefix.empty() ? option.name : prefix + "." + option.name;
    }
  };

  Declared& Declare(std::string_view name,
                    std::string_view word,
                    std::string_view default_text,
                    std::string_view help);
  /// --name-of-it of name_of_it.
  [[nodiscard]] static std::string Dashed(std::string_view name);
  template <class T, class Valid>
  void OfKind(const std::string& name, T& value, const Valid& valid, const char* help) {
    Option(name, value, valid, help);
  }
  void OfKind(const std::string& name, bool& value, const Names&, const char* help);
  void OfKind(const std::string& name, std::string& value, const Word& word, const char* help);
  template <std::derived_from<InputFile> File>
  void OfKind(const std::string& name, File& value, const Word& word, const char* help) {
    Input(name, value.path, word.text, help);
  }
  void OfKind(const std::string& name,
              std::vector<std::string>& values,
              const Word& word,
              const char* help);
  void OfKind(const std::string& name,
              std::vector<double>& values,
              const Range& valid,
              const char* help);
  void OfKind(const std::string& name,
              std::map<std::string, double>& values,
              const Word& word,
              const char* help);
  void OfKind(const std::string& name,
              std::map<std::string, std::string>& values,
              const Word& word,
              const char* help);
  void OfKind(const std::string& name,
              std::map<std::string, Ends>& values,
              const Word& word,
              const char* help);
  void SetOne(const std::string& assignment);
  void AssignArguments(const std::vector<std::string>& words);
  void WriteMessage(std::string text);

  const Command& command_;
  std::vector<std::string> arguments_;
  std::vector<std::string> messages_;
  std::string what_;
  std::vector<std::string> examples_;
  std::vector<std::unique_ptr<Declared>> options_;
  std::vector<Positional> positionals_;
  std::vector<OptionGroup> groups_;

  std::string summary_file_;
  std::string report_file_;
  std::string latex_file_;
  bool can_report_ = false;
  const Json* earlier_ = nullptr;
  std::vector<Series> report_series_;
  std::uint64_t seed_ = 0;
  int threads_ = 0;
  bool quiet_ = false;
  bool help_ = false;
  bool parsed_ = false;
  std::vector<std::string> assignments_;
  RunFiles files_;

  Json summary_ = Json::object();
  std::string output_;
  std::unique_ptr<Progress> progress_;
  struct Threads;
  std::unique_ptr<Threads> threads_limit_;
};

/// Asks every command of the table: each is run as far as its own --help.
[[nodiscard]] std::vector<CommandDescription> DescribeCommands(std::span<const Command> commands);

}  // namespace lipoid::cli
