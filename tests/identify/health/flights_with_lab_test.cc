#include "identify/health/flights_with_lab.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <string>

#include "model/battery/cell_parameters.h"
#include "model/battery/uncertain_cell.h"
#include "model/core/parallel.h"
#include "model/statistics/quantiles.h"
#include "tests/support/synthetic_campaign.h"
#include "tests/support/synthetic_flight.h"

namespace lipoid::test {
namespace {

using U = FlightUnknowns;

constexpr double kFree = 1e9;  // degrees of freedom: the lab's noise is known

// A cell of few numbers.
Cell Few() {
  Cell cell = NewFlightCell();
  cell.open_circuit_voltage =
      OpenCircuitVoltage::Linear({0.0, 0.15, 0.4, 0.7, 1.0}, {3.3, 3.65, 3.78, 3.92, 4.18});
  return WithTypicalTemperature(cell);
}

const std::vector<std::string> kNames{
    "alpha", "beta", "r_s", "r_1", "tau_1", "v_oc[0]", "v_oc[1]", "v_oc[2]", "v_oc[3]", "v_oc[4]"};

Eigen::VectorXd Values(const Cell& cell) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(kNames.size()));
  for (std::size_t k = 0; k < kNames.size(); ++k)
    values[static_cast<Eigen::Index>(k)] = CellParameter(cell, kNames[k]).value();
  return values;
}

Cell WithValues(Cell cell, const Eigen::VectorXd& values) {
  for (std::size_t k = 0; k < kNames.size(); ++k)
    SetCellParameter(cell, kNames[k], values[static_cast<Eigen::Index>(k)]);
  return cell;
}

Cell WithErrors(Cell cell, const Eigen::MatrixXd& covariance, double freedom) {
  Cell::Uncertainty uncertainty{.parameters = kNames,
                                .covariance = {},
                                .degrees_of_freedom = freedom,
                                .soc_follows_alpha = false};
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    auto& row = uncertainty.covariance.emplace_back();
    for (Eigen::Index j = 0; j < covariance.cols(); ++j) row.push_back(covariance(i, j));
  }
  cell.uncertainty = std::move(uncertainty);
  return cell;
}

LoadedLog FlightAt25degC(const Cell& cell, const FlightPlan& plan, const FlightRecorder& recorder) {
  LoadedLog log = AsLog(LogKind::kFlight, FlyAndLog(cell, 1, plan, recorder, "flight").log.record);
  log.entry.ambient_degC = 25.0;
  return log;
}

FlightRecorder OfOneCell(double scale, double offset_A) {
  FlightRecorder recorder = LikePx4();
  recorder.voltage_step_V = 0.0025;  // a pack of four shows 10 mV
  recorder.voltage_noise_V = 0.0025;
  recorder.scale = scale;
  recorder.offset_A = offset_A;
  return recorder;
}

// Gauss and Newton with differences, in the units that are given.
struct Fitted {
  Eigen::VectorXd x;
  Eigen::MatrixXd covariance;
};
Fitted LeastSquares(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& residuals,
                    Eigen::VectorXd x,
                    const Eigen::VectorXd& unit) {
  Eigen::MatrixXd normal;
  for (int round = 0; round < 12; ++round) {
    const Eigen::VectorXd r = residuals(x);
    Eigen::MatrixXd jacobian(r.size(), x.size());
    ParallelFor(static_cast<std::size_t>(x.size()), [&](std::size_t column) {
      constexpr double kStep = 1e-3;
      const auto k = static_cast<Eigen::Index>(column);
      Eigen::VectorXd up = x;
      Eigen::VectorXd down = x;
      up[k] += kStep * unit[k];
      down[k] -= kStep * unit[k];
      jacobian.col(k) = (residuals(up) - residuals(down)) / (2.0 * kStep);
    });
    normal = jacobian.transpose() * jacobian;
    x -= unit.cwiseProduct(normal.ldlt().solve(jacobian.transpose() * r));
  }
  return {x,
          unit.asDiagonal() * normal.ldlt().solve(Eigen::MatrixXd::Identity(x.size(), x.size())) *
              unit.asDiagonal()};
}

// The rows of all logs in one problem, solved by differences, against the lab's covariance as the prior of the flight.
TEST(FlightsWithLab, AreTheFitOfTheRowsOfAllLogs) {
  const Cell truth = Few();
  constexpr double kNoise_V = 0.0005;
  std::vector<Record> lab;
  const auto simulate = [&](double amperes, double period_s, double longest_s, std::uint64_t seed) {
    lab.push_back(SimulateLog(
        truth,
        1.0,
        longest_s,
        [=](double t) { return std::fmod(t - 1e-6, period_s) < 60.0 ? amperes : 0.0; },
        "lab",
        kNoise_V,
        seed));
  };
  simulate(25.0, 900.0, 5000.0, 3);
  simulate(10.0, 240.0, 3600.0, 4);
  simulate(15.0, 60.0, 500.0, 5);
  const auto of_lab = [&](const Cell& cell) {
    Eigen::VectorXd all(0);
    for (const Record& record : lab) {
      const auto v =
          Predict(cell, record.time_s, record.current_A, Hold::kBackward, 1.0, {}).voltage_V;
      const Eigen::Index first = all.size();
      all.conservativeResize(first + static_cast<Eigen::Index>(v.size()));
      for (std::size_t k = 0; k < v.size(); ++k)
        all[first + static_cast<Eigen::Index>(k)] = (v[k] - record.voltage_V[k]) / kNoise_V;
    }
    return all;
  };
  // The logs of the lab do not go down to the lower half of the curve: this alone is known of it and of alpha.
  const Eigen::VectorXd scale = Values(truth).cwiseAbs();
  Eigen::VectorXd known(scale.size());
  known << 0.1, 0.3, 0.3, 0.3, 0.3, 0.05, 0.02, 0.02, 0.02, 0.02;
  known = known.cwiseProduct(scale);
  const auto lab_rows = [&](const Eigen::VectorXd& x) {
    const Eigen::VectorXd rows = of_lab(WithValues(truth, x));
    Eigen::VectorXd all(rows.size() + x.size());
    all << rows, (x - Values(truth)).cwiseQuotient(known);
    return all;
  };
  const Fitted by_lab = LeastSquares(lab_rows, Values(truth), 0.01 * scale);

  const LoadedLog flight =
      FlightAt25degC(truth, {.start_soc = 0.95, .seed = 5}, OfOneCell(1.05, 0.2));
  const FlightsWithLab found = FitFlightsWithLab(
      WithErrors(WithValues(truth, by_lab.x), by_lab.covariance, kFree), {flight});
  ASSERT_TRUE(found.taken) << found.not_taken_because;

  const FlightSamples samples = SampleFlight(flight.log);
  const Surroundings among{.measured_degC = {}, .ambient_degC = 25.0, .initial_degC = {}};
  const ColouredNoise& noise = found.flights.at(0).noise;
  const std::vector<int> own{
      U::kStart, U::kSeries, U::kBranches, U::kTau, U::kScale, U::kOffset_A, U::kWarming};
  constexpr Eigen::Index kOwn = 7;
  Eigen::VectorXd mean(kOwn);
  Eigen::VectorXd deviation(kOwn);
  mean << 0.8, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0;
  deviation << 0.5, 0.05, 0.05, 0.05, 0.06, std::max(0.05, 0.01 * samples.largest_A), 0.4;
  const ReferenceCell reference = SameCell(truth, true);
  const FlightModel model(reference, samples.record, among);
  const Eigen::Index cells = scale.size();
  const auto all_rows = [&](const Eigen::VectorXd& x) {
    const Eigen::VectorXd of = lab_rows(x.head(cells));
    Eigen::VectorXd unknowns = Eigen::VectorXd::Zero(model.size());
    for (std::size_t k = 0; k < own.size(); ++k)
      unknowns[own[k]] = x[cells + static_cast<Eigen::Index>(k)];
    Eigen::MatrixXd windows = samples.InWindows(
        model.VoltageOf(WithValues(truth, x.head(cells)), unknowns), found.flights[0].lag_s.value);
    windows.col(0) -= samples.voltage_V;
    noise.Whiten(samples.time_s, windows);
    Eigen::VectorXd all(of.size() + windows.rows() + kOwn);
    all << of, windows.col(0), (x.tail(kOwn) - mean).cwiseQuotient(deviation);
    return all;
  };
  Eigen::VectorXd from(cells + kOwn);
  from << by_lab.x, 0.95, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0;
  Eigen::VectorXd unit(cells + kOwn);
  unit << 0.01 * scale, 0.1 * deviation;
  const Fitted stacked = LeastSquares(all_rows, from, unit);

  const Eigen::VectorXd values = Values(found.cell);
  // Second order of the lab's cost, and what the directions that are all but known leave out.
  constexpr double kOfAnError = 0.1;
  constexpr double kOfTheError = 0.05;
  double told = 1.0;
  for (Eigen::Index k = 0; k < cells; ++k) {
    const auto& parameter = found.parameters.at(static_cast<std::size_t>(k));
    const double error = std::sqrt(stacked.covariance(k, k));
    EXPECT_NEAR(values[k], stacked.x[k], kOfAnError * error) << parameter.name;
    EXPECT_NEAR(parameter.error, error, kOfTheError * error) << parameter.name;
    EXPECT_LT(parameter.error, 1.001 * parameter.by_lab_error) << parameter.name;
    told = std::min(told, parameter.error / parameter.by_lab_error);
  }
  EXPECT_LT(told, 0.8);  // the flight does tell something
  EXPECT_NEAR(found.flights[0].soc_start.value, stacked.x[cells], 0.001);
}

// What a lab may have said of a cell.
Eigen::MatrixXd LabCovariance(const Cell& cell) {
  Eigen::VectorXd error(static_cast<Eigen::Index>(kNames.size()));
  error << 0.03, 0.06, 0.04, 0.08, 0.15, 0.0, 0.0, 0.0, 0.0, 0.0;
  error = error.cwiseProduct(Values(cell));
  error.tail(5).setConstant(0.005);
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(error.size(), error.size());
  for (Eigen::Index i = 5; i < error.size(); ++i) {
    for (Eigen::Index j = 5; j < error.size(); ++j)
      if (i != j) correlation(i, j) = 0.4;
  }
  return error.asDiagonal() * correlation * error.asDiagonal();
}

// Cells of which a lab with these errors would have said what they are, each with one or two flights by sensors that are off.
TEST(FlightsWithLabCoverage, IntervalsCoverTheTruth) {
  constexpr int kCells = 40;
  constexpr std::uint64_t kSeed = 20261123;
  std::mt19937_64 engine(kSeed);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const Cell lab = Few();
  const Eigen::MatrixXd covariance = LabCovariance(lab);
  const Eigen::MatrixXd factor = covariance.llt().matrixL();
  int taken = 0;
  std::map<std::string, int> covered;
  std::map<std::string, double> error_over_that_of_lab;
  for (int k = 0; k < kCells; ++k) {
    Eigen::VectorXd z(covariance.rows());
    for (double& one : z) one = normal(engine);
    const Cell truth = WithValues(lab, Values(lab) + factor * z);
    std::vector<LoadedLog> flights;
    std::vector<double> starts, scales;
    const double scale = 0.9 + 0.2 * uniform(engine);
    for (int f = 0; f < 1 + k % 2; ++f) {
      FlightPlan plan;
      plan.start_soc = 0.85 + 0.15 * uniform(engine);
      plan.charge_share = plan.start_soc - 0.1 - 0.2 * uniform(engine);
      plan.seed = kSeed + static_cast<std::uint64_t>(2 * k + f);
      FlightRecorder recorder = OfOneCell(scale, 0.4 * (uniform(engine) - 0.5));
      flights.push_back(FlightAt25degC(truth, plan, recorder));
      starts.push_back(plan.start_soc);
      scales.push_back(scale);
    }
    const FlightsWithLab found = FitFlightsWithLab(WithErrors(lab, covariance, kFree), flights);
    if (!found.taken) {
      std::printf("%d: %s\n", k, found.not_taken_because.c_str());
      continue;
    }
    ++taken;
    const auto look = [&](const std::string& name, double value, double low, double high) {
      if (low <= value && value <= high) ++covered[name];
    };
    const Eigen::VectorXd true_values = Values(truth);
    for (std::size_t p = 0; p < kNames.size(); ++p) {
      const auto& parameter = found.parameters.at(p);
      const double reach = Reach95(found.cell.uncertainty->degrees_of_freedom) * parameter.error;
      look(parameter.name,
           true_values[static_cast<Eigen::Index>(p)],
           parameter.estimate - reach,
           parameter.estimate + reach);
      error_over_that_of_lab[parameter.name] += parameter.error / parameter.by_lab_error;
    }
    const auto& flight = found.flights.at(0);
    look("start", starts[0], flight.soc_start.low, flight.soc_start.high);
    look("scale", scales[0], flight.current_scale.low, flight.current_scale.high);
  }
  // Of 40 intervals of 95 % fewer than 34 hold the truth once in 300 times.
  constexpr int kLeast = 34;
  int all = 0;
  EXPECT_GE(taken, kCells - 1);  // the limit is passed once in a thousand
  for (const auto& [name, count] : covered) {
    std::printf("%-22s %3d of %3d intervals hold the truth", name.c_str(), count, taken);
    if (error_over_that_of_lab.contains(name))
      std::printf("; error %.2f of that by the lab", error_over_that_of_lab[name] / taken);
    std::printf("\n");
    EXPECT_GE(count, kLeast) << name;
    all += count;
  }
  EXPECT_GE(100 * all, 92 * taken * static_cast<int>(covered.size()));
  EXPECT_LT(error_over_that_of_lab["v_oc[2]"] / taken, 0.8);
}

TEST(FlightsWithLab, OfAnAgedPackAreNotTaken) {
  const Cell lab = Few();
  Cell aged = lab;
  aged.diffusion->alpha_C *= 0.75;
  aged.series_resistance_Ohm = 2.0 * aged.series_resistance_Ohm(0.5);
  const Cell with_errors = WithErrors(lab, LabCovariance(lab), kFree);
  const FlightsWithLab found = FitFlightsWithLab(
      with_errors, {FlightAt25degC(aged, {.start_soc = 0.95, .seed = 7}, OfOneCell(1.0, 0.0))});
  EXPECT_FALSE(found.taken);
  EXPECT_EQ(Values(found.cell), Values(lab));
  EXPECT_GT(found.distance, found.distance_limit);
  EXPECT_NE(found.not_taken_because.find("contradict the lab logs"), std::string::npos)
      << found.not_taken_because;
}

// In flight the heat balance stands in for the self-heating that a lab found, whose errors stay.
TEST(FlightsWithLab, SayNothingOfASelfHeatingOfTheLab) {
  const Cell truth = Few();
  Cell lab = WithErrors(truth, LabCovariance(truth), kFree);
  lab.temperature.reset();
  lab.temperature_assumed = false;
  lab.self_heating =
      Cell::SelfHeating{.time_constant_s = 300.0, .resistance_drop_Ohm_per_A2 = 1e-6};
  lab.uncertainty->parameters.emplace_back("rho_h");
  for (auto& row : lab.uncertainty->covariance) row.push_back(0.0);
  lab.uncertainty->covariance.emplace_back(kNames.size() + 1, 0.0).back() = 1e-14;
  const FlightsWithLab found = FitFlightsWithLab(
      lab, {FlightAt25degC(truth, {.start_soc = 0.95, .seed = 7}, OfOneCell(1.0, 0.0))});
  ASSERT_TRUE(found.taken) << found.not_taken_because;
  ASSERT_TRUE(found.cell.self_heating.has_value());
  EXPECT_FALSE(found.cell.temperature.has_value());
  EXPECT_NEAR(found.cell.self_heating->resistance_drop_Ohm_per_A2, 1e-6, 1e-9);
  EXPECT_EQ(found.cell.uncertainty->parameters, lab.uncertainty->parameters);
  EXPECT_NEAR(found.cell.uncertainty->covariance.back().back(), 1e-14, 1e-16);
  EXPECT_LT(found.cell.uncertainty->covariance[7][7], 0.9 * lab.uncertainty->covariance[7][7]);
}

TEST(FlightsWithLab, NeedTheErrorsOfTheLab) {
  const Cell lab = Few();
  const FlightsWithLab found =
      FitFlightsWithLab(lab, {FlightAt25degC(lab, {.start_soc = 0.95}, OfOneCell(1.0, 0.0))});
  EXPECT_FALSE(found.taken);
  EXPECT_NE(found.not_taken_because.find("how uncertain"), std::string::npos);
}

}  // namespace
}  // namespace lipoid::test
