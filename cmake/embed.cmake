# cmake -DOUTPUT=x.h -DNAME=kShippedCells "-DFILES=a.json;b.json" -P embed.cmake
# Writes the files into a header as a sorted table of {name, text}, so that names resolve from anywhere.
# With -DEXTENSIONS=ON a name keeps its extension. The literals are views with a length: the compiler does not
# count the characters of a text of megabytes.
list(SORT FILES)
list(LENGTH FILES count)
set(rows "")
foreach(file IN LISTS FILES)
  get_filename_component(name "${file}" NAME_WLE)
  if(EXTENSIONS)
    get_filename_component(name "${file}" NAME)
  endif()
  file(READ "${file}" text)
  string(APPEND rows "    {\"${name}\", R\"lipoid(${text})lipoid\"sv},\n")
endforeach()
file(WRITE "${OUTPUT}.new" "#pragma once
#include <array>
#include <string_view>
namespace lipoid {
using std::string_view_literals::operator\"\"sv;
struct ${NAME}Entry {
  std::string_view name;
  std::string_view text;
};
inline constexpr std::array<${NAME}Entry, ${count}> ${NAME}{{
${rows}}};
}  // namespace lipoid
")
file(COPY_FILE "${OUTPUT}.new" "${OUTPUT}" ONLY_IF_DIFFERENT)
