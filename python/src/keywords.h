#pragma once

/// @file
/// The keyword arguments of a function, declared as commands declare their options
/// (tools/cli/command_line.h) and with the same names, a dash being an underscore. Values go through
/// the same checks as text of the command line (model/core/options.h), so that ranges and messages
/// are the same.
///
///   Keywords keywords(given);
///   keywords.Option("branches", branches, Range{0, 5}, "resistor-capacitor branches");
///   keywords.Group("pulses", options.pulses);  // pulses={"terms": 20}
///   keywords.Finish();                         // what is left over is unknown
///
/// Without arguments they are only described: docstrings and stubs are made from that.

#include <nanobind/nanobind.h>

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/battery/cell_source.h"
#include "model/core/option_kinds.h"
#include "model/core/options.h"

namespace lipoid::python {

namespace nb = nanobind;

/// A name of the command line as Python has it: alpha_C of "alpha-C".
[[nodiscard]] std::string PythonName(std::string_view name);

class Keywords {
 public:
  Keywords() = default;  ///< only to be described
  explicit Keywords(nb::dict given) : given_(std::move(given)) {}

  template <class T, class Valid>
  void Option(std::string_view name, T& value, const Valid& valid, std::string_view help) {
    Declare(name,
            options_internal::Describe<T>(name, options_internal::ToText(value), valid, help),
            false,
            [&](const std::string& shown, const std::string& text) {
              options_internal::FromText(shown, text, valid, value);
            });
  }
  /// The same, where not giving it, or None, means something.
  template <class T, class Valid>
  void Option(std::string_view name,
              std::optional<T>& value,
              const Valid& valid,
              std::string_view help) {
    Declare(name,
            options_internal::Describe<T>(
                name, value ? options_internal::ToText(*value) : "None", valid, help),
            true,
            [&](const std::string& shown, const std::string& text) {
              options_internal::FromText(shown, text, valid, value.emplace());
            });
  }
  void Flag(std::string_view name, bool& value, std::string_view help) {
    Option(name, value, Names{}, help);
  }
  void Text(std::string_view name,
            std::string& value,
            std::string_view word,
            std::string_view help);

  /// An argument that is no single value: the object as given, or none. `type` is for stubs; without
  /// a default, None is one of its values.
  [[nodiscard]] std::optional<nb::object> Take(std::string_view name,
                                               std::string_view type,
                                               std::string_view help,
                                               std::string_view valid = "",
                                               std::string_view default_text = "");

  /// Options of a struct: {"terms": 20}.
  template <class Options>
  void Group(std::string_view name, Options& options) {
    Group(
        name, DescribeOptions<Options>(), [&options](std::string_view key, std::string_view text) {
          SetOption(options, key, text);
        });
  }
  void Group(std::string_view name,
             const std::vector<OptionDescription>& options,
             const std::function<void(std::string_view, std::string_view)>& set);

  /// For EachGroup() of a struct. A group whose name is an option, too, is called NAME_fit.
  auto Groups() {
    return [this](std::string_view name, auto& options) { Group(GroupName(name), options); };
  }

  /// For a Visit: each option by itself; model/core/option_kinds.h has what they may be.
  auto EachOne() {
    return [this](std::string_view name, auto& member, const auto& valid, const char* help) {
      OfKind(name, member, valid, help);
    };
  }
  /// Options of a struct, each by itself.
  template <class Options>
  void Each(Options& options) {
    Options::Visit(options, EachOne());
  }

  /// Whether it was given, and not as None.
  [[nodiscard]] bool Has(std::string_view name) const {
    return Given(PythonName(name)).has_value();
  }

  /// OptionError for what no declaration took.
  void Finish() const;

  /// name, type, default, valid, help; of a group its options instead of valid.
  [[nodiscard]] nb::list Described() const { return described_; }

 private:
  /// Of what is no path, which Finish() refuses: "".
  [[nodiscard]] std::string PathGiven(const std::string& name,
                                      nb::handle path,
                                      std::string_view wanted);
  [[nodiscard]] std::string GroupName(std::string_view name) const;
  template <class T, class Valid>
  void OfKind(std::string_view name, T& value, const Valid& valid, std::string_view help) {
    Option(name, value, valid, help);
  }
  void OfKind(std::string_view name, std::string& value, const Word& word, std::string_view help) {
    Text(name, value, word.text, help);
  }
  void OfKind(std::string_view name, InputFile& value, const Word& word, std::string_view help);
  void OfKind(std::string_view name, CellSource& value, const Word& word, std::string_view help);
  void OfKind(std::string_view name,
              std::vector<std::string>& values,
              const Word& word,
              std::string_view help);
  void OfKind(std::string_view name,
              std::vector<double>& values,
              const Range& valid,
              std::string_view help);
  void OfKind(std::string_view name,
              std::map<std::string, double>& values,
              const Word& word,
              std::string_view help);
  void OfKind(std::string_view name,
              std::map<std::string, std::string>& values,
              const Word& word,
              std::string_view help);
  void OfKind(std::string_view name,
              std::map<std::string, Ends>& values,
              const Word& word,
              std::string_view help);

  void Declare(std::string_view name,
               const OptionDescription& option,
               bool or_none,
               const std::function<void(const std::string&, const std::string&)>& set);
  [[nodiscard]] std::optional<nb::object> Given(const std::string& name) const;

  nb::dict given_;
  nb::list described_;
  std::vector<std::string> known_;
  std::vector<std::pair<std::string, std::string>> within_;    // option of a group, its group
  std::vector<std::pair<std::string, std::string>> no_paths_;  // option, what is wrong with it
};

/// A value of Python as the text that the command line would have: 2, 0.5, true, joint.
[[nodiscard]] std::string TextOf(const std::string& name, nb::handle value);

}  // namespace lipoid::python
