// lipoid vehicle ... -o FILE.toml: a vehicle file from what its builder knows.
#include <fmt/ranges.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>

#include "identify/vehicle/bench_table.h"
#include "identify/vehicle/vehicle_builder.h"
#include "model/core/atomic_file.h"
#include "model/core/errors.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"

namespace lipoid {
namespace {

constexpr double kSmallest = 1e-9;

// What has no default and must be there.
struct Required {
  std::optional<double> mass_g;
  std::optional<double> frame_mm;
  std::optional<int> series;
  std::optional<double> propeller_in;

  void Check() const {
    std::vector<std::string_view> missing;
    if (!mass_g) missing.emplace_back("--mass-g");
    if (!frame_mm) missing.emplace_back("--frame-mm");
    if (!series) missing.emplace_back("--series");
    if (!propeller_in) missing.emplace_back("--propeller-in");
    if (missing.empty()) return;
    throw OptionError(fmt::format("no vehicle without {}: give {}",
                                  fmt::join(missing, ", "),
                                  missing.size() == 1 ? "it" : "them"));
  }
};

struct EscOptions {
  double resistance_mOhm = 0.0;
  double switching_ns = 0.0;
  double pwm_kHz = 0.0;
  std::optional<double> diode_V;
};

void DeclareBody(cli::CommandLine& line, BuilderNumbers& numbers, Required& required) {
  line.Text("name", numbers.name, "NAME", "name of the vehicle (default the name of the file)");
  line.Option("mass-g",
              required.mass_g,
              Range{kSmallest, 1e6},
              "mass of all that takes off, with battery and without payload, g");
  line.Option("payload-g", numbers.payload_g, Range{0.0, 1e6}, "mass of the payload, g");
  line.Option("frame-mm",
              required.frame_mm,
              Range{1.0, 1e5},
              "distance from a motor to the opposite one across the frame, mm");
  line.Option("layout", numbers.layout, Names(), "layout of the rotors (docs/vehicles.md)");
  line.Option("front-right-turns",
              numbers.front_right_turns,
              Names(),
              "how the first rotor of the layout turns, seen from above");
  line.Option("series",
              required.series,
              Range{1, 100},
              "number of cells in series of the pack; the nominal voltage is 4.2 V for each");
  line.Option(
      "avionics-W", numbers.avionics_W, Range{0.0, 1e4}, "power of everything but the motors, W");
  line.Option("drag-N-s-per-m",
              numbers.drag_N_s_per_m,
              Range{0.0, 1e3},
              "linear drag, N for each m/s through the air (default 0.3 per second of the mass)");
  line.Option("lower-rotor-thrust-ratio",
              numbers.lower_rotor_thrust_ratio,
              Range{kSmallest, 1.0},
              "thrust of the lower rotor of a coaxial pair over that of the upper one at the same "
              "speed (default 0.75)");
}

void DeclareMotor(cli::CommandLine& line, BuilderNumbers& numbers) {
  line.Option("kv-rpm-per-V",
              numbers.kv_rpm_per_V,
              Range{1.0, 1e6},
              "KV of the motor: speed without load for each volt, rpm/V");
  line.Option("winding-resistance-Ohm",
              numbers.winding_resistance_Ohm,
              Range{1e-6, 1e3},
              "resistance of the motor between two of its three wires, Ohm");
  line.Option(
      "no-load-A",
      numbers.no_load_A,
      Range{0.0, 100.0},
      "current of the motor without propeller, A; beside --bench-table it holds the friction");
  line.Option("no-load-V",
              numbers.no_load_V,
              Range{0.1, 1000.0},
              "voltage at which --no-load-A was measured, V");
  line.Option(
      "rotor-inertia-kg-m2",
      numbers.rotor_inertia_kg_m2,
      Range{1e-15, 10.0},
      "moment of inertia of rotor and propeller, kg m² (default from the propeller's mass)");
  line.Option("propeller-g",
              numbers.propeller_g,
              Range{1e-3, 1e5},
              "mass of a propeller, g (default 0.085 times the square of its inches)");
}

void DeclarePropeller(cli::CommandLine& line,
                      BuilderNumbers& numbers,
                      Required& required,
                      std::string& bench_file) {
  line.Option(
      "propeller-in", required.propeller_in, Range{0.1, 1000.0}, "diameter of a propeller, inch");
  line.Option("pitch-in",
              numbers.pitch_in,
              Range{0.0, 1000.0},
              "pitch of a propeller, inch; coefficients typical of it are then assumed");
  line.Option("blades", numbers.blades, Range{2, 8}, "number of blades of a propeller");
  line.Option("thrust-coefficient",
              numbers.thrust_coefficient,
              Range{1e-4, 1.0},
              "C_T = T/(rho n² D⁴) of the propeller, n in turns per second");
  line.Option("power-coefficient",
              numbers.power_coefficient,
              Range{1e-5, 1.0},
              "C_P = P/(rho n³ D⁵) of the propeller, n in turns per second");
  line.Input("bench-table",
             bench_file,
             "CSV",
             "thrust stand: throttle, voltage, current, thrust and, where there is one, speed; "
             "units in the header (docs/formats.md)");
}

void DeclareEsc(cli::CommandLine& line, EscOptions& esc) {
  line.Option("esc-resistance-mOhm",
              esc.resistance_mOhm,
              Range{0.0, 1e4},
              "resistance of the transistors of a speed controller in a motor's current, mOhm");
  line.Option("esc-switching-ns",
              esc.switching_ns,
              Range{0.0, 1e6},
              "mean time that a transistor takes to switch, ns");
  line.Option("esc-pwm-kHz",
              esc.pwm_kHz,
              Range{0.0, 1000.0},
              "frequency of its pulse width modulation, kHz; with --bench-table and without "
              "--esc-switching-ns the time is fitted");
  line.Option("esc-diode-V",
              esc.diode_V,
              Range{0.0, 5.0},
              "drop of the diodes of a controller that does not rectify synchronously, V (default "
              "it does)");
}

SpeedController ControllerOf(const EscOptions& options) {
  return {.resistance_Ohm = 1e-3 * options.resistance_mOhm,
          .switching_time_s = 1e-9 * options.switching_ns,
          .switching_frequency_Hz = 1e3 * options.pwm_kHz,
          .diode_V = options.diode_V.value_or(0.0),
          .synchronous = !options.diode_V.has_value()};
}

Json BenchToJson(const BenchFit& fit) {
  Json parameters = Json::array();
  for (const BenchQuantity& quantity : fit.Quantities()) {
    parameters.push_back(
        {{"name", quantity.name},
         {"estimate", NumberOrNull(quantity.estimate)},
         {"standard_error", NumberOrNull(quantity.standard_error)},
         {"interval_95", {NumberOrNull(quantity.low_95), NumberOrNull(quantity.high_95)}},
         {"fitted", quantity.fitted}});
  }
  return {{"converged", fit.converged},
          {"message", fit.message},
          {"degrees_of_freedom", fit.degrees_of_freedom},
          {"speed_rms_percent", fit.has_speed ? Json(100.0 * fit.speed_rms) : Json(nullptr)},
          {"current_rms_percent", 100.0 * fit.current_rms},
          {"thrust_rms_percent", 100.0 * fit.thrust_rms},
          {"parameters", std::move(parameters)}};
}

void Report(cli::CommandLine& line, const VehicleDraft& draft, const std::optional<BenchFit>& fit) {
  const Trim& hover = draft.hover;
  cli::TextTable table({{"hover", cli::Align::kLeft}, {"value"}, {"unit", cli::Align::kLeft}},
                       fmt::format("Hover of {}.", draft.vehicle.name));
  table.Row({"battery", cli::Significant(hover.battery_V), "V"});
  table.Row({"current of the battery", cli::Significant(hover.battery_A), "A"});
  table.Row({"power of the battery", cli::Significant(draft.hover_power_W), "W"});
  table.Row({"current of a motor", cli::Significant(hover.motor_A), "A"});
  table.Row({"speed", cli::Significant(hover.speed_rad_per_s), "rad/s"});
  table.Row({"duty cycle", cli::Significant(hover.duty), ""});
  table.Row({"largest thrust over weight", cli::Significant(draft.thrust_to_weight), ""});
  line.Print("{}", table.Text());
  Json sources = Json::object();
  for (const auto& [key, from] : draft.sources) sources[key] = from;
  line.summary()["vehicle"] = draft.vehicle.name;
  line.summary()["sources"] = std::move(sources);
  line.summary()["assumed"] = draft.assumed;
  line.summary()["cautions"] = draft.cautions;
  line.summary()["hover"] = {{"battery_V", hover.battery_V},
                             {"battery_A", hover.battery_A},
                             {"power_W", draft.hover_power_W},
                             {"motor_A", hover.motor_A},
                             {"speed_rad_per_s", hover.speed_rad_per_s},
                             {"duty", hover.duty}};
  line.summary()["thrust_to_weight"] = draft.thrust_to_weight;
  line.summary()["bench"] = fit ? BenchToJson(*fit) : Json();
}

}  // namespace

cli::ExitCode VehicleCommand(cli::CommandLine& line) {
  BuilderNumbers numbers;
  Required required;
  EscOptions esc;
  std::string bench_file;
  std::string output;
  std::vector<std::string> inertia;
  line.Describe(
      "Writes a vehicle file from what a builder knows: weights and sizes, what is printed on motor "
      "and propeller, or a table of a thrust stand. Each number in the file says where it is from "
      "and which are assumed. Shows the hover at 3.7 V a cell.",
      "lipoid vehicle --mass-g 1350 --frame-mm 450 --series 4 --propeller-in 9.4 --kv-rpm-per-V 920 "
      "--bench-table bench.csv -o mine.toml");
  line.Example(
      "lipoid vehicle --mass-g 650 --frame-mm 220 --series 4 --propeller-in 5 --pitch-in 4.3 "
      "--blades 3 --kv-rpm-per-V 2400 --winding-resistance-Ohm 0.06 --no-load-A 1.2 -o racer.toml");
  line.Output(output, "TOML", "the vehicle file");
  DeclareBody(line, numbers, required);
  DeclareMotor(line, numbers);
  DeclarePropeller(line, numbers, required, bench_file);
  DeclareEsc(line, esc);
  line.Texts(
      "inertia-kg-m2",
      inertia,
      "JX JY JZ",
      "moments of inertia about the axes ahead, right and down, kg m² (default from mass and "
      "frame)");
  line.ReportOption();
  if (!line.Parse()) return cli::ExitCode::kDone;

  required.Check();
  numbers.mass_g = *required.mass_g;
  numbers.frame_mm = *required.frame_mm;
  numbers.series_cells = *required.series;
  numbers.propeller_in = *required.propeller_in;
  if (numbers.name.empty()) numbers.name = std::filesystem::path(output).stem().string();
  numbers.esc = ControllerOf(esc);
  if (line.Given("no-load-V") && !numbers.no_load_A) {
    throw OptionError(
        "option --no-load-V: it is the voltage at which --no-load-A was measured, and there is none; "
        "give both, or leave it out");
  }
  if (!inertia.empty()) {
    if (inertia.size() != 3) throw OptionError("option --inertia-kg-m2: expected three moments");
    auto& moments = numbers.inertia_kg_m2.emplace();
    for (std::size_t k = 0; k < 3; ++k) {
      options_internal::FromText("--inertia-kg-m2", inertia[k], Range{1e-12, 1e6}, moments[k]);
    }
  }
  std::optional<BenchFit> fit;
  std::vector<std::string> remarks;
  const auto leave_out = [&](const std::vector<const char*>& names, std::string_view beside) {
    for (const char* name : names) {
      if (line.Given(name))
        throw OptionError(fmt::format(
            "option --{}: {} what the propeller does; leave one of the two out", name, beside));
    }
  };
  if (numbers.thrust_coefficient && numbers.power_coefficient)
    leave_out({"pitch-in", "blades"}, "--thrust-coefficient and --power-coefficient say");
  if (!bench_file.empty()) {
    leave_out({"pitch-in", "blades", "thrust-coefficient", "power-coefficient"},
              "--bench-table says");
    numbers.bench_name = std::filesystem::path(bench_file).filename().string();
    BenchGiven given;
    if (numbers.kv_rpm_per_V) {
      given.motor_constant_N_m_per_A = 60.0 / (2.0 * std::numbers::pi * *numbers.kv_rpm_per_V);
    }
    if (numbers.no_load_A) given.no_load_A_per_V = NoLoadConductance(numbers);
    given.switching = esc.pwm_kHz > 0.0 && esc.switching_ns == 0.0;
    const BenchTable table = ReadBenchTable(bench_file);
    remarks = table.remarks;
    fit = FitBenchTable(table, given);
  }
  const VehicleDraft draft = BuildVehicle(numbers, fit);
  const std::string text = VehicleToToml(draft.vehicle, draft.sources);
  try {  // what no command reads is not written
    (void)ParseVehicle(text, output);
  } catch (const LoadError& error) {
    throw OptionError(
        fmt::format("these numbers make no vehicle: {}", error.diagnostics().front().message));
  }
  WriteFileAtomically(output, text);
  Report(line, draft, fit);
  line.summary()["remarks"] = remarks;
  line.summary()["output"] = output;
  line.Message(
      "{}: {} of {:.4g} kg; assumed: {}",
      output,
      draft.vehicle.name,
      draft.vehicle.mass_kg,
      draft.assumed.empty() ? "nothing" : fmt::format("{}", fmt::join(draft.assumed, ", ")));
  for (const std::string& remark : remarks) line.Message("{}", remark);
  for (const std::string& caution : draft.cautions) line.Message("caution: {}", caution);
  if (fit && !fit->converged) {
    line.Message("the fit to {} did not converge: {}", bench_file, fit->message);
    return cli::ExitCode::kIncomplete;
  }
  return cli::ExitCode::kDone;
}

}  // namespace lipoid
