#include "model/battery/time_to_cutoff.h"

#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdint>

#include "model/core/errors.h"

namespace lipoid {

std::optional<double> TimeToCutoff(const Cell& cell,
                                   double current_A,
                                   double initial_soc,
                                   double longest_s,
                                   const Surroundings& surroundings) {
  Require(current_A > 0.0 && longest_s > 0.0 && std::isfinite(longest_s),
          "a current above 0 and a finite time above 0",
          {{"current_A", current_A}, {"longest_s", longest_s}});
  constexpr int kSteps = 30'000;
  const double of_one_A = current_A / cell.parallel;
  const CellModel<double> model(cell.Parameters());
  const auto surplus = [&](const CellModel<double>::State& state) {
    return model.Voltage(state, of_one_A) - cell.cutoff_V;
  };
  auto state = StartAmong(model, initial_soc, surroundings);
  if (surplus(state) <= 0.0) return 0.0;
  const double dt_s = longest_s / kSteps;
  auto step = model.MakeStep(0.0);
  auto before = state;
  for (int k = 0; k < kSteps; ++k) {
    before = state;
    model.Prepare(step, dt_s, state);
    model.Advance(state, of_one_A, step);
    const double after_V = surplus(state);
    if (after_V > 0.0) continue;
    if (std::isnan(after_V)) return std::nullopt;
    const auto within = [&](double part_s) {
      state = before;
      model.Prepare(step, part_s, state);
      model.Advance(state, of_one_A, step);
      return surplus(state);
    };
    const double before_V = within(0.0);
    if (before_V <= 0.0) return k * dt_s;  // a branch without inertia jumped there
    std::uintmax_t iterations = 200;
    const auto bracket =
        boost::math::tools::toms748_solve(within,
                                          0.0,
                                          dt_s,
                                          before_V,
                                          after_V,
                                          boost::math::tools::eps_tolerance<double>(),
                                          iterations);
    return k * dt_s + 0.5 * (bracket.first + bracket.second);
  }
  return std::nullopt;
}

}  // namespace lipoid
