#pragma once

/// @file
/// Where tests find files: the project's own, the lab logs beside the project, and a folder to
/// write to. The places are compiled into paths.cc alone, so that a compiler cache serves every
/// other test in any clone.

#include <string>

namespace lipoid::test {

/// A file of the project, "fixtures/cells/x.json".
std::string SourcePath(const std::string& relative);

/// A log of an autopilot among those of fixtures/flights.
std::string FlightFixture(const std::string& name);

/// A real lab log: of fixtures/lab, or a larger one from a folder beside the project. "" where it
/// is in neither: then skip and say so.
std::string LabDataPath(const std::string& relative);

/// A file or folder that tests may write to, in the build folder; it need not be there.
std::string ScratchPath(const std::string& relative);

/// The python3 with the packages of tools/python-extra, or "" where tools/setup --extra has not
/// installed them: then skip and say so.
std::string ExtraPython();

/// An empty folder for one test, made anew at each call.
std::string FreshFolder(const std::string& name);

}  // namespace lipoid::test

/// Skips a test, and says so, where the real lab logs are absent.
#define LIPOID_SKIP_WITHOUT(path) \
  if ((path).empty())             \
  GTEST_SKIP()                    \
      << "skipped: this lab log is larger than what stands in fixtures/lab, and not beside the project"
