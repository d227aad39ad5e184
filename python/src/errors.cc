#include "python/src/errors.h"

#include <nanobind/stl/string.h>

#include <regex>

#include "model/core/errors.h"
#include "model/core/stop.h"
#include "python/src/keywords.h"

namespace lipoid::python {
namespace {

namespace nb = nanobind;

nb::object Text(const std::string& text) {
  return nb::steal(
      PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "surrogateescape"));
}

// " time_s=1 voltage_V=3" as the items of a dictionary: "time_s": 1, "voltage_V": 3.
std::string InDictionary(const std::string& pairs) {
  static const std::regex pair(" ([A-Za-z_0-9]+)=([^ ]+)");
  static const std::regex several("([A-Z]+),([A-Z]+)|([0-9][^,]*),(.+)");
  std::string items;
  for (std::sregex_iterator one(pairs.begin(), pairs.end(), pair); one != std::sregex_iterator();
       ++one) {
    items += (items.empty() ? "\"" : ", \"") + (*one)[1].str() +
             "\": " + std::regex_replace((*one)[2].str(), several, "($1$3, $2$4)");
  }
  return items;
}

// Messages name options as one types them on the command line: --low-rate, --series 4, --units s,A,V,
// --columns time_s=1 current_A=2, --set pulses.terms=34 for one of a group, --set square.* for the options of a
// maneuver, -o, and --method joint, the one whose value is a single word.
std::string InPython(const std::string& of_command) {
  static const std::regex maneuver("--set [a-z-]+\\.\\*");
  static const std::regex of_group(
      "--set ([a-z_]+)\\.([A-Za-z_0-9]+)=(\\.\\.\\.|[A-Za-z0-9][A-Za-z0-9.+-]*[A-Za-z0-9]|[0-9])");
  static const std::regex method("--method (joint|staged)");
  static const std::regex output("(option |`)-o\\b");
  std::string message = std::regex_replace(of_command, maneuver, "maneuver_options");
  message = std::regex_replace(message, of_group, "$1={\"$2\": $3}");
  message = std::regex_replace(message, method, "method=\"$1\"");
  message = std::regex_replace(message, output, "$1output");
  static const std::regex option(
      "--([A-Za-z][A-Za-z-]*)(?:"
      "((?: [A-Za-z_][A-Za-z_0-9]*=(?:[0-9][0-9.e+-]*(?:,[0-9a-z][0-9a-z.+-]*)?|\"[^\"]*\"|[A-Z]+(?:,[A-Z]+)?))+)|"  // pairs
      " ([a-z]+(?:[-,][A-Za-z]+)+)|"  // a text
      "( )(?=[0-9]|[A-Z][A-Z]))?");   // a number, a placeholder
  std::string text;
  std::sregex_iterator found(message.begin(), message.end(), option);
  std::size_t copied = 0;
  for (; found != std::sregex_iterator(); ++found) {
    const std::smatch& at = *found;
    const auto begin = static_cast<std::size_t>(at.position());
    const std::string between = message.substr(copied, begin - copied);
    text += (copied > 0 && between == " " ? ", " : between) + PythonName(at[1].str());
    if (at[2].matched) text += "={" + InDictionary(at[2].str()) + "}";
    if (at[3].matched) text += "=\"" + at[3].str() + "\"";
    if (at[4].matched) text += "=";
    copied = begin + static_cast<std::size_t>(at.length());
  }
  return text + message.substr(copied);
}

void Raise(const char* name, const nb::object& argument) {
  const nb::object type = nb::module_::import_("lipoid.errors").attr(name);
  const nb::object error = type(argument);
  PyErr_SetObject(type.ptr(), error.ptr());
}

void Translate(const std::exception_ptr& pointer, void*) {
  try {
    std::rethrow_exception(pointer);
  } catch (const LoadError& error) {
    nb::list diagnostics;
    std::string what = error.what();
    for (const Diagnostic& one : error.diagnostics()) {
      diagnostics.append(nb::make_tuple(Text(one.position.file),
                                        one.position.line,
                                        one.position.column,
                                        Text(InPython(one.message))));
      if (const auto at = what.find(one.message); at != std::string::npos)
        what.replace(at, one.message.size(), InPython(one.message));
    }
    const nb::object type = nb::module_::import_("lipoid.errors").attr("LoadError");
    const nb::object raised = type(Text(what), diagnostics);
    PyErr_SetObject(type.ptr(), raised.ptr());
  } catch (const OptionError& error) {
    Raise("OptionError", Text(InPython(error.what())));
  } catch (const PreconditionError& error) {
    Raise("PreconditionError", Text(error.what()));
  } catch (const Stopped&) {
    PyErr_SetNone(PyExc_KeyboardInterrupt);
  }
}

}  // namespace

void AddErrors(nb::module_& module) {
  nb::register_exception_translator(&Translate);
  module.def("in_python", &InPython, nb::arg("message"));  // of warnings
}

}  // namespace lipoid::python
