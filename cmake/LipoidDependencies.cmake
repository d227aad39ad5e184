# What the two libraries link to. The installed package includes this file again, so that a consumer
# finds the same dependencies by the same lines. tools/packages lists the Debian packages.
include(CMakeFindDependencyMacro)
find_dependency(Threads)
find_dependency(Eigen3 3.4)
find_dependency(fmt)
find_dependency(OpenSSL COMPONENTS Crypto)
find_dependency(nlohmann_json)
find_dependency(tomlplusplus)
find_dependency(TBB)
find_dependency(ZLIB)
find_dependency(Ceres)
find_dependency(NLopt)
find_dependency(pagmo)
find_dependency(Boost)  # headers only: Boost.Math

# lipoid_imported(target header library [SUFFIX ...]): a library that brings no CMake package which serves.
macro(lipoid_imported target header library)
  if(NOT TARGET ${target})
    string(TOUPPER "LIPOID_${library}" _name)
    find_path(${_name}_INCLUDE_DIR ${header} PATH_SUFFIXES ${ARGN} REQUIRED)
    find_library(${_name}_LIBRARY ${library} REQUIRED)
    add_library(${target} UNKNOWN IMPORTED)
    set_target_properties(${target} PROPERTIES IMPORTED_LOCATION "${${_name}_LIBRARY}"
                                               INTERFACE_INCLUDE_DIRECTORIES "${${_name}_INCLUDE_DIR}")
  endif()
endmacro()

# Ipopt 3.11 brings none, and its pkg-config file names the libraries behind it, which a shared library
# finds by itself. Its headers want to be told what Debian's build of it was told.
lipoid_imported(Ipopt::Ipopt IpTNLP.hpp ipopt coin coin-or)
set_target_properties(Ipopt::Ipopt PROPERTIES INTERFACE_COMPILE_DEFINITIONS HAVE_CSTDDEF)
# Debian's CMake package of libzip wants the programs zipcmp, zipmerge and ziptool, which come in
# packages of their own and which nothing here runs.
lipoid_imported(libzip::zip zip.h zip)
# Debian's libzstd comes with pkg-config's file alone.
lipoid_imported(zstd::zstd zstd.h zstd)
