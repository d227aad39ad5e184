# cmake -DOUTPUT=x.h "-DFILES=a.so;b.so" "-DNAMES=kA;kB" -P embed_bytes.cmake
# Writes the bytes of files into a header as arrays: programs that lipoid puts into what it exports.
set(text "#pragma once\nnamespace lipoid {\n")
foreach(file name IN ZIP_LISTS FILES NAMES)
  file(READ "${file}" bytes HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
  string(APPEND text "inline constexpr unsigned char ${name}[] = {\n${bytes}\n};\n")
endforeach()
file(WRITE "${OUTPUT}.new" "${text}}  // namespace lipoid\n")
file(COPY_FILE "${OUTPUT}.new" "${OUTPUT}" ONLY_IF_DIFFERENT)
