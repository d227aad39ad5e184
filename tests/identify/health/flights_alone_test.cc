#include "identify/health/flights_alone.h"

#include <gtest/gtest.h>

#include <cmath>

#include "identify/health/flights_report.h"
#include "identify/identification.h"
#include "tests/support/synthetic_campaign.h"
#include "tests/support/synthetic_flight.h"
#include "tests/support/throws.h"

namespace lipoid::test {
namespace {

// What flights alone can tell: no diffusion, a branch of seconds.
Cell Simple() {
  Cell cell = NewFlightCell();
  cell.diffusion.reset();
  cell.capacity_Ah = 5.0;
  cell.branches = {{Resistance<double>(0.002), 6.0, {}}};
  return cell;
}

LoadedLog FlightOfKnownStart(const Cell& cell,
                             const FlightPlan& plan,
                             const FlightRecorder& recorder) {
  LoadedLog log = AsLog(LogKind::kFlight, FlyAndLog(cell, 1, plan, recorder, "flight").log.record);
  log.entry.initial_soc = plan.start_soc;
  return log;
}

FlightRecorder Fine() {
  FlightRecorder recorder;
  recorder.voltage_noise_V = 0.001;
  recorder.voltage_step_V = 0.001;
  recorder.lag_s = 0.2;
  return recorder;
}

TEST(FlightsAlone, GiveTheCurveAndTheTotalResistance) {
  const Cell truth = Simple();
  FlightPlan plan;
  plan.start_soc = 0.97;
  const std::vector<LoadedLog> logs{FlightOfKnownStart(truth, plan, Fine())};
  Campaign campaign = CampaignOf(logs, 5.0);
  const FlightsAlone found = IdentifyFlightsAlone(campaign, logs);
  EXPECT_NEAR(found.flights.at(0).lag_s, 0.2, 0.05);
  // Of 6 milliohm; averages over windows blur the first half second of the branch.
  EXPECT_NEAR(found.total_resistance_Ohm, 0.006, 0.04 * 0.006);
  EXPECT_LT(found.flights[0].errors.all.mean_error_percent, 0.1);
  EXPECT_NEAR(found.highest_soc, 0.97, 0.002);
  EXPECT_NEAR(found.lowest_soc, 0.37, 0.01);
  // Without a long rest a curve that is higher and a resistance that is larger say nearly the same: 4 %
  // of the resistance at the 30 A of hover are 7 mV.
  constexpr double kCurve_V = 0.007;
  for (const double soc : {0.45, 0.55, 0.65, 0.75, 0.85, 0.94})
    EXPECT_NEAR(found.cell.open_circuit_voltage(soc), truth.open_circuit_voltage(soc), kCurve_V)
        << soc;
  bool told = false;
  for (const QuantityTrust& q : found.trust.quantities) {
    if (q.name != "r_total") continue;
    told = true;
    EXPECT_LT(q.low, 0.0062);
    EXPECT_GT(q.high, 0.0058);
  }
  EXPECT_TRUE(told);
  EXPECT_FALSE(found.cell.diffusion.has_value());
  EXPECT_EQ(found.cell.branches.size(), 1U);
}

TEST(FlightsAlone, OfACampaignAreACellWithItsUncertainty) {
  FlightPlan plan;
  plan.start_soc = 0.97;
  const std::vector<LoadedLog> logs{FlightOfKnownStart(Simple(), plan, Fine())};
  const Identification found = Identify(CampaignOf(logs, 5.0), logs, {});
  ASSERT_TRUE(found.flights_alone);
  EXPECT_TRUE(found.usable()) << found.quality.Sentence();
  EXPECT_EQ(found.fitted_kinds(), std::vector<LogKind>{LogKind::kFlight});
  ASSERT_TRUE(found.cell.uncertainty);
  EXPECT_NO_THROW((void)ParseCell(CellToJson(found.cell).dump(), "cell.json"));
}

// Of three flights one says where it starts: the others rest at voltages that its curve has.
TEST(FlightsAlone, FindTheirStartsRelativeToOneAnother) {
  const Cell truth = Simple();
  std::vector<LoadedLog> logs;
  std::uint64_t seed = 1;
  for (const double start : {0.7, 0.97, 0.55}) {
    FlightPlan plan;
    plan.start_soc = start;
    plan.charge_share = start == 0.97 ? 0.5 : 0.35;
    plan.seed = seed++;
    logs.push_back(FlightOfKnownStart(truth, plan, Fine()));
    if (start != 0.97) logs.back().entry.initial_soc = 1.0;  // nothing told
  }
  const FlightsAlone found = IdentifyFlightsAlone(CampaignOf(logs, 5.0), logs);
  ASSERT_EQ(found.flights.size(), 3U);
  // The curve is good to some 7 mV (above), and in the middle it rises by 0.5 V over the whole charge.
  constexpr double kStart = 0.02;
  EXPECT_NEAR(found.flights[0].initial_soc, 0.7, kStart);
  EXPECT_NEAR(found.flights[2].initial_soc, 0.55, kStart);
  EXPECT_TRUE(found.flights[0].start_found);
  EXPECT_FALSE(found.flights[1].start_found);
  EXPECT_NEAR(found.lowest_soc, 0.2, 0.02);
  EXPECT_NEAR(found.total_resistance_Ohm, 0.006, 0.05 * 0.006);
}

TEST(FlightsAlone, SayWhichStartIsMissing) {
  const Cell truth = Simple();
  FlightPlan high;
  high.start_soc = 0.97;
  high.charge_share = 0.2;
  FlightPlan low;
  low.start_soc = 0.4;
  low.charge_share = 0.25;
  std::vector<LoadedLog> logs{FlightOfKnownStart(truth, high, Fine()),
                              FlightOfKnownStart(truth, low, Fine())};
  logs[1].entry.file = "low.csv";
  logs[1].entry.initial_soc = 1.0;
  const std::string message =
      MessageOf<LoadError>([&] { (void)IdentifyFlightsAlone(CampaignOf(logs, 5.0), logs); });
  EXPECT_NE(message.find("low.csv rests at 3.7"), std::string::npos) << message;
  EXPECT_NE(message.find("give initial_soc"), std::string::npos) << message;
}

// A flight that is said to start full is told, though full is where logs start that say nothing.
TEST(FlightsAlone, TakeAStartThatIsSaidToBeFull) {
  const Cell truth = Simple();
  FlightPlan plan;
  plan.start_soc = 1.0;
  plan.charge_share = 0.4;
  plan.rest_before_s = 0.0;
  std::vector<LoadedLog> logs{FlightOfKnownStart(truth, plan, Fine())};
  plan.start_soc = 0.9;
  plan.seed = 2;
  logs.push_back(FlightOfKnownStart(truth, plan, Fine()));
  logs[0].entry.initial_soc_told = true;
  const FlightsAlone found = IdentifyFlightsAlone(CampaignOf(logs, 5.0), logs);
  EXPECT_FALSE(found.flights.at(0).start_found);
  EXPECT_EQ(found.flights.at(0).initial_soc, 1.0);
  logs[0].entry.initial_soc_told = false;
  EXPECT_THROW((void)IdentifyFlightsAlone(CampaignOf(logs, 5.0), logs), LoadError);
}

// Beside lab logs a flight is fitted with them, and held against what they say alone.
TEST(FlightsAlone, AreFittedWithLabLogs) {
  const Cell truth = NewFlightCell();
  std::vector<LoadedLog> logs = SyntheticLogs(truth, 5.0, 0.0002);
  const Identification lab = Identify(CampaignOf(logs, 5.0), logs, {});
  FlightPlan plan;
  plan.start_soc = 0.97;
  logs.push_back(FlightOfKnownStart(WithTypicalTemperature(truth), plan, LikePx4()));
  const Identification found = Identify(CampaignOf(logs, 5.0), logs, {});
  EXPECT_FALSE(found.flights_alone);
  ASSERT_TRUE(found.flights_with_lab);
  const FlightsWithLab& with = *found.flights_with_lab;
  ASSERT_TRUE(with.taken) << with.not_taken_because;
  EXPECT_LT(with.flights.at(0).soc_start.low, 0.97);
  EXPECT_GT(with.flights.at(0).soc_start.high, 0.97);
  // Five lab logs with a fifth of a millivolt say nearly all: the flight hardly moves the cell and costs nothing.
  for (const auto& parameter : with.parameters) {
    EXPECT_LE(parameter.error, 1.001 * parameter.by_lab_error) << parameter.name;
    EXPECT_NEAR(parameter.estimate, parameter.by_lab, 3.0 * parameter.by_lab_error + 1e-12)
        << parameter.name;
  }
  EXPECT_NEAR(with.lab_mean_error_with_flights_percent, with.lab_mean_error_percent, 0.01);
  ASSERT_EQ(found.trust.quantities.size(), lab.trust.quantities.size());
  for (std::size_t k = 0; k < lab.trust.quantities.size(); ++k) {
    const QuantityTrust& q = found.trust.quantities[k];
    const auto in_cell = CellQuantity(found.cell, q.name);
    if (!in_cell || !std::isfinite(q.standard_error)) continue;
    // What is reported of a quantity is what the cell has.
    EXPECT_NEAR(q.estimate, *in_cell, 0.02 * q.standard_error) << q.name;
    EXPECT_LE(q.standard_error, 1.001 * lab.trust.quantities[k].standard_error) << q.name;
  }
  ASSERT_TRUE(found.health);
  const FlightHealth& flight = found.health->flights.at(0);
  EXPECT_LT(flight.capacity_Ah.low, 5.0);
  EXPECT_GT(flight.capacity_Ah.high, 5.0);
}

}  // namespace
}  // namespace lipoid::test
