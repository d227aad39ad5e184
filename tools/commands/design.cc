// lipoid design altitude|attitude: controller gains by optimization, (6.2)-(6.5).
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "identify/gains/gain_design.h"
#include "model/analysis/placed_gains.h"
#include "model/analysis/poles.h"
#include "model/analysis/stability.h"
#include "model/control/gains.h"
#include "model/core/atomic_file.h"
#include "model/core/counted.h"
#include "model/core/errors.h"
#include "model/core/json_text.h"
#include "model/core/nearest_name.h"
#include "model/core/run_record.h"
#include "model/flight/trim.h"
#include "model/vehicle/vehicle_file.h"
#include "tools/cli/number_range.h"
#include "tools/cli/split.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"
#include "tools/commands/poles_json.h"

namespace lipoid {
namespace {

using cli::Align;
using cli::Significant;

// A longer run is made where it is worth the wait.
enum class Check { kAuto, kAlways, kNever };

constexpr std::array<std::pair<Check, std::string_view>, 3> OptionNames(Check) {
  return {{{Check::kAuto, "auto"}, {Check::kAlways, "always"}, {Check::kNever, "never"}}};
}

constexpr double kPatience_s = 60.0;

Json ToJson(const ErrorGains& gains) {
  return {{"proportional", gains.proportional},
          {"integral", gains.integral},
          {"derivative", gains.derivative}};
}

// The poles of a vehicle's loop at these voltages; empty where the altitude has no integral gain,
// without which hover at xi < 1 is no equilibrium.
Json PolesToJson(const GainDesign& design, Gains gains, const ErrorGains& own) {
  (design.loop == Loop::kAltitude ? gains.altitude : gains.attitude) = own;
  Json rows = Json::array();
  if (!(gains.altitude.integral > 0.0)) return rows;
  for (const auto& [xi, weight] : design.xi)
    rows.push_back(PolesRowToJson(PolesAt(design.loop, design.vehicle, gains, xi)));
  return rows;
}

// The loops of a vehicle that flies with these gains, at the voltages of the design.
std::vector<HoverStability> HoversOf(const GainDesign& design, const Gains& gains) {
  std::vector<HoverStability> hovers;
  for (const auto& [xi, weight] : design.xi) {
    hovers.push_back({"design",
                      xi,
                      CheckLoops(design.vehicle,
                                 gains,
                                 design.controller,
                                 design.options.motor_lag,
                                 HoverAt(design.vehicle, xi))});
  }
  return hovers;
}

std::vector<WeightedXi> WeightedXis(const std::vector<double>& xi, const std::string& weights) {
  std::vector<double> w;
  if (!weights.empty()) {
    for (const std::string& piece : SplitAt(weights, ',')) {
      w.push_back(options_internal::ParseDouble("--weights", piece, Range{0.0, 1e9}));
    }
  }
  if (!w.empty() && w.size() != xi.size()) {
    throw OptionError(fmt::format("option --weights: expected {}, one for each xi, found {}",
                                  Counted(xi.size(), "number"),
                                  w.size()));
  }
  if (!w.empty() && *std::max_element(w.begin(), w.end()) == 0.0) {
    throw OptionError(fmt::format(
        "option --weights: expected a number above 0 among them, found {}, by which no gains are better "
        "than others",
        weights));
  }
  std::vector<WeightedXi> all;
  for (std::size_t k = 0; k < xi.size(); ++k) all.push_back({xi[k], w.empty() ? 1.0 : w[k]});
  return all;
}

// Ten times the population, or the iterations of methods that have none.
OptimizerSettings TenTimesLonger(const OptimizerEntry& optimizer, OptimizerSettings settings) {
  const auto values = optimizer.values(settings);
  const auto longer = [&](std::string_view option) {
    for (const auto& [name, value] : values) {
      if (name != option) continue;
      optimizer.set(settings, name, fmt::format("{}", 10 * std::stol(value)));
      return true;
    }
    return false;
  };
  if (!longer("population")) longer("iterations_per_variable");
  return settings;
}

// Which bounds decided the answer; "": none.
std::string AtBoundText(const std::vector<GainBound>& at_bound, std::string_view law) {
  // Of this law the bounds are those of the weights.
  const std::string_view what =
      law == "lqr" ? "the search for the regulator's weights" : "the search";
  std::vector<std::string> largest;
  std::vector<std::string> options;
  std::vector<std::string> least;
  for (const GainBound& at : at_bound) {
    if (at.largest) {
      largest.push_back(fmt::format("{} = {:.4g}", at.gain, at.value));
      options.push_back(fmt::format("--set design.{}_bound=...", at.gain));
    } else {
      least.push_back(fmt::format("{} = {:.4g}", at.gain, at.value));
    }
  }
  std::vector<std::string> sentences;
  if (!largest.empty()) {
    sentences.push_back(fmt::format(
        "{} ended at its upper bound: {}. The error would be less beyond it; give a higher one "
        "({}) where the motors and the noise of the sensors allow it",
        what,
        fmt::join(largest, ", "),
        fmt::join(options, ", ")));
  }
  if (!least.empty()) {
    sentences.push_back(fmt::format(
        "{} ended at its lower bound, to a ten-thousandth of the upper one: {}. This maneuver gains nothing by it",
        what,
        fmt::join(least, ", ")));
  }
  return fmt::format("{}", fmt::join(sentences, "; "));
}

struct AskedDesign {
  std::string loop;
  std::string vehicle = "mambo-thesis";
  std::string start;
  std::string optimizer = "particle-swarm";
  std::string range;
  std::string weights;
  std::string output;
  bool aware = false;
  Check check = Check::kAuto;
  GainDesign design;
  OptimizerSettings settings;

  [[nodiscard]] bool altitude() const { return design.loop == Loop::kAltitude; }
  [[nodiscard]] const ErrorGains& OfLoop(const Gains& gains) const {
    return altitude() ? gains.altitude : gains.attitude;
  }
};

bool Ask(cli::CommandLine& line, AskedDesign& asked) {
  line.Describe(
      "Finds the error controller's gains of the altitude or the attitude loop: the least squared "
      "error over a maneuver at full voltage (6.2), (6.4), or with --aware summed over the "
      "voltages of a discharge (6.3), (6.5). Motor lag and saturation are included.",
      "lipoid design altitude --aware -o gains.json");
  line.Example("lipoid design attitude --aware --optimizer levenberg-marquardt");
  line.Argument("LOOP", asked.loop, "altitude, or attitude");
  line.Flag("aware", asked.aware, "minimize the error over all xi, instead of at xi = 1 alone");
  line.Text("xi",
            asked.range,
            "RANGE",
            "voltages over the nominal one, FIRST:STEP:LAST (default 0.8:0.01:1 with --aware, 1 "
            "without)");
  line.Text("weights", asked.weights, "W,W,...", "weight of each xi in the cost (default 1)");
  line.Input(
      "vehicle", asked.vehicle, "VEHICLE", "a vehicle file, or the name of a shipped vehicle");
  line.Input(
      "start",
      asked.start,
      "GAINS",
      "where the search starts, and the gains of the other loops: unaware, aware, placed, or a gains "
      "file (default for a Mambo aware with --aware and unaware without, for any other vehicle "
      "placed)");
  line.Text("controller",
            asked.design.controller.law,
            "NAME",
            "inversion, or another of `lipoid list controllers`; lqr: the weights of its regulator "
            "are searched, and its gains follow");
  line.Text("optimizer", asked.optimizer, "NAME", "any of `lipoid list optimizers`");
  line.Option(
      "check",
      asked.check,
      Names(),
      "state the gap of the cost to a run ten times longer, which may take minutes; auto: only "
      "where it takes less than a minute");
  line.OutputOption("output,o", asked.output, "JSON", "gains file for `lipoid fly --gains`");
  line.Group("design", asked.design.options);
  line.Group("controller", asked.design.controller);
  for (const OptimizerEntry& entry : Optimizers()) {
    line.Group(entry.name, entry.options(), [&](std::string_view name, std::string_view text) {
      entry.set(asked.settings, name, text);
    });
  }
  line.ReportOption();
  return line.Parse();
}

// Fills in the design; the gains that the search starts from.
Gains Prepare(AskedDesign& asked, std::uint64_t seed) {
  GainDesign& design = asked.design;
  if (asked.loop != "altitude" && asked.loop != "attitude")
    throw OptionError(UnknownName("loop", asked.loop, {"altitude", "attitude"}));
  design.loop = asked.loop == "altitude" ? Loop::kAltitude : Loop::kAttitude;
  design.vehicle = LoadVehicle(asked.vehicle);
  const Gains start = GainsFor(
      asked.start, design.vehicle, asked.aware ? "aware" : "unaware", design.controller.law);
  design.altitude_gains = start.altitude;
  design.references = start.references;
  if (!asked.altitude()) design.attitude_decay_per_s = AttitudeDecayFor(design.vehicle);
  if (asked.range.empty()) asked.range = asked.aware ? "0.8:0.01:1" : "1";
  design.xi = WeightedXis(ReadRange("xi", asked.range, Range{1e-3, 2.0}), asked.weights);
  asked.settings.context.seed = seed;
  asked.settings.context.threads = 0;

  const double lowest_xi = LowestHoverXi(design.vehicle);
  for (const auto& [xi, weight] : design.xi) {
    if (xi >= lowest_xi) continue;
    throw OptionError(fmt::format(
        "option --xi: expected voltages at which {} can hover, from {:.3f} of the nominal one, found {:g}",
        design.vehicle.name,
        lowest_xi,
        xi));
  }
  WidenBounds(design, asked.OfLoop(start));
  return start;
}

void Summarize(const AskedDesign& asked,
               const GainDesignResult& result,
               const ErrorGains& from,
               Json& summary) {
  const GainDesign& design = asked.design;
  const FoundGains& answer = result.answer();
  const GainProblem problem(design);
  summary["loop"] = asked.loop;
  summary["vehicle"] = design.vehicle.name;
  summary["optimizer"] = asked.optimizer;
  summary["xi"] = Json::array();
  for (const auto& [xi, weight] : design.xi) summary["xi"].push_back(xi);
  summary["controller"] = design.controller.law;
  summary["gains"] = ToJson(answer.gains);
  summary["costs"] = problem.CostsOf(answer.gains);
  summary["bounds"] = ToJson(problem.bounds());
  summary["at_bound"] = Json::array();
  for (const GainBound& at : answer.at_bound) summary["at_bound"].push_back(at.gain);
  summary["cost"] = answer.cost;
  summary["search"] = {{"gains", ToJson(result.search.gains)}, {"cost", result.search.cost}};
  summary["start"] = {
      {"gains", ToJson(from)}, {"cost", result.start_cost}, {"costs", problem.CostsOf(from)}};
  summary["polished_cost"] = result.polished.cost;
  summary["evaluations"] = result.optimization.evaluations;
  summary["gradient_evaluations"] = result.optimization.gradient_evaluations;
  summary["termination"] = options_internal::ToText(result.optimization.termination);
  summary["message"] = result.optimization.message;
  summary["wall_s"] = result.optimization.wall_s;
  summary["improvements"] = Json::array();
  for (const Improvement& better : result.optimization.improvements) {
    // The optimizer sees half of the cost (GainProblem).
    summary["improvements"].push_back({{"evaluations", better.evaluations},
                                       {"wall_s", better.wall_s},
                                       {"cost", 2.0 * better.cost}});
  }
}

// The pole that a loop must have, as the end of a sentence.
std::string DecayText(const AskedDesign& asked) {
  if (asked.altitude()) {
    return fmt::format(" and let its integral follow an emptying battery within {:g} s",
                       1.0 / kAltitudeDecay_per_s);
  }
  if (!(asked.design.attitude_decay_per_s > 0.0)) return "";
  return fmt::format(
      " and let it forget an error within {:.2g} s (to 1/e; {:g} times as long as gains "
      "placed for these motors)",
      1.0 / asked.design.attitude_decay_per_s,
      1.0 / kAttitudeDecayOfPlaced);
}

std::vector<std::string> CautionsAbout(const AskedDesign& asked,
                                       const FoundGains& answer,
                                       const std::vector<HoverStability>& hovers) {
  if (!answer.stable) {
    return {fmt::format(
        "the search found no gains within the bounds that keep the {} loop stable with {:g} times its "
        "gain or its lag{}; "
        "give higher bounds (--set design.proportional_bound=...) or another start. Nothing is "
        "written",
        asked.loop,
        kStabilityMargin,
        DecayText(asked))};
  }
  std::vector<std::string> cautions;
  if (answer.constrained) {
    cautions.push_back(fmt::format(
        "the gains of the least error would not keep the {} loop stable with {:g} times its gain "
        "or its lag{}; these have the least error among those that do",
        asked.loop,
        kStabilityMargin,
        DecayText(asked)));
  }
  if (std::string text = AtBoundText(answer.at_bound, asked.design.controller.law); !text.empty())
    cautions.push_back(std::move(text));
  for (std::string& warning : StabilityWarnings(hovers)) cautions.push_back(std::move(warning));
  return cautions;
}

}  // namespace

cli::ExitCode DesignCommand(cli::CommandLine& line) {
  AskedDesign asked;
  if (!Ask(line, asked)) return cli::ExitCode::kDone;
  const Gains start = Prepare(asked, line.seed());
  const GainDesign& design = asked.design;
  const ErrorGains& from = asked.OfLoop(start);
  const OptimizerEntry& optimizer = FindOptimizer(asked.optimizer);
  line.progress().Update(0.0, "designing");
  const GainDesignResult result = DesignGains(design, from, optimizer, asked.settings);
  const FoundGains& answer = result.answer();

  Json& summary = line.summary();
  Summarize(asked, result, from, summary);
  Gains found = start;
  found.name = fmt::format("{} {}", asked.loop, asked.aware ? "aware" : "unaware");
  (asked.altitude() ? found.altitude : found.attitude) = answer.gains;
  const auto hovers = HoversOf(design, found);
  summary["stable"] = answer.stable;
  summary["constrained"] = answer.constrained;
  summary["loops"] = StabilityToJson(hovers);
  summary["poles"] = PolesToJson(design, start, answer.gains);
  summary["start"]["poles"] = PolesToJson(design, start, from);

  const std::string unit = asked.altitude() ? "m² s" : "rad² s";
  cli::TextTable table({{"", Align::kLeft}, {"K_e"}, {"K_eI"}, {"K_edot"}, {"cost / " + unit}},
                       "Gains of the inner loop, and what they cost.");
  const auto row = [&](std::string name, const ErrorGains& gains, double cost) {
    table.Row({std::move(name),
               Significant(gains.proportional),
               Significant(gains.integral),
               Significant(gains.derivative),
               Significant(cost)});
  };
  row("start: " + start.name, from, result.start_cost);
  row("found", result.search.gains, result.search.cost);
  if (result.missed()) row("from there on", answer.gains, answer.cost);
  const auto gap_percent = [&](double other) {
    return other > 0.0 ? 100.0 * (result.search.cost - other) / other : 0.0;
  };
  const double longer_s = 10.0 * result.optimization.wall_s;
  const bool longer_run =
      asked.check == Check::kAlways || (asked.check == Check::kAuto && longer_s < kPatience_s);
  if (longer_run) {
    if (longer_s > kPatience_s) {
      line.Message("checking with a run ten times longer, about {:.0f} s; --check never skips it",
                   longer_s);
    }
    line.progress().Update(0.0, "checking with a run ten times longer");
    const GainDesignResult longer =
        DesignGains(design, from, optimizer, TenTimesLonger(optimizer, asked.settings));
    row("ten times longer", longer.search.gains, longer.search.cost);
    summary["longer_run"] = {{"gains", ToJson(longer.search.gains)},
                             {"cost", longer.search.cost},
                             {"evaluations", longer.optimization.evaluations},
                             {"wall_s", longer.optimization.wall_s},
                             {"gap_percent", gap_percent(longer.search.cost)}};
  }
  const std::string no_answer = optimizer.WhyNoAnswer(result.optimization);
  if (!no_answer.empty()) line.Message("{}: these gains are where it stopped", no_answer);
  line.Print("{}", table.Text());
  line.Message("{} on {}: {} evaluations in {:.2f} s, {} ({})",
               optimizer.name,
               design.vehicle.name,
               result.optimization.evaluations,
               result.optimization.wall_s,
               options_internal::ToText(result.optimization.termination),
               result.optimization.message);
  line.Message("Levenberg-Marquardt from there on finds {:.3g} % less{}",
               100.0 * (result.search.cost - result.polished.cost) / result.search.cost,
               result.missed()
                   ? ": the search ended beside the least error, and the gains are those "
                     "found from there on"
                   : "");
  if (longer_run) {
    const auto& longer = summary["longer_run"];
    line.Message("a run ten times longer ({} evaluations, {:.1f} s) leaves a gap of {:.3g} %",
                 longer["evaluations"].get<int>(),
                 longer["wall_s"].get<double>(),
                 longer["gap_percent"].get<double>());
  } else if (asked.check == Check::kAuto) {
    line.Message(
        "not compared with a run ten times longer, about {:.0f} s; --check always does that",
        longer_s);
  }

  const std::vector<std::string> cautions = CautionsAbout(asked, answer, hovers);
  for (const std::string& caution : cautions) line.Message("{}", caution);
  summary["cautions"] = cautions;
  if (!answer.stable) return cli::ExitCode::kIncomplete;
  if (!asked.output.empty()) WriteFileAtomically(asked.output, JsonText(GainsToJson(found)));
  return no_answer.empty() ? cli::ExitCode::kDone : cli::ExitCode::kIncomplete;
}

}  // namespace lipoid
