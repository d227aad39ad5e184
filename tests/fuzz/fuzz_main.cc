// One fuzzer for all readers: LIPOID_FUZZ names the target. tools/fuzz builds and runs it.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "tests/fuzz/targets.h"

namespace {

const lipoid::test::FuzzTarget& Chosen() {
  const char* name = std::getenv("LIPOID_FUZZ");
  for (const auto& target : lipoid::test::FuzzTargets()) {
    if (name != nullptr && target.name == name) return target;
  }
  std::fputs("LIPOID_FUZZ: expected the name of a target:", stderr);
  for (const auto& target : lipoid::test::FuzzTargets()) {
    std::fprintf(stderr, " %.*s", static_cast<int>(target.name.size()), target.name.data());
  }
  std::fputs("\n", stderr);
  std::exit(2);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto& target = Chosen();
  lipoid::test::RunFuzzTarget(target, {reinterpret_cast<const char*>(data), size});
  return 0;
}
