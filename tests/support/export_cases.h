#pragma once

/// @file
/// What the tests of exports share: a cell that has every term, a sortie scaled to a cell, the
/// request made of both, and the programs of others that read what was exported.

#include <string>
#include <vector>

#include "model/export/exported.h"
#include "tests/support/paths.h"

namespace lipoid::test {

/// Six modes with a tail, a monotone cubic curve, tables of r_s and of a branch, a branch with a
/// capacitance, one of 1 ms that is folded, self-heating and charge transfer; 3s2p.
Cell CellWithEveryTerm();

/// Every kind of cell that an exact target must hold: the six shipped ones, the one above, one
/// without diffusion, one without a tail, curves of the other kinds.
std::vector<Cell> ExportCells();

/// Rest, flight, rest, flight, rest at two levels of current and with sudden steps, 0.1 s a row,
/// about 85 % of the pack's charge.
ExportMission SortieOf(const Cell& cell);

/// time_s,current_A with one header line.
ExportMission ReadMission(const std::string& file);

/// Every `every`-th row.
ExportMission Thinned(const ExportMission& mission, std::size_t every);

/// The same current throughout.
ExportMission Steady(double current_A, double duration_s, double row_s);

ExportRequest RequestOf(const Cell& cell, const std::string& target_version = "");

/// Writes the files of an export into a folder, the first as NAME and its own suffix, and returns
/// the first one's path.
std::string WriteExported(const Exported& exported,
                          const std::string& folder,
                          const std::string& first);

/// Runs a command of the shell; what it printed is added to `output`. Its exit code.
int RunCommand(const std::string& command, std::string& output);

/// One number a line.
std::vector<double> ReadNumbers(const std::string& file);

/// A C program is compiled and run with these flags of the compiler; "" where no C compiler is
/// installed.
std::string CCompiler();

}  // namespace lipoid::test

/// Skips a test, and says so, where the simulators of PyPI are absent.
#define LIPOID_SKIP_WITHOUT_SIMULATORS()              \
  if (lipoid::test::ExtraPython().empty())            \
  GTEST_SKIP() << "skipped: tools/setup --extra has " \
                  "not installed the simulators of PyPI (build/python-extra)"
