#pragma once

/// @file
/// What a result written to disk carries with it: which program, with which options, from which
/// inputs. Tests: tests/model/core/run_record_test.cc.

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/core/json.h"

namespace lipoid {

/// Version of the library, "0.1.0", and the commit it was built from (or "unknown").
[[nodiscard]] const char* Version();
[[nodiscard]] const char* GitCommit();

/// Hexadecimal SHA-256 of a file's bytes (FIPS 180-4, OpenSSL). LoadError where it cannot be read.
[[nodiscard]] std::string Sha256OfFile(const std::string& file);
[[nodiscard]] std::string Sha256OfBytes(const std::string& bytes);

/// The "run" object of a cell file.
struct RunRecord {
  std::string command;  ///< as typed, or the function called
  Json options = Json::object();
  std::uint64_t seed = 0;
  std::vector<std::string> inputs;  ///< files
  std::vector<std::string> sha256;  ///< of the inputs; empty: ToJson() reads them
  Json metrics = Json::object();

  [[nodiscard]] Json ToJson() const;
};

}  // namespace lipoid
