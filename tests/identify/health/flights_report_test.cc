#include "identify/health/flights_report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "model/battery/cell_file.h"
#include "model/battery/cell_parameters.h"
#include "model/battery/uncertain_cell.h"
#include "model/statistics/quantiles.h"

namespace lipoid {
namespace {

constexpr double kError_Ohm = 0.002;

Cell ByLab() {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.uncertainty = Cell::Uncertainty{.parameters = {"r_s"},
                                       .covariance = {{kError_Ohm * kError_Ohm}},
                                       .degrees_of_freedom = 12.0,
                                       .soc_follows_alpha = false};
  return cell;
}

// Flights that move r_s by one standard error and leave a quarter of its variance.
FlightsWithLab Moving(const Cell& by_lab) {
  FlightsWithLab flights;
  flights.taken = true;
  flights.moves = PrincipalMoves(UncertainCell(by_lab), 0.0);
  flights.coordinates = Eigen::VectorXd::Constant(1, flights.moves(0, 0) > 0.0 ? 1.0 : -1.0);
  flights.coordinate_covariance = Eigen::MatrixXd::Constant(1, 1, 0.25);
  flights.cell = by_lab;
  SetCellParameter(flights.cell, "r_s", *CellParameter(by_lab, "r_s") + kError_Ohm);
  return flights;
}

TEST(FlightsReport, MovesWhatIsReportedOfTheLab) {
  const Cell by_lab = ByLab();
  const double r_Ohm = *CellParameter(by_lab, "r_s");
  const double reach_Ohm = Reach95(12.0) * kError_Ohm;
  TrustReport trust;
  for (const char* name : {"r_s", "beta", "nothing"}) {
    QuantityTrust q;
    q.name = name;
    q.estimate = r_Ohm;
    q.standard_error = kError_Ohm;
    q.low = r_Ohm - reach_Ohm;
    q.high = r_Ohm + reach_Ohm;
    trust.quantities.push_back(std::move(q));
  }
  MoveTrust(by_lab, Moving(by_lab), trust);
  EXPECT_NEAR(trust.quantities[0].estimate, r_Ohm + kError_Ohm, 1e-12);
  EXPECT_NEAR(trust.quantities[0].standard_error, 0.5 * kError_Ohm, 1e-9);
  EXPECT_NEAR(trust.quantities[0].low, r_Ohm + kError_Ohm - 0.5 * reach_Ohm, 1e-9);
  EXPECT_NEAR(trust.quantities[0].high, r_Ohm + kError_Ohm + 0.5 * reach_Ohm, 1e-9);
  // What does not depend on it, and what no cell has.
  for (const std::size_t k : {1U, 2U}) {
    EXPECT_NEAR(trust.quantities[k].standard_error, kError_Ohm, 1e-12);
    EXPECT_NEAR(trust.quantities[k].estimate, r_Ohm, 1e-12);
  }
}

TEST(FlightsReport, ReadsQuantitiesOfACell) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.series_resistance_Ohm = Resistance<double>({0.0, 1.0}, {0.2, 0.1});
  cell.branches = {{Resistance<double>(0.03), 45.0, {}}};
  EXPECT_NEAR(CellQuantity(cell, "r_s(0.5)").value(), 0.15, 1e-12);
  EXPECT_NEAR(CellQuantity(cell, "r_total(0.2)").value(), 0.21, 1e-12);
  EXPECT_NEAR(CellQuantity(cell, "tau_1").value(), 45.0, 1e-12);
  EXPECT_FALSE(CellQuantity(cell, "r_total"));
  EXPECT_FALSE(CellQuantity(cell, "r_7(0.5)"));
}

TEST(FlightsReport, SaysWhyFlightsAreNotTaken) {
  FlightsWithLab found;
  found.not_taken_because = "the flights contradict the lab logs";
  EXPECT_EQ(FlightsWithLabText(found),
            "The cell is that of the lab logs alone: the flights contradict the lab logs.");
}

}  // namespace
}  // namespace lipoid
