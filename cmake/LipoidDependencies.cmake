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

# Ipopt 3.11 brings no CMake package, and its pkg-config file names the libraries behind it, which a
# shared library finds by itself.
if(NOT TARGET Ipopt::Ipopt)
  find_path(LIPOID_IPOPT_INCLUDE_DIR IpTNLP.hpp PATH_SUFFIXES coin coin-or REQUIRED)
  find_library(LIPOID_IPOPT_LIBRARY ipopt REQUIRED)
  add_library(Ipopt::Ipopt UNKNOWN IMPORTED)
  set_target_properties(
    Ipopt::Ipopt
    PROPERTIES IMPORTED_LOCATION "${LIPOID_IPOPT_LIBRARY}"
               INTERFACE_INCLUDE_DIRECTORIES "${LIPOID_IPOPT_INCLUDE_DIR}"
               INTERFACE_COMPILE_DEFINITIONS HAVE_CSTDDEF)  # what Debian's build of it was told
endif()

# Debian's CMake package of libzip wants the programs zipcmp, zipmerge and ziptool, which come in
# packages of their own and which nothing here runs.
if(NOT TARGET libzip::zip)
  find_path(LIPOID_ZIP_INCLUDE_DIR zip.h REQUIRED)
  find_library(LIPOID_ZIP_LIBRARY zip REQUIRED)
  add_library(libzip::zip UNKNOWN IMPORTED)
  set_target_properties(libzip::zip PROPERTIES IMPORTED_LOCATION "${LIPOID_ZIP_LIBRARY}"
                                               INTERFACE_INCLUDE_DIRECTORIES "${LIPOID_ZIP_INCLUDE_DIR}")
endif()

# Debian's libzstd comes with pkg-config's file alone.
if(NOT TARGET zstd::zstd)
  find_path(LIPOID_ZSTD_INCLUDE_DIR zstd.h REQUIRED)
  find_library(LIPOID_ZSTD_LIBRARY zstd REQUIRED)
  add_library(zstd::zstd UNKNOWN IMPORTED)
  set_target_properties(zstd::zstd PROPERTIES IMPORTED_LOCATION "${LIPOID_ZSTD_LIBRARY}"
                                              INTERFACE_INCLUDE_DIRECTORIES "${LIPOID_ZSTD_INCLUDE_DIR}")
endif()
