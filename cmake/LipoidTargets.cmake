# How every lipoid target is compiled. Nothing here is a global flag.
add_library(lipoid_options INTERFACE)
target_compile_features(lipoid_options INTERFACE cxx_std_20)
# Eigen asks the processor for its caches and sums in blocks that fit them: the same numbers came out with other
# last digits on another machine, and a choice between two structures that are alike may hang on these.
target_compile_definitions(lipoid_options INTERFACE EIGEN_NO_CPUID)
target_compile_options(
  lipoid_options
  INTERFACE
    -Wall -Wextra
    -Wshadow             # a hidden name in a long numerical function is a bug waiting
    -Wconversion         # silent narrowing loses digits or rows
    -Wno-sign-conversion # indices of vectors, everywhere
    -Wnon-virtual-dtor
    -Wold-style-cast
    $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict> # false alarms of GCC 12 at -O3 (its bug 105651)
    # And of strings and vectors that are moved. The build of every day, at -O2, warns of all of these.
    "$<$<AND:$<CXX_COMPILER_ID:GNU>,$<CONFIG:Release>>:-Wno-maybe-uninitialized;-Wno-stringop-overflow;-Wno-array-bounds;-Wno-free-nonheap-object>"
    -ffp-contract=off    # the same bits with and without fused multiply-add
    # The same bytes wherever it is built: files are named from the top of the sources, also where the
    # compiler cache has made their paths relative. Other builds are for debuggers, which want true paths.
    "$<$<CONFIG:Release>:-ffile-prefix-map=${PROJECT_SOURCE_DIR}/=;-ffile-prefix-map=../../=;-ffile-prefix-map=${PROJECT_BINARY_DIR}/=>"
    $<$<BOOL:${LIPOID_WARNINGS_AS_ERRORS}>:-Werror>)
if(LIPOID_SANITIZE)
  target_compile_options(lipoid_options INTERFACE -fsanitize=${LIPOID_SANITIZE} -fno-omit-frame-pointer
                                                  -fno-sanitize-recover=all)
  target_link_options(lipoid_options INTERFACE -fsanitize=${LIPOID_SANITIZE})
  if(LIPOID_SANITIZE MATCHES "address.*undefined")
    # These ask what the address sanitizer finds by itself, and cost what computes a third of its time.
    target_compile_options(lipoid_options INTERFACE -fno-sanitize=null,object-size,vptr)
  endif()
endif()

# lipoid_guides_fuzzers(pattern ...): sources whose branches the fuzzers learn from. They count what is
# run; everywhere that would cost the tests under the sanitizers a third of their time.
function(lipoid_guides_fuzzers)
  if(LIPOID_BUILD_FUZZERS)
    file(GLOB sources CONFIGURE_DEPENDS ${ARGN})
    set_property(
      SOURCE ${sources} APPEND
      PROPERTY COMPILE_OPTIONS -fsanitize-coverage=inline-8bit-counters,indirect-calls,trace-cmp,pc-table)
  endif()
endfunction()

# lipoid_precompile(target [header ...]): what nearly every unit of the target includes, parsed once.
# Headers of others only: who changes one of ours rebuilds what includes it, and no more. A source
# still includes what it uses; the presets clang and tidy compile without precompiled headers and
# find what is missing. nlohmann/json.hpp is only worth it where most units use it: what it
# leaves to be instantiated at the end of a unit, a precompiled header leaves too.
function(lipoid_precompile target)
  target_precompile_headers(
    ${target} PRIVATE <algorithm> <cmath> <functional> <map> <memory> <optional> <random> <span>
    <string> <string_view> <vector> <fmt/format.h> ${ARGN})
endfunction()

# lipoid_unite(target): with CMAKE_UNITY_BUILD, the sources of a folder are compiled twenty at a time, which
# takes half: they include the same headers. Two sources of one folder therefore never give one name to two
# things, not even in unnamed namespaces. The presets clang and tidy compile every source by itself.
function(lipoid_unite target)
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    if(source MATCHES "\\.cc$")
      # Relative: units named after the clone would not be found in the compiler cache.
      cmake_path(ABSOLUTE_PATH source OUTPUT_VARIABLE path)
      cmake_path(RELATIVE_PATH path OUTPUT_VARIABLE path)
      cmake_path(GET path PARENT_PATH folder)
      string(MAKE_C_IDENTIFIER "in_${folder}" room)
      list(APPEND ${room} x)
      list(LENGTH ${room} count)
      math(EXPR batch "(${count} - 1) / 20")
      set_property(SOURCE "${source}" PROPERTY UNITY_GROUP ${room}_${batch})
    endif()
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
endfunction()

# lipoid_alone(source ...): compiled by themselves all the same. Beside others the compiler inlines less of
# what is in their loops: the joint fit took a seventh longer.
function(lipoid_alone)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# lipoid_library(model SOURCES a.cc ... HEADERS a.h ... LINKS target ...
# [PRECOMPILE header ...]): one exported library.
function(lipoid_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;HEADERS;LINKS;PRECOMPILE" ${ARGN})
  add_library(lipoid_${name} STATIC ${ARG_SOURCES})
  add_library(lipoid::${name} ALIAS lipoid_${name})
  set_target_properties(lipoid_${name} PROPERTIES EXPORT_NAME ${name} CXX_EXTENSIONS OFF
                                                  POSITION_INDEPENDENT_CODE ON)
  target_compile_features(lipoid_${name} PUBLIC cxx_std_20)
  target_link_libraries(lipoid_${name} PRIVATE $<BUILD_INTERFACE:lipoid_options>)
  target_link_libraries(lipoid_${name} PUBLIC ${ARG_LINKS})
  lipoid_precompile(lipoid_${name} ${ARG_PRECOMPILE})
  lipoid_unite(lipoid_${name})
  target_sources(
    lipoid_${name}
    PUBLIC FILE_SET HEADERS
           BASE_DIRS "${PROJECT_SOURCE_DIR}"
           FILES ${ARG_HEADERS})
  install(
    TARGETS lipoid_${name}
    EXPORT lipoid-targets
    ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT development
    FILE_SET HEADERS DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/lipoid" COMPONENT development)
endfunction()
