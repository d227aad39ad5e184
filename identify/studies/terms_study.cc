// How many diffusion modes are enough? (4.61) fitted with M modes of (4.46), with and without the
// quasi-static tail. Without it the sum loses the share (pi²/6 - sum_{m<=M} 1/m²)/(pi²/6) of the
// steady unavailable charge (4.41), which beta and r_s then make up for. What they should be is
// taken from the most modes with the tail.

#include <fmt/format.h>

#include <algorithm>

#include "identify/studies/pulse_study.h"
#include "identify/studies/study.h"
#include "model/core/counted.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

constexpr int kTerms[] = {1, 2, 3, 5, 10, 20, 50, 100};

double LostSharePercent(int terms, bool tail) {
  return tail ? 0.0 : 100.0 * TailSum(terms) / TailSum(0);  // of (4.41)
}

struct Fitted {
  int terms;
  bool tail;
  PulseFitResult fit;
};

}  // namespace

StudyResult StudyTerms(const StudyInput& input, const StudyProgress& progress) {
  if (!input.options.pulses.diffusion)
    throw OptionError(
        "study terms is about the diffusion, which pulses.diffusion=false leaves out");
  const PulseFitOptions usual;
  if (input.options.pulses.terms != usual.terms || input.options.pulses.tail != usual.tail) {
    throw OptionError(
        "options --set pulses.terms and pulses.tail: this study fits many numbers of terms, with and "
        "without the tail; leave them out");
  }
  progress("stages before", 0.0);
  const PulseStudy study(input);
  std::vector<Fitted> fitted;
  double share = 0.1;
  for (const bool tail : {true, false}) {
    for (const int terms : kTerms) {
      progress(fmt::format("{} terms", terms), share);
      share += 0.9 / static_cast<double>(2 * std::size(kTerms));
      const SweepParameters* previous = fitted.empty() ? nullptr : &fitted.back().fit.parameters;
      fitted.push_back(
          {terms,
           tail,
           study.Fit(study.Sweep(terms, tail), input.options.pulses.branches, previous)});
    }
  }
  // The last with the tail.
  const PulseFitResult& best = fitted[std::size(kTerms) - 1].fit;
  const SweepParameters& reference = best.parameters;

  StudyResult result;
  result.columns = {{"terms", "terms"},
                    {"tail", "tail"},
                    {"wall_s", "time / s", 1.0, 3},
                    {"rmse_V", "rmse / mV", 1e3, 5},
                    {"beta_per_sqrt_s", "beta / s^-1/2", 1.0, 5},
                    {"beta_bias_percent", "beta off by / %", 1.0, 3},
                    {"series_resistance_Ohm", "r_s / Ohm", 1.0, 5},
                    {"series_resistance_bias_Ohm", "r_s off by / mOhm", 1e3, 3},
                    {"lost_share_percent", "lost of (4.41) / %", 1.0, 3},
                    {"at_bound", "at bound"}};
  std::vector<NamedFit> named;
  for (const auto& [terms, tail, fit] : fitted) {
    const SweepParameters& p = fit.parameters;
    named.push_back({Counted(terms, "term") + (tail ? " and the tail" : ""), &fit});
    result.rows.push_back(
        {{"terms", terms},
         {"tail", tail},
         {"wall_s", fit.wall_s},
         {"rmse_V", fit.errors.rmse},
         {"beta_per_sqrt_s", p.beta_per_sqrt_s},
         {"beta_bias_percent", 100.0 * (p.beta_per_sqrt_s / reference.beta_per_sqrt_s - 1.0)},
         {"series_resistance_Ohm", p.series_resistance_Ohm},
         {"series_resistance_bias_Ohm", p.series_resistance_Ohm - reference.series_resistance_Ohm},
         {"lost_share_percent", LostSharePercent(terms, tail)},
         {"termination", options_internal::ToText(fit.termination)},
         {"at_bound", fit.at_bound},
         {"parameters", study.Parameters(p)}});
  }
  result.remarks.push_back(fmt::format(
      "beta and r_s are off by what they differ from the fit with {} terms and the tail",
      kTerms[std::size(kTerms) - 1]));
  if (std::count(best.fixed.begin(), best.fixed.end(), "beta") > 0) {
    result.remarks.push_back(
        fmt::format("beta is held at {:.4g} s^-1/2 in every fit: that it is off by 0 says nothing",
                    reference.beta_per_sqrt_s));
  }
  if (std::count(best.at_bound.begin(), best.at_bound.end(), "beta") > 0) {
    result.remarks.push_back(fmt::format(
        "beta is at its bound of {:.4g} s^-1/2 in the fit that the others are compared with: these "
        "logs do not show what a truncation does to beta, and a beta that is off by 0 says nothing",
        reference.beta_per_sqrt_s));
  }
  TellWhetherConverged(named, result);
  return result;
}

}  // namespace lipoid
