#pragma once

/// @file
/// Numbers and JSON between C++ and Python. All of it needs the global interpreter lock.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "model/core/json.h"

namespace lipoid::python {

namespace nb = nanobind;

/// A one-dimensional array of NumPy, as functions here take and return it.
using Array = nb::ndarray<nb::numpy, const double, nb::ndim<1>, nb::c_contig>;
using Input = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

/// Dictionaries, lists, strings, numbers, None.
[[nodiscard]] nb::object ToPython(const Json& json);

/// The numbers move into the array.
[[nodiscard]] Array ToArray(std::vector<double> numbers);

/// An array over numbers that `keeper` holds; Python cannot write to it.
[[nodiscard]] Array ViewOf(std::span<const double> numbers, std::shared_ptr<const void> keeper);

/// Keeps a Python object alive from C++, and lets it go under the lock, whatever thread does it.
[[nodiscard]] std::shared_ptr<const void> Keep(nb::object object);

[[nodiscard]] inline std::span<const double> SpanOf(const Input& array) {
  return {array.data(), array.shape(0)};
}

/// "path/to/file" of str, bytes or os.PathLike.
[[nodiscard]] std::string PathOf(nb::handle path);
[[nodiscard]] std::vector<std::string> PathsOf(const nb::list& paths);

}  // namespace lipoid::python
