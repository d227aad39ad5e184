#include "identify/synthesis/synthesize.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>

#include "identify/logs/discharge.h"
#include "identify/synthesis/decimal_step.h"
#include "identify/synthesis/plan_walk.h"
#include "model/battery/arrhenius.h"
#include "model/battery/cell_file.h"
#include "model/core/atomic_file.h"
#include "model/core/csv_writer.h"
#include "model/core/errors.h"
#include "model/core/json.h"
#include "model/core/json_text.h"
#include "model/core/stop.h"

namespace lipoid {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kMaxRows = 100'000'000;

// Independent normal numbers for each log and quantity, the same on every platform with this Boost.
class Noise {
 public:
  Noise(std::uint64_t seed, std::size_t log, unsigned quantity, double sigma) : sigma_(sigma) {
    std::seed_seq sequence{static_cast<std::uint32_t>(seed),
                           static_cast<std::uint32_t>(seed >> 32),
                           static_cast<std::uint32_t>(log),
                           static_cast<std::uint32_t>(quantity)};
    engine_.seed(sequence);
  }
  double operator()() { return sigma_ > 0.0 ? sigma_ * normal_(engine_) : 0.0; }

 private:
  double sigma_;
  boost::random::mt19937_64 engine_;
  boost::random::normal_distribution<double> normal_;
};

void CheckPlan(const Cell& cell, const TestPlan& plan, const DecimalStep& sampling) {
  Require(!plan.stages.empty() && plan.stages[0].length_s > 0.0, "a first stage that takes time");
  // What is written is what its kind says: identify refuses anything else.
  if (plan.kind == LogKind::kLowRate) {
    const double rate_per_h = plan.stages[0].current_A / cell.capacity_Ah;
    if (rate_per_h > kMaxLowRate_per_h) {
      throw OptionError(fmt::format(
          "{}: expected a low rate, at most {:.2g} C, found {:.3g} C; give a longer low_rate_h",
          plan.file,
          kMaxLowRate_per_h,
          rate_per_h));
    }
  }
  if (plan.kind == LogKind::kPulses) {
    if (const std::string why = WhyNoPulses(cell, plan, sampling); !why.empty())
      throw OptionError(why);
  }
}

struct Signals {
  const Cell& cell;
  const SynthesisOptions& options;
  DecimalStep sampling;
  std::optional<DecimalStep> resolution;
  std::uint64_t seed;
};

// `delivered` is told the charge of the cell, bit by bit.
SynthesizedFile WriteLog(const TestPlan& plan,
                         std::size_t index,
                         const Signals& signals,
                         CsvWriter& csv,
                         const std::function<void(double)>& delivered) {
  constexpr std::int64_t kRowsPerReport = 100'000;
  const Cell& cell = signals.cell;
  Noise voltage_noise(signals.seed, index, 0, signals.options.voltage_noise_V);
  Noise current_noise(signals.seed, index, 1, signals.options.current_noise_A);
  double reported_C = 0.0;
  const auto write = [&](const WalkedRow& row) {
    double voltage_V = cell.series * row.voltage_V + voltage_noise();
    if (signals.resolution)
      voltage_V = signals.resolution->Times(signals.resolution->Count(voltage_V));
    const double shown_A = row.current_A + current_noise();
    const auto& state = row.stepper.state();
    if (plan.ambient_degC) {
      csv.Row(row.time_s, shown_A, voltage_V, state.temperature_K - kZeroCelsius_K);
    } else {
      csv.Row(row.time_s, shown_A, voltage_V);
    }
    if (row.index % kRowsPerReport == 0) {
      delivered(state.delivered_C - reported_C);
      reported_C = state.delivered_C;
    }
  };
  WalkPlan(cell, plan, signals.sampling, signals.options.hold, kMaxRows, write);
  delivered(cell.alpha_C() - reported_C);
  csv.Flush();
  return {plan.file, csv.rows(), csv.bytes()};
}

Campaign CampaignOf(const Cell& cell, const std::vector<TestPlan>& plans, Hold hold) {
  Campaign campaign;
  campaign.name = cell.name;
  campaign.capacity_Ah = cell.capacity_Ah;
  campaign.cutoff_V = cell.cutoff_V;
  campaign.series = cell.series;
  campaign.parallel = cell.parallel;
  campaign.logs.reserve(plans.size());
  for (const auto& plan : plans) {
    CampaignLog log;
    log.kind = plan.kind;
    log.file = plan.file;
    log.read.hold = hold;
    log.read.current_sign = "discharge-positive";
    log.ambient_degC = plan.ambient_degC;
    campaign.logs.push_back(std::move(log));
  }
  return campaign;
}

constexpr const char* kCampaignName = "campaign.toml";
constexpr const char* kTruthName = "truth.json";

}  // namespace

std::vector<std::string> SynthesizedNames(const Cell& cell,
                                          const Protocol& protocol,
                                          const SynthesisOptions& options) {
  std::vector<std::string> names;
  for (const auto& plan : protocol.plan(cell, options)) names.push_back(plan.file);
  names.insert(names.end(), {kCampaignName, kTruthName});
  return names;
}

bool IsSynthesized(const std::string& folder) {
  const std::string truth = (fs::path(folder) / kTruthName).string();
  std::error_code none;
  if (!fs::is_regular_file(truth, none)) return false;
  try {
    return ParseJson(ReadTextFile(truth), truth).contains(Json::json_pointer("/run/protocol"));
  } catch (const LoadError&) {
    return false;  // a person's, or damaged
  }
}

std::vector<std::string> DoubtsAboutSynthesis(const Cell& cell,
                                              const Protocol& protocol,
                                              const SynthesisOptions& options) {
  constexpr double kMostNoise = 0.1;  // of the current: beyond it a rest and a load look alike
  std::vector<std::string> doubts;
  double least_A = std::numeric_limits<double>::infinity();
  for (const TestPlan& plan : protocol.plan(cell, options))
    least_A = std::min(least_A, plan.stages[0].current_A * cell.parallel);
  if (options.current_noise_A > kMostNoise * least_A) {
    doubts.push_back(
        fmt::format("the noise of the current, {:.4g} A, is {:.2g} of the least current of these "
                    "logs, {:.4g} A: what reads them may not tell a load from a rest",
                    options.current_noise_A,
                    options.current_noise_A / least_A,
                    least_A));
  }
  if (cell.temperature && cell.temperature->heat && options.ambient_degC.empty()) {
    doubts.push_back(fmt::format(
        "the cell warms under load, and without --ambient-degC no log tells its temperature: what is "
        "identified from them may take the warming for charge transfer; --ambient-degC {:.4g} writes "
        "temperature_degC",
        cell.temperature->reference_K - kZeroCelsius_K));
  }
  return doubts;
}

std::vector<SynthesizedFile> Synthesize(const Cell& cell,
                                        const Protocol& protocol,
                                        const SynthesisOptions& options,
                                        const RunRecord& run,
                                        const std::string& folder,
                                        const std::function<void(double)>& progress) {
  const auto sampling = DecimalStep::Of(options.sampling_s);
  if (!sampling) {
    throw OptionError(fmt::format("option sampling_s: expected at most nine decimals, found {}",
                                  options.sampling_s));
  }
  const auto resolution = DecimalStep::Of(options.voltage_resolution_V);
  if (options.voltage_resolution_V > 0.0 && !resolution) {
    throw OptionError(
        fmt::format("option voltage_resolution_V: expected at most nine decimals, found {}",
                    options.voltage_resolution_V));
  }
  const auto plans = protocol.plan(cell, options);
  for (const auto& plan : plans) CheckPlan(cell, plan, *sampling);
  const Signals signals{cell, options, *sampling, resolution, run.seed};

  NewFolder made(folder);
  FileSet together;
  const auto path = [&](const std::string& name) { return (fs::path(folder) / name).string(); };
  std::vector<std::unique_ptr<CsvWriter>> logs;
  logs.reserve(plans.size());
  for (const auto& plan : plans) {
    std::string columns = "time_s,current_A,voltage_V";
    if (plan.ambient_degC) columns += ",temperature_degC";
    logs.push_back(std::make_unique<CsvWriter>(path(plan.file), columns));
  }
  std::vector<SynthesizedFile> written(plans.size());
  const double total_C = static_cast<double>(plans.size()) * cell.alpha_C();
  std::atomic<double> done_C = 0.0;
  const auto delivered = [&](double charge_C) {
    if (progress) progress((done_C.fetch_add(charge_C) + charge_C) / total_C);
  };
  tbb::parallel_for(
      std::size_t{0},
      plans.size(),
      [&](std::size_t k) {
        const std::size_t log = plans.size() - 1 - k;  // the long logs stand last: begin with them
        written[log] = WriteLog(plans[log], log, signals, *logs[log], delivered);
      },
      tbb::simple_partitioner{});
  StopIfAsked();

  Cell truth = cell;
  Json origin = run.ToJson();
  origin["protocol"] = protocol.name;
  truth.run = std::make_shared<const Json>(std::move(origin));
  std::vector<std::unique_ptr<AtomicFile>> others;
  const auto add = [&](const std::string& name, const std::string& text) {
    others.push_back(std::make_unique<AtomicFile>(path(name)));
    others.back()->Write(text);
    written.push_back({name, 0, text.size()});
  };
  add(kCampaignName, CampaignToToml(CampaignOf(cell, plans, options.hold)));
  add(kTruthName, JsonText(CellToJson(truth)));
  for (const auto& log : logs) log->Commit();
  for (const auto& other : others) other->Commit();
  made.Keep();
  together.Commit();
  return written;
}

}  // namespace lipoid
