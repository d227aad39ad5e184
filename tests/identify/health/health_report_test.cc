// What is said first of the health of a pack.
#include "identify/health/health_report.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace lipoid {
namespace {

FlightHealth Flight(const char* file, bool converged) {
  FlightHealth flight;
  flight.file = file;
  flight.capacity_Ah = {4.0, 3.5, 4.5, {}};
  flight.resistance_Ohm = {0.05, 0.04, 0.06, {}};
  flight.converged = converged;
  return flight;
}

HealthReport Of(std::vector<FlightHealth> flights) {
  HealthReport report;
  report.reference = "g5";
  report.new_capacity_Ah = 5.0;
  for (FlightHealth& flight : flights) flight.new_resistance_Ohm = 0.04;
  report.flights = std::move(flights);
  return report;
}

TEST(HealthReport, SaysFirstThatASearchDidNotConverge) {
  const HealthReport one = Of({Flight("a.csv", false)});
  EXPECT_TRUE(IsDoubted(one));
  ASSERT_EQ(FirstLines(one).size(), 1U);
  EXPECT_EQ(
      FirstLines(one)[0],
      "the search did not converge: these numbers are where it stopped; give a flight that begins at "
      "rest and takes half of the charge. By the fit: capacity 4 Ah (80 % of new), 95 % from 3.5 to 4.5 "
      "Ah; resistance 50 mOhm (125 % of new), 95 % from 40 to 60 mOhm");
  const Json flight = HealthToJson(one).at("flights")[0];
  EXPECT_FALSE(flight.at("converged").get<bool>());
  EXPECT_EQ(flight.at("doubted_because").get<std::string>().find("the search did not converge"),
            0U);

  const HealthReport two = Of({Flight("a.csv", false), Flight("b.csv", true)});
  EXPECT_TRUE(IsDoubted(two));
  EXPECT_EQ(FirstLines(two)[0], "the search did not converge for 1 of 2 flights: a.csv");
}

TEST(HealthReport, DoubtsNoSearchThatConverged) {
  const HealthReport one = Of({Flight("a.csv", true)});
  EXPECT_FALSE(IsDoubted(one));
  EXPECT_EQ(FirstLines(one)[0].find("capacity 4 Ah"), 0U) << FirstLines(one)[0];
  const Json flight = HealthToJson(one).at("flights")[0];
  EXPECT_TRUE(flight.at("converged").get<bool>());
  EXPECT_TRUE(flight.at("doubted_because").is_null());
}

TEST(HealthReport, ASearchThatDidNotConvergeHasNoPartInTheTrend) {
  std::vector<FlightHealth> flights;
  for (const double capacity_Ah : {5.0, 4.8, 1.0, 4.6, 4.4, 9.0}) {
    FlightHealth flight = Flight("a.csv", capacity_Ah != 1.0);
    flight.counted_capacity_Ah = {capacity_Ah, 0.9 * capacity_Ah, 1.1 * capacity_Ah, {}};
    flight.log_capacity_deviation = 0.01;
    if (capacity_Ah == 9.0) flight.same_rows_as = "a.csv";
    flight.place = flights.size();
    flights.push_back(flight);
  }
  const auto trend =
      TrendOf(flights, &FlightHealth::counted_capacity_Ah, &FlightHealth::log_capacity_deviation);
  ASSERT_TRUE(trend);
  EXPECT_EQ(trend->flights, 4U);
  EXPECT_NEAR(trend->first.value, 5.0, 0.1);
  EXPECT_NEAR(trend->last.value, 4.4, 0.1);
}

// The first three flights are logged ten times as often: their resistance is that after a shorter time, and a fifth smaller.
TEST(HealthReport, ATrendOfResistanceIsOfWhatTheReferenceHasThere) {
  std::vector<FlightHealth> flights;
  for (int k = 0; k < 6; ++k) {
    FlightHealth flight = Flight("a.csv", true);
    flight.reference_resistance_Ohm = k < 3 ? 0.04 : 0.05;
    const double counted_Ohm = 1.5 * flight.reference_resistance_Ohm;
    flight.counted_resistance_Ohm = {counted_Ohm, 0.9 * counted_Ohm, 1.1 * counted_Ohm, {}};
    flight.log_resistance_deviation = 0.05;
    flight.place = flights.size();
    flights.push_back(flight);
  }
  const auto trend = TrendOf(flights,
                             &FlightHealth::counted_resistance_Ohm,
                             &FlightHealth::log_resistance_deviation,
                             &FlightHealth::reference_resistance_Ohm);
  ASSERT_TRUE(trend);
  EXPECT_NEAR(trend->change_percent.value, 0.0, 1e-9);
  EXPECT_NEAR(trend->first.value, 0.075, 1e-12);  // where the last flight has it
}

}  // namespace
}  // namespace lipoid
