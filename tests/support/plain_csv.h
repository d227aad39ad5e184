#pragma once

/// @file
/// A reader of time_s,current,voltage for tests that must not depend on the library's own.

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <string>

#include "identify/logs/record.h"

namespace lipoid::test {

/// Three numbers per line after one header line; rows whose time does not increase are left out.
inline Record ReadPlainCsv(const std::string& file) {
  Record record;
  record.file = file;
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    double t = 0.0;
    double i = 0.0;
    double v = 0.0;
    if (std::sscanf(line.c_str(), "%lf,%lf,%lf", &t, &i, &v) != 3) {
      ADD_FAILURE() << file << ": cannot read '" << line << "'";
      break;
    }
    if (record.size() > 0 && t <= record.time_s.back()) continue;
    record.time_s.push_back(t);
    record.current_A.push_back(i);
    record.voltage_V.push_back(v);
  }
  return record;
}

}  // namespace lipoid::test
