#include "python/src/convert.h"

#include <nanobind/stl/string.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "python/src/work.h"

namespace lipoid::python {

nb::object ToPython(const Json& json) {
  switch (json.type()) {
    case Json::value_t::object: {
      nb::dict dict;
      for (const auto& [key, value] : json.items()) dict[key.c_str()] = ToPython(value);
      return dict;
    }
    case Json::value_t::array: {
      nb::list list;
      for (const Json& value : json) list.append(ToPython(value));
      return list;
    }
    case Json::value_t::string: {
      const auto& text = json.get_ref<const std::string&>();
      // Names of files may be anything but UTF-8.
      return nb::steal(PyUnicode_DecodeUTF8(
          text.data(), static_cast<Py_ssize_t>(text.size()), "surrogateescape"));
    }
    case Json::value_t::boolean:
      return nb::bool_(json.get<bool>());
    case Json::value_t::number_integer:
      return nb::int_(json.get<std::int64_t>());
    case Json::value_t::number_unsigned:
      return nb::int_(json.get<std::uint64_t>());
    case Json::value_t::number_float:
      return nb::float_(json.get<double>());
    default:
      return nb::none();
  }
}

Array ToArray(std::vector<double> numbers) {
  auto keeper = std::make_shared<const std::vector<double>>(std::move(numbers));
  const std::span<const double> span(*keeper);
  return ViewOf(span, std::move(keeper));
}

Array ViewOf(std::span<const double> numbers, std::shared_ptr<const void> keeper) {
  using Keeper = std::shared_ptr<const void>;
  const nb::capsule owner(new Keeper(std::move(keeper)),
                          [](void* of) noexcept { delete static_cast<Keeper*>(of); });
  return {numbers.data(), {numbers.size()}, owner};
}

std::shared_ptr<const void> Keep(nb::object object) {
  return {new nb::object(std::move(object)), [](const nb::object* kept) {
            if (HasEnded()) return;  // with everything else of Python
            const nb::gil_scoped_acquire lock;
            delete kept;
          }};
}

std::string PathOf(nb::handle path) {
  PyObject* bytes = nullptr;
  if (PyUnicode_FSConverter(path.ptr(), &bytes) == 0) throw nb::python_error();
  const auto owned = nb::steal<nb::bytes>(bytes);
  return {owned.c_str(), owned.size()};
}

std::vector<std::string> PathsOf(const nb::list& paths) {
  std::vector<std::string> several;
  for (const nb::handle path : paths) several.push_back(PathOf(path));
  return several;
}

}  // namespace lipoid::python
