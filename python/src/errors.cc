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

// Messages name options as one types them on the command line: --low-rate, --series 4.
std::string InPython(const std::string& message) {
  static const std::regex option("--([A-Za-z][A-Za-z-]*)( (?=[0-9]|[A-Z][A-Z]))?");
  std::string text;
  std::sregex_iterator found(message.begin(), message.end(), option);
  std::size_t copied = 0;
  for (; found != std::sregex_iterator(); ++found) {
    const auto at = static_cast<std::size_t>(found->position());
    text += message.substr(copied, at - copied) + PythonName((*found)[1].str());
    if ((*found)[2].matched) text += "=";
    copied = at + static_cast<std::size_t>(found->length());
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

void AddErrors(nb::module_&) { nb::register_exception_translator(&Translate); }

}  // namespace lipoid::python
