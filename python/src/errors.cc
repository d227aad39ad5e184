#include "python/src/errors.h"

#include <nanobind/stl/string.h>

#include "model/core/errors.h"
#include "model/core/stop.h"

namespace lipoid::python {
namespace {

namespace nb = nanobind;

nb::object Text(const std::string& text) {
  return nb::steal(
      PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "surrogateescape"));
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
    for (const Diagnostic& one : error.diagnostics()) {
      diagnostics.append(nb::make_tuple(
          Text(one.position.file), one.position.line, one.position.column, Text(one.message)));
    }
    const nb::object type = nb::module_::import_("lipoid.errors").attr("LoadError");
    const nb::object raised = type(Text(error.what()), diagnostics);
    PyErr_SetObject(type.ptr(), raised.ptr());
  } catch (const OptionError& error) {
    Raise("OptionError", Text(error.what()));
  } catch (const PreconditionError& error) {
    Raise("PreconditionError", Text(error.what()));
  } catch (const Stopped&) {
    PyErr_SetNone(PyExc_KeyboardInterrupt);
  }
}

}  // namespace

void AddErrors(nb::module_&) { nb::register_exception_translator(&Translate); }

}  // namespace lipoid::python
