#include "tools/cli/command_line.h"

#include <fmt/ranges.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <boost/program_options.hpp>
#include <charconv>
#include <cstdio>
#include <future>
#include <system_error>
#include <thread>

#include "model/core/errors.h"
#include "model/core/foreign_text.h"
#include "model/core/nearest_name.h"
#include "model/core/run_record.h"
#include "tools/cli/assignments.h"
#include "tools/cli/help_text.h"
#include "tools/cli/number_range.h"
#include "tools/cli/shell_word.h"
#include "tools/cli/split.h"
#include "tools/cli/text_table.h"

namespace po = boost::program_options;

namespace lipoid::cli {
namespace {

constexpr int kMaxThreads = 4096;

std::uint64_t ParseSeed(const std::string& shown, const std::string& text) {
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (error != std::errc{} || end != text.data() + text.size()) {
    throw OptionError(
        fmt::format("option {}: expected a whole number of at least 0, found '{}'", shown, text));
  }
  return seed;
}

// How many of the threads that there are cores for may be started: `ulimit -u` or a container may
// allow none, and a thread pool that gets fewer than it asks for ends the program.
int ThreadsAllowed() {
  const int wanted = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  std::vector<std::thread> started;
  std::promise<void> all;
  const std::shared_future<void> end = all.get_future().share();
  try {
    for (int k = 1; k < wanted; ++k) started.emplace_back([end] { end.wait(); });
  } catch (const std::system_error&) {  // so many, and no more
  }
  all.set_value();
  for (std::thread& thread : started) thread.join();
  return static_cast<int>(started.size()) + 1;
}

// An empty text is a shell variable that was not set, and not the same as an option that is not given.
const std::string& NotEmpty(const std::string& shown,
                            std::string_view word,
                            const std::string& text) {
  if (text.empty()) throw OptionError(fmt::format("option {}: expected {}, found ''", shown, word));
  return text;
}

// The last of two would win without a word.
void RefuseTwice(bool twice, std::string_view option) {
  if (twice) throw OptionError(fmt::format("option {} is given twice; give it once", option));
}

template <class Value>
void AddTo(std::map<std::string, Value>& values,
           const std::string& shown,
           const std::string& name,
           Value value) {
  RefuseTwice(!values.emplace(name, std::move(value)).second, fmt::format("{} {}", shown, name));
}

}  // namespace

struct CommandLine::Threads {
  explicit Threads(int count)
      : control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(count)) {}
  tbb::global_control control;
};

CommandLine::CommandLine(const Command& command, std::vector<std::string> arguments)
    : command_(command),
      arguments_(std::move(arguments)),
      progress_(std::make_unique<Progress>(false)) {
  Text("summary", summary_file_, "FILE", "write the results as JSON, also when the command fails");
  Declare("seed", "a whole number", "0", "seed of everything random").set =
      [this](const std::string& shown, const std::string& text) { seed_ = ParseSeed(shown, text); };
  Declare("threads", fmt::format("1 .. {}", kMaxThreads), "all cores", "how many threads may run")
      .set = [this](const std::string& shown, const std::string& text) {
    options_internal::FromText(shown, text, Range{1, kMaxThreads}, threads_);
  };
  Flag("quiet", quiet_, "no messages and no progress bar, only data and errors");
  Texts(
      "set", assignments_, "OPTION=VALUE", "set one option by its name, several times if need be");
  options_.back()->several = false;  // one word each: the next may be an argument
  Flag("help,h", help_, "this text");
  for (auto& option : options_) option->common = true;
}

CommandLine::~CommandLine() = default;

void CommandLine::Describe(std::string_view what, std::string_view example) {
  what_ = what;
  Example(example);
}

void CommandLine::Argument(std::string_view name, std::string& value, std::string_view help) {
  Positional& argument = positionals_.emplace_back();
  argument.name = name;
  argument.help = help;
  argument.one = &value;
}

void CommandLine::Arguments(std::string_view name,
                            std::vector<std::string>& values,
                            std::string_view help,
                            std::size_t at_least) {
  Positional& argument = positionals_.emplace_back();
  argument.name = name;
  argument.help = help;
  argument.several = true;
  argument.required = at_least > 0;
  argument.rest = &values;
  argument.at_least = at_least;
}

void CommandLine::InputArgument(std::string_view name, std::string& value, std::string_view help) {
  Argument(name, value, help);
  positionals_.back().input = true;
}

void CommandLine::InputArguments(std::string_view name,
                                 std::vector<std::string>& values,
                                 std::string_view help,
                                 std::size_t at_least) {
  Arguments(name, values, help, at_least);
  positionals_.back().input = true;
}

void CommandLine::Text(std::string_view name,
                       std::string& value,
                       std::string_view word,
                       std::string_view help) {
  auto& option = Declare(name, word, value, help);
  option.set = [&value, &option](const std::string& shown, const std::string& text) {
    value = NotEmpty(shown, option.value, text);
  };
}

void CommandLine::RequiredText(std::string_view name,
                               std::string& value,
                               std::string_view word,
                               std::string_view help) {
  Text(name, value, word, help);
  options_.back()->required = true;
}

void CommandLine::Input(std::string_view name,
                        std::string& value,
                        std::string_view word,
                        std::string_view help) {
  auto& option = Declare(name, word, value, help);
  option.set = [this, &value, &option](const std::string& shown, const std::string& text) {
    value = NotEmpty(shown, option.value, text);
    files_.AddInput(text);
  };
}

void CommandLine::RequiredInput(std::string_view name,
                                std::string& value,
                                std::string_view word,
                                std::string_view help) {
  Input(name, value, word, help);
  options_.back()->required = true;
}

void CommandLine::Inputs(std::string_view name,
                         std::vector<std::string>& values,
                         std::string_view word,
                         std::string_view help) {
  auto& option = Declare(name, word, "", help);
  option.several = true;
  option.set = [this, &values, &option](const std::string& shown, const std::string& text) {
    values.push_back(NotEmpty(shown, option.value, text));
    files_.AddInput(text);
  };
}

void CommandLine::Texts(std::string_view name,
                        std::vector<std::string>& values,
                        std::string_view word,
                        std::string_view help) {
  auto& option = Declare(name, word, "", help);
  option.several = true;
  option.set = [&values, &option](const std::string& shown, const std::string& text) {
    values.push_back(NotEmpty(shown, option.value, text));
  };
}

void CommandLine::Flag(std::string_view name, bool& value, std::string_view help) {
  Declare(name, "", "", help).set = [&value](const std::string&, const std::string&) {
    value = true;
  };
}

void CommandLine::Output(std::string& value, std::string_view word, std::string_view help) {
  OutputOption("output,o", value, word, help);
  options_.back()->required = true;
}

void CommandLine::ReportOption() {
  can_report_ = true;
  OutputOption("report",
               report_file_,
               "HTML",
               "write the result as one page with plots, to be opened in a browser");
  OutputOption("latex",
               latex_file_,
               "TEX",
               "write the tables of the result for LaTeX, with the rules of booktabs");
}

void CommandLine::OutputOption(std::string_view name,
                               std::string& value,
                               std::string_view word,
                               std::string_view help) {
  auto& option = Declare(name, word, "", help);
  option.set = [this, &value, &option](const std::string& shown, const std::string& text) {
    if (earlier_ != nullptr) return;
    value = OutputPath(NotEmpty(shown, option.value, text));
    for (const std::string_view packed : {".gz", ".zst", ".bz2", ".xz"}) {
      if (!value.ends_with(packed)) continue;
      throw OptionError(
          fmt::format("option {0}: '{1}' is the name of a packed file, and what is written is not "
                      "packed; leave out {2} and pack it afterwards",
                      shown,
                      value,
                      packed));
    }
    files_.AddOutput(option.Shown(), value);
  };
}

CommandLine::Declared& CommandLine::Declare(std::string_view name,
                                            std::string_view word,
                                            std::string_view default_text,
                                            std::string_view help) {
  auto option = std::make_unique<Declared>();
  const auto comma = name.find(',');
  option->name = name.substr(0, comma);
  if (comma != std::string_view::npos) option->letter = name[comma + 1];
  option->value = word;
  option->default_text = default_text;
  option->help = help;
  options_.push_back(std::move(option));
  return *options_.back();
}

void CommandLine::Group(std::string_view prefix,
                        std::vector<OptionDescription> options,
                        std::function<void(std::string_view, std::string_view)> set) {
  groups_.push_back({std::string(prefix), std::move(options), std::move(set)});
}

std::string CommandLine::Dashed(std::string_view name) {
  std::string dashed(name);
  std::replace(dashed.begin(), dashed.end(), '_', '-');
  return dashed;
}

void CommandLine::OfKind(const std::string& name, bool& value, const Names&, const char* help) {
  Declare(name, "", "", help).set = [&value](const std::string& shown, const std::string& text) {
    value = text.empty() || options_internal::ParseBool(shown, text);  // a value comes by --set
  };
}

void CommandLine::OfKind(const std::string& name,
                         std::string& value,
                         const Word& word,
                         const char* help) {
  Text(name, value, word.text, help);
}

void CommandLine::OfKind(const std::string& name,
                         std::vector<std::string>& values,
                         const Word& word,
                         const char* help) {
  auto& option = Declare(name, word.text, fmt::format("{}", fmt::join(values, ",")), help);
  option.several = word.several;
  option.set = [&values, first = true, expected = word.text](const std::string& shown,
                                                             const std::string& text) mutable {
    if (std::exchange(first, false)) values.clear();
    for (std::string& piece : SplitAt(text, ',')) {
      if (piece.empty())
        throw OptionError(fmt::format("option {}: expected {}, found '{}'", shown, expected, text));
      values.push_back(std::move(piece));
    }
  };
}

void CommandLine::OfKind(const std::string& name,
                         std::vector<double>& values,
                         const Range& valid,
                         const char* help) {
  Declare(name,
          "LIST",
          fmt::format("{}", fmt::join(values, ",")),
          fmt::format("{}; each {}", help, options_internal::DescribeValid<double>(valid)))
      .set = [&values, valid, name](const std::string&, const std::string& text) {
    values.clear();
    for (const std::string& piece : SplitAt(text, ',')) {
      const std::vector<double> some = ReadRange(name, piece, valid);
      values.insert(values.end(), some.begin(), some.end());
    }
  };
}

void CommandLine::OfKind(const std::string& name,
                         std::map<std::string, double>& values,
                         const Word& word,
                         const char* help) {
  auto& option = Declare(name, word.text, "", help);
  option.several = true;
  option.set = [&values](const std::string& shown, const std::string& text) {
    for (const auto& [parameter, value] : ParseAssignments(shown, {text}))
      AddTo(values, shown, parameter, value);
  };
}

void CommandLine::OfKind(const std::string& name,
                         std::map<std::string, std::string>& values,
                         const Word& word,
                         const char* help) {
  auto& option = Declare(name, word.text, "", help);
  option.several = true;
  option.set = [&values, expected = word.text](const std::string& shown, const std::string& text) {
    const auto equals = text.find('=');
    if (equals == std::string::npos)
      throw OptionError(fmt::format("option {}: expected {}, found '{}'", shown, expected, text));
    AddTo(values, shown, text.substr(0, equals), text.substr(equals + 1));
  };
}

void CommandLine::OfKind(const std::string& name,
                         std::map<std::string, Ends>& values,
                         const Word& word,
                         const char* help) {
  auto& option = Declare(name, word.text, "", help);
  option.several = true;
  option.set = [&values](const std::string& shown, const std::string& text) {
    for (const auto& [parameter, ends] : ParseRanges(shown, {text}))
      AddTo(values, shown, parameter, ends);
  };
}

bool CommandLine::Parse() {
  po::options_description all;
  for (const auto& option : options_) {
    const auto name =
        option->letter == '\0' ? option->name : fmt::format("{},{}", option->name, option->letter);
    if (option->value.empty()) {
      all.add_options()(name.c_str(), "");
    } else if (option->several) {
      all.add_options()(name.c_str(), po::value<std::vector<std::string>>()->multitoken());
    } else {
      all.add_options()(name.c_str(), po::value<std::string>());
    }
  }
  // No guessing: an option added later must not change what an abbreviation means.
  constexpr int kStyle =
      po::command_line_style::unix_style & ~po::command_line_style::allow_guessing;
  std::vector<po::option> parsed;
  try {
    parsed = po::command_line_parser(arguments_).options(all).style(kStyle).run().options;
  } catch (const po::unknown_option& error) {
    std::vector<std::string> known;
    for (const auto& option : options_) known.push_back("--" + option->name);
    throw OptionError(UnknownName("option", error.get_option_name(), known));
  } catch (const po::invalid_command_line_syntax& error) {
    if (error.kind() == po::invalid_command_line_syntax::extra_parameter) {
      throw OptionError(fmt::format("option {} takes no value; leave out '=' and what follows",
                                    error.get_option_name()));
    }
    throw OptionError(
        fmt::format("option {}: expected a value, found none", error.get_option_name()));
  } catch (const po::error& error) {
    throw OptionError(error.what());
  }

  std::vector<std::string> words;
  for (const auto& [key, position, values, tokens, unregistered, insensitive] : parsed) {
    if (key.empty()) {
      words.insert(words.end(), values.begin(), values.end());
      continue;
    }
    for (auto& option : options_) {
      if (key != option->name && key != fmt::format("-{}", option->letter)) continue;
      const bool repeatable = option->several || option->value.empty() || option->name == "set";
      const std::string shown = "--" + option->name;
      RefuseTwice(option->given && !repeatable, shown);
      option->given = true;
      if (option->value.empty()) option->set(shown, "");
      for (const auto& value : values) option->set(shown, value);
    }
  }
  if (help_) {
    output_ = HelpText(Description());
    return false;
  }
  for (const auto& assignment : assignments_) SetOne(assignment);
  AssignArguments(words);
  for (const auto& option : options_) {
    if (option->required && !option->given) {
      throw OptionError(
          fmt::format("option {} {} is missing: {}", option->Shown(), option->value, option->help));
    }
  }
  if (earlier_ != nullptr) {
    summary_file_.clear();
    report_file_ = "-";
    quiet_ = true;
    files_.CheckInputsOf(*earlier_);
  }
  if (!summary_file_.empty()) files_.AddOutput("--summary", OutputPath(summary_file_));
  files_.CheckNothingIsLost();
  if (!report_file_.empty()) RequireReport();
  files_.CheckOutputsAreWritable();
  const int allowed = ThreadsAllowed();
  if (allowed < static_cast<int>(std::thread::hardware_concurrency())) {
    // Never lifted, not even at the end: then the pool would start the threads that it lacked.
    static const Threads* const all_that_may_be = new Threads(allowed);
    (void)all_that_may_be;
  }
  if (threads_ > 0) threads_limit_ = std::make_unique<Threads>(threads_);
  progress_ = std::make_unique<Progress>(!quiet_);
  parsed_ = true;
  return true;
}

void CommandLine::SetOne(const std::string& assignment) {
  const auto equals = assignment.find('=');
  if (equals == std::string::npos) {
    throw OptionError(fmt::format("option --set: expected OPTION=VALUE, found '{}'", assignment));
  }
  const auto name = assignment.substr(0, equals);
  const std::string value = assignment.substr(equals + 1);
  std::vector<std::string> known;
  for (const auto& option : options_) {
    if (!option->by_set) continue;
    known.push_back(option->name);
    std::replace(known.back().begin(), known.back().end(), '-', '_');
    if (known.back() != name) continue;
    RefuseTwice(option->given && !option->several, name);
    option->given = true;
    return option->set(name, value);
  }
  for (auto& group : groups_) {
    for (const auto& option : group.options) {
      known.push_back(group.FullName(option));
      if (known.back() != name) continue;
      RefuseTwice(!group.given.insert(name).second, name);
      return group.set(option.name, value);
    }
  }
  throw OptionError("option --set: " + UnknownName("option", name, known));
}

void CommandLine::AssignArguments(const std::vector<std::string>& words) {
  std::size_t next = 0;
  for (const auto& positional : positionals_) {
    const auto left = words.size() - next;
    if (left < positional.at_least) {
      throw OptionError(fmt::format("{} is missing: {}", positional.name, positional.help));
    }
    const std::size_t first = next;
    if (positional.one != nullptr) {
      *positional.one = words[next++];
    } else {
      positional.rest->assign(words.begin() + static_cast<std::ptrdiff_t>(next), words.end());
      next = words.size();
    }
    for (std::size_t k = first; k < next; ++k) {
      if (words[k].empty()) {
        throw OptionError(
            fmt::format("{} is an empty text; expected {}", positional.name, positional.help));
      }
      if (positional.input) files_.AddInput(words[k]);
    }
  }
  if (next < words.size()) {
    throw OptionError(fmt::format("'{}' is one argument too many", words[next]));
  }
}

void CommandLine::AddInputs(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) files_.AddInput(path);
  if (earlier_ != nullptr) files_.CheckInputsOf(*earlier_);
  files_.CheckNothingIsLost();
}

void CommandLine::AddOutputs(std::string_view shown, const std::vector<std::string>& paths) {
  if (earlier_ == nullptr) files_.AddOutputs(shown, paths);
}

void CommandLine::CommitOutputs() {
  if (earlier_ != nullptr) return;
  for (const std::string& name : files_.Commit()) {
    Message("'{}' had other names (hard links): they keep the old file, this name has the new one",
            name);
  }
}

std::string CommandLine::CommandText() const {
  std::string text = fmt::format("lipoid {}", command_.name);
  for (const auto& argument : arguments_) {
    text += " " + ShellWord(argument);
  }
  return text;
}

Json CommandLine::RunJson() const {
  return {{"arguments", arguments_},
          {"seed", seed_},
          {"version", Version()},
          {"commit", GitCommit()},
          {"inputs", files_.InputsToJson()}};
}

bool CommandLine::Given(std::string_view name) const {
  const auto option = std::find_if(options_.begin(), options_.end(), [&](const auto& candidate) {
    return candidate->name == name;
  });
  Require(option != options_.end(), "a declared option");
  return (*option)->given;
}

bool CommandLine::Sets(std::string_view prefix) const {
  return std::any_of(assignments_.begin(), assignments_.end(), [&](const std::string& one) {
    return one.starts_with(prefix);
  });
}

std::FILE* CommandLine::OutputStream() const {
  if (!parsed_ || !files_.WriteToStandardOutput()) return stdout;
  return quiet_ ? nullptr : stderr;
}

void CommandLine::WriteMessage(std::string text) {
  progress_->Wipe();
  text = ForeignLines(text);
  if (ErrorIsTerminal()) text = WrappedLines(text);
  text += '\n';
  std::fwrite(text.data(), 1, text.size(), stderr);
}

CommandDescription CommandLine::Description() const {
  CommandDescription description{.name = std::string(command_.name),
                                 .summary = std::string(command_.summary),
                                 .what = what_,
                                 .examples = examples_,
                                 .arguments = {},
                                 .options = {},
                                 .settings = {}};
  for (const auto& positional : positionals_) description.arguments.push_back(positional);
  for (const auto& option : options_) description.options.push_back(*option);
  for (const auto& group : groups_) {
    for (const auto& option : group.options) {
      description.settings.push_back({.name = group.FullName(option),
                                      .help = option.help,
                                      .valid = option.valid,
                                      .default_text = option.default_text});
    }
  }
  return description;
}

std::vector<CommandDescription> DescribeCommands(std::span<const Command> commands) {
  std::vector<CommandDescription> all;
  for (const auto& command : commands) {
    CommandLine line(command, {"--help"});
    static_cast<void>(command.run(line));
    all.push_back(line.Description());
  }
  return all;
}

}  // namespace lipoid::cli
