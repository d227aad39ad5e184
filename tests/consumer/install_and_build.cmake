# cmake -DSOURCE=... -DBUILD=... -DSCRATCH=... -DGENERATOR=... -DCOMPILER=... -P install_and_build.cmake
# Installs lipoid into an empty folder and builds and runs the consumer against what is there.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE out ERROR_VARIABLE out)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGN}\n${out}")
  endif()
  set(out "${out}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE "${SCRATCH}")
run("${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${SCRATCH}/prefix")
# Every header that is installed must find what it includes.
file(GLOB_RECURSE headers RELATIVE "${SCRATCH}/prefix/include/lipoid" "${SCRATCH}/prefix/include/lipoid/*.h")
list(TRANSFORM headers REPLACE "(.+)" "#include \"\\1\"\n")
list(JOIN headers "" every_header)
file(WRITE "${SCRATCH}/every_header.cc" "${every_header}")
run("${CMAKE_COMMAND}" -S "${SOURCE}" -B "${SCRATCH}/build" -G "${GENERATOR}" "-DCMAKE_PREFIX_PATH=${SCRATCH}/prefix"
    "-DCMAKE_CXX_COMPILER=${COMPILER}" "-DCMAKE_CXX_FLAGS=${FLAGS}" "-DEVERY_HEADER=${SCRATCH}/every_header.cc")
run("${CMAKE_COMMAND}" --build "${SCRATCH}/build")
run("${SCRATCH}/build/consumer")
# Ten seconds of 0.6 A: 6 C delivered and, by (4.37), 28.96 C held back, of 1353.6 C. Pulses at 6C.
if(NOT out STREQUAL "2 0.974 6\n")
  message(FATAL_ERROR "the consumer printed: ${out}")
endif()
run("${SCRATCH}/prefix/bin/lipoid" list cells)
