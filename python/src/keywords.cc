#include "python/src/keywords.h"

#include <fmt/format.h>
#include <nanobind/stl/string.h>

#include <algorithm>

#include "model/core/errors.h"
#include "model/core/nearest_name.h"
#include "python/src/cell.h"
#include "python/src/convert.h"

namespace lipoid::python {
namespace {

std::string TypeName(nb::handle value) {
  return nb::cast<std::string>(nb::str(nb::type_name(value.type())));
}

// Of any object: what is no UTF-8 is shown by its escapes.
std::string ShownValue(nb::handle value) {
  const nb::object text = nb::repr(value);
  const auto bytes = nb::cast<nb::bytes>(text.attr("encode")("utf-8", "backslashreplace"));
  return {bytes.c_str(), bytes.size()};
}

constexpr const char* kOfFit = "_fit";  // a group whose name is an option, too

double NumberOf(const std::string& name, nb::handle value) {
  return options_internal::ParseDouble(name, TextOf(name, value), Range{});
}

// For stubs.
std::string TypeOf(const OptionDescription& option) {
  switch (option.kind) {
    case OptionKind::kNumber:
      return "float";
    case OptionKind::kInteger:
      return "int";
    case OptionKind::kTruth:
      return "bool";
    case OptionKind::kNumbers:
      return "str | float | Sequence[float]";
    case OptionKind::kText:
      return "str";
    case OptionKind::kChoice:
      break;
  }
  std::string type = "Literal[\"" + option.valid + "\"]";
  for (auto at = type.find(" | "); at != std::string::npos; at = type.find(" | "))
    type.replace(at, 3, "\", \"");
  return type;
}

nb::dict DescriptionOf(const std::string& name,
                       const OptionDescription& option,
                       bool or_none = false) {
  nb::dict one;
  one["name"] = name;
  one["type"] = TypeOf(option) + (or_none ? " | None" : "");
  one["default"] = option.default_text;
  one["valid"] = option.valid;
  one["help"] = option.help;
  return one;
}

}  // namespace

std::string PythonName(std::string_view name) {
  std::string python(name);
  std::replace(python.begin(), python.end(), '-', '_');
  return python;
}

std::string Utf8Of(const std::string& name, nb::handle text) {
  Py_ssize_t size = 0;
  const char* const bytes = PyUnicode_AsUTF8AndSize(text.ptr(), &size);
  if (bytes != nullptr) return {bytes, static_cast<std::size_t>(size)};
  PyErr_Clear();
  throw OptionError(
      fmt::format("option {}: expected text of UTF-8, found {}", name, ShownValue(text)));
}

std::string TextOf(const std::string& name, nb::handle value) {
  if (nb::isinstance<nb::bool_>(value)) return nb::cast<bool>(value) ? "true" : "false";
  if (nb::isinstance<nb::str>(value)) return Utf8Of(name, value);
  if (nb::isinstance<nb::int_>(value)) return nb::cast<std::string>(nb::str(value));
  if (nb::isinstance<nb::float_>(value)) return ShownValue(nb::float_(value));
  // The numbers and truths of NumPy.
  if (nb::hasattr(value, "item") && nb::hasattr(value, "ndim") &&
      nb::cast<int>(value.attr("ndim")) == 0)
    return TextOf(name, value.attr("item")());
  throw OptionError(
      fmt::format("option {}: expected a number, a text or a truth value, found {} ({})",
                  name,
                  ShownValue(value),
                  TypeName(value)));
}

// One number, or those of a sequence. What has a length and is none, bytes or a dict, is refused as one.
std::vector<double> NumbersOf(const std::string& name, nb::handle value, const Range& valid) {
  std::vector<double> numbers;
  const auto add = [&](nb::handle one) {
    numbers.push_back(options_internal::ParseDouble(name, TextOf(name, one), valid));
  };
  const bool one = nb::isinstance<nb::str>(value) || nb::isinstance<nb::bytes>(value) ||
                   nb::isinstance<nb::dict>(value) || !nb::hasattr(value, "__len__") ||
                   (nb::hasattr(value, "ndim") && nb::cast<int>(value.attr("ndim")) == 0);
  if (one) {
    add(value);
    return numbers;
  }
  for (const nb::handle each : nb::borrow<nb::object>(value)) add(each);
  if (numbers.empty())
    throw OptionError(
        fmt::format("option {}: expected at least one number, found {}", name, ShownValue(value)));
  return numbers;
}

std::optional<nb::object> Keywords::Given(const std::string& name) const {
  if (!given_.is_valid() || !given_.contains(name.c_str())) return std::nullopt;
  nb::object value = nb::borrow(given_[name.c_str()]);
  if (value.is_none()) return std::nullopt;
  return value;
}

void Keywords::Declare(std::string_view name,
                       const OptionDescription& option,
                       bool or_none,
                       const std::function<void(const std::string&, const std::string&)>& set) {
  const std::string shown = PythonName(name);
  known_.push_back(shown);
  described_.append(DescriptionOf(shown, option, or_none));
  const auto value = Given(shown);
  if (!value) return;
  const bool numbers = option.kind == OptionKind::kNumbers && !nb::isinstance<nb::str>(*value);
  set(shown,
      numbers ? fmt::format("{}", fmt::join(NumbersOf(shown, *value, Range{}), ","))
              : TextOf(shown, *value));
}

void Keywords::Text(std::string_view name,
                    std::string& value,
                    std::string_view word,
                    std::string_view help) {
  Declare(name,
          {{}, value, std::string(word), std::string(help)},
          false,
          [&](const std::string&, const std::string& text) { value = text; });
}

std::optional<nb::object> Keywords::Take(std::string_view name,
                                         std::string_view type,
                                         std::string_view help,
                                         std::string_view valid,
                                         std::string_view default_text) {
  const std::string shown = PythonName(name);
  known_.push_back(shown);
  nb::dict one;
  one["name"] = shown;
  one["type"] = std::string(type) + (default_text.empty() ? " | None" : "");
  one["default"] = std::string(default_text.empty() ? "None" : default_text);
  one["valid"] = std::string(valid);
  one["help"] = std::string(help);
  described_.append(one);
  return Given(shown);
}

void Keywords::OfKind(std::string_view name,
                      std::map<std::string, double>& values,
                      const Word&,
                      std::string_view help) {
  const std::string shown = PythonName(name);
  const auto given = Take(name, "Mapping[str, float]", help);
  if (!given) return;
  if (!nb::isinstance<nb::dict>(*given))
    throw OptionError(
        fmt::format("option {}: expected {{name: value}}, found {}", shown, ShownValue(*given)));
  for (const auto& [key, value] : nb::cast<nb::dict>(*given)) {
    const auto parameter = Utf8Of(shown, nb::str(key));
    values[parameter] = NumberOf(shown + " " + parameter, value);
  }
}

void Keywords::OfKind(std::string_view name,
                      std::map<std::string, Ends>& values,
                      const Word&,
                      std::string_view help) {
  const std::string shown = PythonName(name);
  const auto given = Take(name, "Mapping[str, tuple[float, float]]", help);
  if (!given) return;
  const auto fail = [&] {
    throw OptionError(fmt::format(
        "option {}: expected {{name: (low, high)}}, found {}", shown, ShownValue(*given)));
  };
  if (!nb::isinstance<nb::dict>(*given)) fail();
  for (const auto& [key, value] : nb::cast<nb::dict>(*given)) {
    const auto parameter = Utf8Of(shown, nb::str(key));
    if (!nb::isinstance<nb::sequence>(value) || nb::len(value) != 2) fail();
    values[parameter] = {NumberOf(shown + " " + parameter, value[0]),
                         NumberOf(shown + " " + parameter, value[1])};
  }
}

void Keywords::OfKind(std::string_view name, InputFile& value, const Word&, std::string_view help) {
  if (const auto file = Take(name, "Path", help))
    value.path = PathGiven(PythonName(name), *file, "a path");
}

void Keywords::OfKind(std::string_view name,
                      CellSource& value,
                      const Word&,
                      std::string_view help) {
  const auto given = Take(name, "Path | Cell", help);
  if (!given) return;
  if (const Cell* const cell = CellBehind(*given)) {
    value.cell = std::make_shared<const Cell>(*cell);
  } else {
    value.path = PathGiven(PythonName(name), *given, "a path or a Cell");
  }
}

std::string Keywords::PathGiven(const std::string& name, nb::handle path, std::string_view wanted) {
  if (nb::isinstance<nb::str>(path) || nb::isinstance<nb::bytes>(path) ||
      nb::hasattr(path, "__fspath__"))
    return PathOf(path);
  // Of the fit of the same name a dictionary is meant, which Finish() knows.
  no_paths_.emplace_back(
      name, fmt::format("option {}: expected {}, found {}", name, wanted, ShownValue(path)));
  return "";
}

void Keywords::OfKind(std::string_view name,
                      std::vector<std::string>& values,
                      const Word&,
                      std::string_view help) {
  const std::string shown = PythonName(name);
  const auto given =
      Take(name, "str | Sequence[str]", help, "", fmt::format("{}", fmt::join(values, ",")));
  if (!given) return;
  values.clear();
  if (nb::isinstance<nb::str>(*given)) {  // as on the command line
    const nb::object pieces = given->attr("split")(",");
    for (const nb::handle word : pieces) values.push_back(Utf8Of(shown, word));
    return;
  }
  if (!nb::hasattr(*given, "__iter__") || nb::isinstance<nb::dict>(*given))
    throw OptionError(
        fmt::format("option {}: expected a text or several, found {}", shown, ShownValue(*given)));
  for (const nb::handle word : *given) values.push_back(TextOf(shown, word));
}

void Keywords::OfKind(std::string_view name,
                      std::vector<double>& values,
                      const Range& valid,
                      std::string_view help) {
  const std::string shown = PythonName(name);
  const auto given = Take(name,
                          "float | Sequence[float]",
                          help,
                          options_internal::DescribeValid<double>(valid),
                          fmt::format("{}", fmt::join(values, ", ")));
  if (given) values = NumbersOf(shown, *given, valid);
}

void Keywords::OfKind(std::string_view name,
                      std::map<std::string, std::string>& values,
                      const Word&,
                      std::string_view help) {
  const std::string shown = PythonName(name);
  const auto given = Take(name, "Mapping[str, str | int]", help);
  if (!given) return;
  if (!nb::isinstance<nb::dict>(*given))
    throw OptionError(
        fmt::format("option {}: expected {{key: name}}, found {}", shown, ShownValue(*given)));
  for (const auto& [key, value] : nb::cast<nb::dict>(*given))
    values[Utf8Of(shown, nb::str(key))] = TextOf(shown, value);
}

void Keywords::Group(std::string_view name,
                     const std::vector<OptionDescription>& options,
                     const std::function<void(std::string_view, std::string_view)>& set) {
  const std::string shown = PythonName(name);
  known_.push_back(shown);
  std::vector<std::string> names;
  nb::list inner;
  for (const OptionDescription& option : options) {
    names.push_back(option.name);
    within_.emplace_back(option.name, shown);
    inner.append(DescriptionOf(option.name, option));
  }
  nb::dict group;
  group["name"] = shown;
  group["options"] = inner;
  described_.append(group);
  const auto given = Given(shown);
  if (!given) return;
  if (!nb::isinstance<nb::dict>(*given)) {
    throw OptionError(fmt::format("option {}: expected a dictionary of {}, found {}",
                                  shown,
                                  fmt::join(names, ", "),
                                  ShownValue(*given)));
  }
  for (const auto& [key, value] : nb::cast<nb::dict>(*given)) {
    const std::string option = Utf8Of(shown, nb::str(key));
    if (std::find(names.begin(), names.end(), option) == names.end())
      throw OptionError(UnknownName("option of " + shown, option, names));
    set(option, TextOf(shown + "." + option, value));
  }
}

std::string Keywords::GroupName(std::string_view name) const {
  std::string group = PythonName(name);
  if (std::find(known_.begin(), known_.end(), group) != known_.end()) group += kOfFit;
  return group;
}

void Keywords::Finish() const {
  if (!given_.is_valid()) return;
  for (const auto& [name, wrong] : no_paths_) {
    const bool has_fit = std::find(known_.begin(), known_.end(), name + kOfFit) != known_.end();
    throw OptionError(
        wrong +
        (has_fit ? fmt::format("; options of its fit are {}{}={{...}}", name, kOfFit) : ""));
  }
  for (const auto& [key, value] : given_) {
    const std::string name = Utf8Of("name", nb::str(key));
    if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
    // An option of a group has its unit in its name, which the command line's short one may lack.
    const auto find = [&](const auto& is_it) {
      return std::find_if(
          within_.begin(), within_.end(), [&](const auto& option) { return is_it(option.first); });
    };
    auto within = find([&](const std::string& option) { return option == name; });
    if (within == within_.end() && Nearest(name, known_).empty())
      within = find([&](const std::string& option) { return option.starts_with(name + "_"); });
    if (within == within_.end()) throw OptionError(UnknownName("option", name, known_));
    throw OptionError(fmt::format("unknown option '{}'; {} of {}: say {}={{\"{}\": ...}}",
                                  name,
                                  within->first == name ? "it is one" : "there is one",
                                  within->second,
                                  within->second,
                                  within->first));
  }
}

}  // namespace lipoid::python
