#include "tests/fuzz/targets.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "identify/joint/joint_choice.h"
#include "identify/logs/campaign.h"
#include "identify/logs/inspection.h"
#include "identify/logs/inspection_report.h"
#include "identify/logs/log.h"
#include "identify/stages/staged_run.h"
#include "model/battery/cell_file.h"
#include "model/control/gains.h"
#include "model/core/errors.h"
#include "model/core/json_text.h"
#include "model/flight/maneuvers/maneuvers.h"
#include "model/vehicle/vehicle_file.h"
#include "tools/report/summary_schema.h"

namespace lipoid::test {
namespace {

void Expect(bool holds, const char* what) {
  if (!holds) throw std::logic_error(what);
}

// For readers of files alone.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& bytes)
      : path_(std::filesystem::temp_directory_path() /
              ("lipoid-fuzz-" + std::to_string(getpid()))) {
    std::ofstream(path_, std::ios::binary) << bytes;
  }
  ~TemporaryFile() {
    std::error_code none;
    std::filesystem::remove(path_, none);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  [[nodiscard]] std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

Log ReadAny(const std::string& bytes) {
  ReadOptions options;
  options.voltage_optional = true;
  Log log = ReadLogText(bytes, "fuzz", options);
  const Record& record = log.record;
  Expect(record.size() > 0, "a log has rows");
  Expect(record.current_A.size() == record.size(), "as many currents as times");
  for (std::size_t k = 0; k < record.size(); ++k) {
    Expect(std::isfinite(record.time_s[k]) && std::isfinite(record.current_A[k]), "numbers");
    Expect(k == 0 || record.time_s[k] > record.time_s[k - 1], "time increases");
  }
  return log;
}

void Cells(const std::string& bytes) {
  const Cell cell = ParseCell(bytes, "fuzz");
  const std::string text = JsonText(CellToJson(cell));
  Expect(JsonText(CellToJson(ParseCell(text, "again"))) == text, "a cell is read as it is written");
}

void Vehicles(const std::string& bytes) {
  const Vehicle vehicle = ParseVehicle(bytes, "fuzz");
  Expect(vehicle.mass_kg > 0.0 && vehicle.gamma_rad_per_s() > 0.0, "a vehicle that can be");
}

void Inspect(const std::string& bytes) {
  const Log log = ReadAny(bytes);
  if (log.record.voltage_V.empty()) return;
  (void)JsonText(InspectionToJson(InspectRecord(log.record, log.report)));
}

void Waypoints(const std::string& bytes) {
  const TemporaryFile file(bytes);
  ManeuverRequest request;
  request.waypoints_file = file.path();
  const FlightPlan plan = FindManeuver("waypoints").plan(request);
  Expect(std::isfinite(plan.duration_s) && plan.duration_s > 0.0, "a plan ends");
}

// Lines of name=value.
void Options(const std::string& bytes) {
  StagedOptions staged;
  JointOptions joint;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t end = std::min(bytes.find('\n', at), bytes.size());
    const std::string line = bytes.substr(at, end - at);
    at = end + 1;
    const std::size_t equals = line.find('=');
    if (equals == line.npos) continue;
    const std::string name = line.substr(0, equals);
    const std::string value = line.substr(equals + 1);
    const auto set = [&](auto& options) {
      try {
        SetOption(options, name, value);
      } catch (const OptionError&) {
      }
    };
    set(staged.pulses);
    set(staged.discharge_times);
    set(staged.open_circuit_voltage);
    set(staged.solver);
    set(joint);
  }
}

constexpr std::array kTargets{
    FuzzTarget{"campaign",
               {".toml", "", ""},
               [](const std::string& bytes) { (void)ParseCampaign(bytes, "fuzz"); }},
    FuzzTarget{"cell", {"cells/", "hostile/", ""}, &Cells},
    FuzzTarget{
        "flight", {"flights/", "", ""}, [](const std::string& bytes) { (void)ReadAny(bytes); }},
    FuzzTarget{"gains",
               {"gains", "cells/", ""},
               [](const std::string& bytes) { (void)ParseGains(bytes, "fuzz"); }},
    FuzzTarget{"inspect", {"logs/", "lab/", ""}, &Inspect},
    FuzzTarget{"log",
               {"logs/", "lab/", "hostile/"},
               [](const std::string& bytes) { (void)ReadAny(bytes); }},
    FuzzTarget{"options", {"", "", ""}, &Options},
    FuzzTarget{"summary",
               {"cells/", "", ""},
               [](const std::string& bytes) {
                 const TemporaryFile file(bytes);
                 (void)ReadSummary(file.path());
               }},
    FuzzTarget{"vehicle", {"vehicles/", "", ""}, &Vehicles},
    FuzzTarget{"waypoints", {"waypoints", "", ""}, &Waypoints},
};
static_assert(std::ranges::is_sorted(kTargets, {}, &FuzzTarget::name));

void CheckMessage(std::string_view message) {
  Expect(!message.empty(), "a refusal says why");
  Expect(message.size() < 20'000, "a refusal is short");
  for (const char c : message) {
    Expect(c == '\n' || static_cast<unsigned char>(c) >= 0x20, "a refusal is printable");
  }
}

}  // namespace

std::span<const FuzzTarget> FuzzTargets() { return kTargets; }

void RunFuzzTarget(const FuzzTarget& target, std::string_view bytes) {
  try {
    target.run(std::string(bytes));
  } catch (const LoadError& error) {
    CheckMessage(error.what());
  } catch (const OptionError& error) {
    CheckMessage(error.what());
  }
}

}  // namespace lipoid::test
