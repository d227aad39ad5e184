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
find_dependency(Ceres)
find_dependency(NLopt)
find_dependency(Boost)  # headers only: Boost.Math
