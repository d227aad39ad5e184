#include "tests/support/export_cases.h"

#include <sys/wait.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "model/battery/cell_file.h"
#include "model/core/atomic_file.h"
#include "tests/support/paths.h"

namespace lipoid::test {

Cell CellWithEveryTerm() {
  Cell cell;
  cell.name = "every-term";
  cell.series = 3;
  cell.parallel = 2;
  cell.capacity_Ah = 1.5;
  cell.cutoff_V = 3.0;
  cell.diffusion = Cell::Diffusion{5000.0, 0.15, 6, true};
  cell.open_circuit_voltage = OpenCircuitVoltage::MonotoneCubic(
      {0.0, 0.04, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0}, {3.0, 3.4, 3.6, 3.72, 3.8, 3.93, 4.08, 4.19});
  cell.series_resistance_Ohm = Resistance<double>({0.05, 0.3, 1.0}, {0.03, 0.02, 0.018});
  cell.branches = {{Resistance<double>({0.1, 0.9}, {0.012, 0.008}), 12.0, {}},
                   {Resistance<double>(0.004), 0.6, 150.0},
                   {Resistance<double>(0.001), 0.001, {}}};
  cell.self_heating = Cell::SelfHeating{120.0, 1.5e-5};
  cell.charge_transfer = Cell::ChargeTransfer{2.0, Resistance<double>({0.2, 0.8}, {0.006, 0.004})};
  return cell;
}

std::vector<Cell> ExportCells() {
  std::vector<Cell> cells;
  for (const auto& name : ShippedCellNames()) cells.push_back(LoadCell(name));
  cells.push_back(CellWithEveryTerm());
  Cell plain = LoadCell("gifi-600mAh-1");
  plain.name = "no-diffusion";
  plain.diffusion.reset();
  plain.branches = {{Resistance<double>(0.05), 30.0, {}}};
  cells.push_back(plain);
  Cell cut = LoadCell("gifi-600mAh-1");
  cut.name = "no-tail";
  cut.diffusion->tail = false;
  cut.branches.clear();
  cells.push_back(cut);
  Cell chebyshev = CellWithEveryTerm();
  chebyshev.name = "chebyshev";
  chebyshev.series = 1;
  chebyshev.open_circuit_voltage =
      OpenCircuitVoltage::Polynomial(0.02, 1.0, {3.7, 0.42, -0.06, 0.05, -0.01});
  cells.push_back(chebyshev);
  Cell fourier = CellWithEveryTerm();
  fourier.name = "fourier";
  fourier.parallel = 1;
  fourier.open_circuit_voltage =
      OpenCircuitVoltage::Fourier(0.0, 1.0, 2.5, {3.6, -0.35, 0.02}, {0.2, 0.03});
  cells.push_back(fourier);
  return cells;
}

ExportMission SortieOf(const Cell& cell) {
  ExportMission mission;
  mission.name = "sortie";
  const double unit_A = cell.parallel * cell.alpha_C() / 3600.0;
  for (int k = 0; k <= 6000; ++k) {
    const double t = 0.1 * k;
    double rate = 0.0;  // of the capacity in an hour
    if (t > 30.0 && t <= 190.0) rate = 7.0 + 1.5 * std::sin(0.7 * t) + (k % 50 < 5 ? 4.0 : 0.0);
    if (t > 290.0 && t <= 490.0) rate = 9.0 + std::sin(1.3 * t) - (k % 80 < 8 ? 6.0 : 0.0);
    mission.time_s.push_back(t);
    mission.current_A.push_back(rate * unit_A);
  }
  return mission;
}

ExportMission ReadMission(const std::string& file) {
  ExportMission mission;
  mission.name = std::filesystem::path(file).filename();
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    double t = 0.0;
    double i = 0.0;
    if (std::sscanf(line.c_str(), "%lf,%lf", &t, &i) != 2) break;
    mission.time_s.push_back(t);
    mission.current_A.push_back(i);
  }
  return mission;
}

ExportMission Thinned(const ExportMission& mission, std::size_t every) {
  ExportMission thin = mission;
  thin.time_s.clear();
  thin.current_A.clear();
  for (std::size_t k = 0; k < mission.time_s.size(); k += every) {
    thin.time_s.push_back(mission.time_s[k]);
    thin.current_A.push_back(mission.current_A[k]);
  }
  return thin;
}

ExportMission Steady(double current_A, double duration_s, double row_s) {
  ExportMission mission;
  for (int k = 0; k <= std::lround(duration_s / row_s); ++k) {
    mission.time_s.push_back(k * row_s);
    mission.current_A.push_back(current_A);
  }
  return mission;
}

ExportRequest RequestOf(const Cell& cell, const std::string& target_version) {
  ExportRequest request;
  request.cell = cell;
  request.source = cell.name;
  request.sha256 = std::string(64, '0');
  request.mission = SortieOf(cell);
  request.target_version = target_version;
  request.name = cell.name;
  for (char& c : request.name) {
    if (c == '-') c = '_';
  }
  return request;
}

std::string WriteExported(const Exported& exported,
                          const std::string& folder,
                          const std::string& first) {
  std::filesystem::create_directories(folder);
  for (const auto& file : exported.files) {
    WriteFileAtomically(folder + "/" + first + file.suffix, file.content);
  }
  return folder + "/" + first + exported.files.at(0).suffix;
}

int RunCommand(const std::string& command, std::string& output) {
  std::FILE* const pipe = popen(("(" + command + ") 2>&1").c_str(), "r");
  if (pipe == nullptr) return -1;
  std::array<char, 4096> buffer{};
  while (const std::size_t read = std::fread(buffer.data(), 1, buffer.size(), pipe)) {
    output.append(buffer.data(), read);
  }
  const int status = pclose(pipe);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::vector<double> ReadNumbers(const std::string& file) {
  std::vector<double> numbers;
  std::ifstream in(file);
  for (double number = 0.0; in >> number;) numbers.push_back(number);
  return numbers;
}

std::string CCompiler() {
  std::string output;
  return RunCommand("cc --version", output) == 0 ? "cc" : "";
}

}  // namespace lipoid::test
