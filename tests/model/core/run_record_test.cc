#include "model/core/run_record.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "model/core/atomic_file.h"
#include "model/core/errors.h"
#include "tests/support/paths.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

// FIPS 180-4, the examples published with the standard.
constexpr const char* kOfAbc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
constexpr const char* kOfNothing =
    "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";

TEST(Sha256, IsThatOfTheStandard) {
  EXPECT_EQ(Sha256OfBytes("abc"), kOfAbc);
  EXPECT_EQ(Sha256OfBytes(""), kOfNothing);
  EXPECT_EQ(Sha256OfBytes("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(Sha256OfBytes(std::string(1'000'000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, OfAFileIsThatOfItsBytes) {
  const std::string path = test::FreshFolder("sha256") + "/bytes";
  WriteFileAtomically(path, "abc");
  EXPECT_EQ(Sha256OfFile(path), kOfAbc);
  const std::string large(3'500'000, 'q');  // several reads
  WriteFileAtomically(path, large);
  EXPECT_EQ(Sha256OfFile(path), Sha256OfBytes(large));
}

TEST(Sha256, RefusesWhatCannotBeRead) {
  const std::string folder = test::FreshFolder("sha256_refuse");
  EXPECT_EQ(
      test::MessageOf<LoadError>([&] { (void)Sha256OfFile(folder + "/none"); }),
      folder +
          "/none: error: expected a readable file, found none (No such file or directory)");
  EXPECT_EQ(
      test::MessageOf<LoadError>([&] { (void)Sha256OfFile(folder); }),
      folder +
          ":1:1: error: expected a readable file, found one that cannot be read (Is a directory)");
}

TEST(RunRecord, SaysWhichProgramWithWhichOptionsFromWhichInputs) {
  const std::string path = test::FreshFolder("run_record") + "/log.csv";
  WriteFileAtomically(path, "abc");
  RunRecord record;
  record.command = "identify";
  record.options = {{"terms", 10}};
  record.seed = 18446744073709551615U;
  record.inputs = {path};
  record.metrics = {{"rmse_V", 0.012}};
  const Json json = record.ToJson();
  EXPECT_EQ(json["command"], "identify");
  EXPECT_EQ(json["options"]["terms"], 10);
  EXPECT_EQ(json["seed"], 18446744073709551615U);
  EXPECT_EQ(json["inputs"].size(), 1U);
  EXPECT_EQ(json["inputs"][0]["file"], path);
  EXPECT_EQ(json["inputs"][0]["sha256"], kOfAbc);
  EXPECT_EQ(json["metrics"]["rmse_V"], 0.012);
  EXPECT_EQ(json["version"], Version());
  EXPECT_EQ(json["commit"], GitCommit());
  EXPECT_EQ(std::string(Version()).find_first_not_of("0123456789."), std::string::npos)
      << Version();
  EXPECT_NE(std::string(GitCommit()), "");
}

}  // namespace
}  // namespace lipoid
