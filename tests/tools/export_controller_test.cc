// lipoid export-controller: the C that it writes is compiled here and flown by the simulator, beside
// the simulator's own controller. Without a C compiler (cc) these tests are skipped.
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "model/battery/cell_file.h"
#include "model/control/gains.h"
#include "model/control/laws/control_laws.h"
#include "model/flight/maneuvers/maneuvers.h"
#include "model/flight/simulator.h"
#include "model/vehicle/motor.h"
#include "model/vehicle/vehicle_file.h"
#include "tests/support/paths.h"
#include "tests/support/run_lipoid.h"

namespace lipoid::test {
namespace {

// The issue's bound. The code does the same operations in the same order, so that the difference is
// zero where compiler and libm are those of lipoid; one rounding anywhere would move a pulse width
// by a whole step, and the flight by 1e-6.
constexpr double kDoubleAgrees = 1e-9;
// In float a rounding of 6e-8 is 1e-5 m and 1e-6 rad after 50 s where pulse widths are not rounded.
// Where they are, single ones come out a step of 490 apart, which the next steps make good by the
// remainder carried on: 0.9 mm and 0.8 mrad; and 2 mm with the estimator, whose position is
// integrated from readings (docs/flight-code.md). Allowed is about twice that.
constexpr double kFloatAgrees_m = 2e-5;
constexpr double kFloatAgreesRounded_m = 2e-3;
constexpr double kFloatAgreesEstimated_m = 5e-3;
constexpr double kFloatAgrees_rad = 1.5e-3;

const char* const kStrict =
    " -O2 -ffp-contract=off -Wall -Wextra -Wconversion -Wshadow -pedantic -Werror ";

bool HasProgram(const std::string& program) {
  return std::system((program + " --version >/dev/null 2>&1").c_str()) == 0;
}

#define LIPOID_SKIP_WITHOUT_PROGRAM(program) \
  if (!HasProgram(program)) GTEST_SKIP() << "skipped: there is no " << (program)

// Exports into a folder "code" of the test's.
void Export(const std::string& folder, std::vector<std::string> options) {
  options.insert(options.begin(), {"export-controller", "-o", "code", "--quiet"});
  const auto run = RunLipoid(folder, options);
  ASSERT_EQ(run.exit_code, 0) << run.err;
}

// Exported code as a library, loaded.
class Loaded : public FlightCode {
 public:
  // `compiler`: the command and its language.
  Loaded(const std::string& folder, const std::string& compiler, const std::string& name) {
    const std::string library = folder + "/" + name + ".so";
    const auto run =
        RunShell(folder,
                 compiler + kStrict + "-fPIC -shared -Icode code/lipoid_controller.c '" +
                     SourcePath("tests/support/flight_code_shim.c") + "' -lm -o " + name + ".so");
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.err, "");
    handle_ = ::dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle_ == nullptr) {
      ADD_FAILURE() << ::dlerror();
      return;
    }
    Find("shim_bytes_of_real", bytes_);
    Find("shim_reset", reset_);
    Find("shim_step", step_);
    Find("shim_estimator_reset", estimator_reset_);
    Find("shim_estimator_calibrate", calibrate_);
    Find("shim_estimator_step", estimate_);
  }
  ~Loaded() override {
    if (handle_ != nullptr) ::dlclose(handle_);
  }

  [[nodiscard]] bool usable() const { return handle_ != nullptr; }
  [[nodiscard]] int BytesOfReal() const { return bytes_(); }

  void Reset(const MeasuredState& at_rest) override {
    EXPECT_EQ(reset_(Numbers(at_rest).data()), 0);
  }
  PerMotor<double> Step(const FlightCommand& command, const MeasuredState& state) override {
    code_ = StepInto(command, state, out_);
    return {out_[0], out_[1], out_[2], out_[3]};
  }
  void ResetEstimator(const MeasuredState& at_rest,
                      std::span<const SensorReadings> readings) override {
    estimator_reset_(Numbers(at_rest).data());
    for (const auto& reading : readings) calibrate_(Numbers(reading).data());
  }
  MeasuredState Estimate(const SensorReadings& readings) override {
    std::array<double, 13> x{};
    estimate_(Numbers(readings).data(), x.data());
    return {
        {x[0], x[1], x[2]}, {x[3], x[4], x[5]}, {x[6], x[7], x[8]}, {x[9], x[10], x[11]}, x[12]};
  }

  int StepInto(const FlightCommand& c, const MeasuredState& state, std::array<double, 9>& out) {
    const std::array<double, 7> command{c.altitude_m,
                                        c.yaw_rad,
                                        c.hold_position ? 1.0 : 0.0,
                                        c.x_m,
                                        c.y_m,
                                        c.roll_rad,
                                        c.pitch_rad};
    return step_(command.data(), Numbers(state).data(), out.data());
  }
  [[nodiscard]] const std::array<double, 9>& out() const { return out_; }
  [[nodiscard]] int code() const { return code_; }

 private:
  static std::array<double, 13> Numbers(const MeasuredState& s) {
    std::array<double, 13> x{};
    for (std::size_t k = 0; k < 3; ++k) {
      x[k] = s.position_m[k];
      x[3 + k] = s.velocity_m_per_s[k];
      x[6 + k] = s.angles_rad[k];
      x[9 + k] = s.body_rates_rad_per_s[k];
    }
    x[12] = s.battery_V;
    return x;
  }
  static std::array<double, 11> Numbers(const SensorReadings& r) {
    return {r.accelerometer_m_per_s2[0],
            r.accelerometer_m_per_s2[1],
            r.accelerometer_m_per_s2[2],
            r.gyro_rad_per_s[0],
            r.gyro_rad_per_s[1],
            r.gyro_rad_per_s[2],
            r.sonar_m,
            r.pressure_altitude_m,
            r.flow_m_per_s[0],
            r.flow_m_per_s[1],
            r.battery_V};
  }
  template <class Function>
  void Find(const char* name, Function& function) {
    function = reinterpret_cast<Function>(::dlsym(handle_, name));
    EXPECT_NE(function, nullptr) << name;
  }

  void* handle_ = nullptr;
  int (*bytes_)() = nullptr;
  int (*reset_)(const double*) = nullptr;
  int (*step_)(const double*, const double*, double*) = nullptr;
  void (*estimator_reset_)(const double*) = nullptr;
  void (*calibrate_)(const double*) = nullptr;
  void (*estimate_)(const double*, double*) = nullptr;
  std::array<double, 9> out_{};
  int code_ = 0;
};

struct Difference {
  double place_m = 0.0;
  double angle_rad = 0.0;
  double duty = 0.0;
  double estimate_m = 0.0;
};

// The same flight twice: by the simulator's controller, and by the code.
Difference Compare(FlightSetup setup, const FlightPlan& plan, FlightCode* code) {
  std::vector<FlightSample> own;
  const auto ours = Fly(setup, plan, [&](const FlightSample& s) { own.push_back(s); });
  EXPECT_EQ(ours.outcome, Outcome::kCompleted) << ours.reason;
  EXPECT_EQ(own.size(), std::size_t(std::llround(plan.duration_s / kControlStep_s)));
  Difference worst;
  std::size_t k = 0;
  setup.flight_code = code;
  const auto theirs = Fly(setup, plan, [&](const FlightSample& s) {
    const FlightSample& o = own.at(k++);
    for (std::size_t i = 0; i < 3; ++i) {
      worst.place_m = std::max(worst.place_m, std::abs(s.position_m[i] - o.position_m[i]));
      worst.angle_rad = std::max(worst.angle_rad, std::abs(s.angles_rad[i] - o.angles_rad[i]));
    }
    for (std::size_t i = 0; i < 4; ++i)
      worst.duty = std::max(worst.duty, std::abs(s.duty[i] - o.duty[i]));
    worst.estimate_m =
        std::max(worst.estimate_m, std::abs(s.altitude_estimate_m - o.altitude_estimate_m));
  });
  EXPECT_EQ(theirs.outcome, Outcome::kCompleted) << theirs.reason;
  EXPECT_EQ(k, own.size());
  return worst;
}

FlightSetup Coupled() {
  FlightSetup setup;
  setup.vehicle = LoadVehicle("mambo-coupled");
  setup.cell = LoadCell("gifi-600mAh-1");
  setup.gains = LoadGains("aware");
  return setup;
}

// One way to fly, as options of the command and as a setup.
struct Way {
  std::string name;
  std::vector<std::string> options;
  void (*change)(FlightSetup&);
  double float_agrees_m = kFloatAgreesRounded_m;
};

const std::vector<Way>& Ways() {
  static const std::vector<Way> kWays{
      {"default", {}, [](FlightSetup&) {}},
      {"compensated", {"--compensate"}, [](FlightSetup& s) { s.controller.compensate = true; }},
      {"pid", {"--controller", "pid"}, [](FlightSetup& s) { s.controller.law = "pid"; }},
      {"unaware of the physical vehicle",
       {"--vehicle", "mambo-physical", "--gains", "unaware"},
       [](FlightSetup& s) {
         s.vehicle = LoadVehicle("mambo-physical");
         s.gains = LoadGains("unaware");
       }},
      {"continuous pulse widths",
       {"--set", "controller.pwm=continuous"},
       [](FlightSetup& s) { s.controller.pwm = Pwm::kContinuous; },
       kFloatAgrees_m},
      {"references without bounds",
       {"--set", "controller.limit_reference=false", "--set", "controller.attitude_damping=1.2"},
       [](FlightSetup& s) {
         s.controller.limit_reference = false;
         s.controller.attitude_damping = 1.2;
       }},
      {"without saturation",
       {"--set", "controller.saturate=false", "--set", "controller.yaw_omega_rad_per_s=3"},
       [](FlightSetup& s) {
         s.controller.saturate = false;
         s.controller.yaw_omega_rad_per_s = 3.0;
       },
       kFloatAgrees_m},
      {"estimated",
       {"--set", "estimator.sonar_gate_m=0.25", "--set", "controller.attitude_omega_rad_per_s=48"},
       [](FlightSetup& s) {
         s.estimate = true;
         s.controller.attitude_omega_rad_per_s = 48.0;
         s.estimator.sonar_gate_m = 0.25;
         s.seed = 3;
       },
       kFloatAgreesEstimated_m},
  };
  return kWays;
}

TEST(ExportController, InDoubleItFliesAsTheSimulatorsOwn) {
  LIPOID_SKIP_WITHOUT_PROGRAM("cc");
  for (const Way& way : Ways()) {
    SCOPED_TRACE(way.name);
    const auto folder = TestFolder();
    auto options = way.options;
    options.insert(options.end(), {"--precision", "double"});
    Export(folder, options);
    Loaded code(folder, "cc -std=c99", "controller");
    ASSERT_TRUE(code.usable());
    EXPECT_EQ(code.BytesOfReal(), 8);
    FlightSetup setup = Coupled();
    way.change(setup);
    std::vector<FlightPlan> plans{FindManeuver("altitude-steps").plan({}),
                                  FindManeuver("square").plan({})};
    // A turn that takes all the torque that yaw has.
    plans.push_back(
        {.commands = {{0.0, {.altitude_m = 1.1}}, {5.0, {.altitude_m = 1.1, .yaw_rad = 3.0}}},
         .duration_s = 30.0});
    for (std::size_t k = 0; k < plans.size(); ++k) {
      SCOPED_TRACE(k);
      const FlightPlan& plan = plans[k];
      const Difference worst = Compare(setup, plan, &code);
      EXPECT_LE(worst.place_m, kDoubleAgrees);
      EXPECT_LE(worst.angle_rad, kDoubleAgrees);
      EXPECT_LE(worst.duty, kDoubleAgrees);
      EXPECT_LE(worst.estimate_m, kDoubleAgrees);
    }
  }
}

TEST(ExportController, InFloatItStaysWithinTheStatedDistance) {
  LIPOID_SKIP_WITHOUT_PROGRAM("cc");
  for (const Way& way : Ways()) {
    SCOPED_TRACE(way.name);
    const auto folder = TestFolder();
    Export(folder, way.options);
    Loaded code(folder, "cc -std=c99", "controller");
    ASSERT_TRUE(code.usable());
    EXPECT_EQ(code.BytesOfReal(), 4);
    FlightSetup setup = Coupled();
    way.change(setup);
    for (const char* const maneuver : {"altitude-steps", "square"}) {
      SCOPED_TRACE(maneuver);
      const Difference worst = Compare(setup, FindManeuver(maneuver).plan({}), &code);
      std::printf("float, %s, %s: %.2g m, %.2g rad, duty %.2g\n",
                  way.name.c_str(),
                  maneuver,
                  worst.place_m,
                  worst.angle_rad,
                  worst.duty);
      EXPECT_LE(worst.place_m, way.float_agrees_m);
      EXPECT_LE(worst.angle_rad, kFloatAgrees_rad);
      EXPECT_GT(worst.place_m, 1e-12);  // it is flown, and it is float
    }
  }
}

TEST(ExportController, MotorsThatTurnTheOtherWayAreANumberOfTheVehicle) {
  LIPOID_SKIP_WITHOUT_PROGRAM("cc");
  const auto folder = TestFolder();
  const std::string file = folder + "/other.toml";
  std::ofstream(file) << "front_right_turns = \"counter-clockwise\"\n"
                      << ReadTextFile(SourcePath("fixtures/vehicles/mambo-coupled.toml"));
  Export(folder, {"--precision", "double", "--vehicle", "other.toml"});
  Loaded code(folder, "cc -std=c99", "controller");
  ASSERT_TRUE(code.usable());
  FlightSetup setup = Coupled();
  setup.vehicle = LoadVehicle(file);
  FlightPlan plan = FindManeuver("altitude-steps").plan({});
  for (auto& [time_s, command] : plan.commands) command.yaw_rad = 0.02 * time_s;
  const Difference worst = Compare(setup, plan, &code);
  EXPECT_LE(worst.place_m, kDoubleAgrees);
  EXPECT_LE(worst.angle_rad, kDoubleAgrees);
  EXPECT_NE(ReadTextFile(folder + "/code/lipoid_numbers.h")
                .find("Front right and back left turn counter-clockwise"),
            std::string::npos);
}

// The comparison would see another controller.
TEST(ExportController, TheComparisonSeesAnotherController) {
  LIPOID_SKIP_WITHOUT_PROGRAM("cc");
  const auto folder = TestFolder();
  Export(folder, {"--precision", "double", "--controller", "pid"});
  Loaded code(folder, "cc -std=c99", "controller");
  ASSERT_TRUE(code.usable());
  EXPECT_GT(Compare(Coupled(), FindManeuver("square").plan({}), &code).angle_rad, 1e-4);
}

// Each language and precision, by each compiler that is there, without a warning; in double the
// compiled C++ gives the same bits.
TEST(ExportController, CompilesWithoutAWarningAsCAndCxx) {
  LIPOID_SKIP_WITHOUT_PROGRAM("cc");
  const auto folder = TestFolder();
  Export(folder, {"--compensate"});
  const auto plan = FindManeuver("altitude-steps").plan({});
  FlightSetup setup = Coupled();
  setup.controller.compensate = true;
  int compilers = 0;
  for (const std::string compiler : {"cc", "gcc", "clang", "clang-14"}) {
    if (!HasProgram(compiler)) continue;
    ++compilers;
    for (const std::string language : {"-std=c99 -x c", "-std=c++11 -x c++", "-std=c++20 -x c++"}) {
      for (const std::string precision : {"0", "1"}) {
        SCOPED_TRACE(compiler + " " + language + " double: " + precision);
        const std::string command = compiler + " " + language + " -DLIPOID_DOUBLE=" + precision;
        const auto example = RunShell(
            folder,
            command + kStrict + "-Wdouble-promotion -c code/lipoid_controller.c -o a.o && " +
                command + kStrict + "-c code/lipoid_example.c -o b.o");
        EXPECT_EQ(example.exit_code, 0) << example.err;
        EXPECT_EQ(example.err, "");
        Loaded code(folder,
                    command,
                    "library" + std::to_string(compilers) +
                        (language.find("c++") == std::string::npos ? "c" : "cxx") + precision);
        ASSERT_TRUE(code.usable());
        const auto worst = Compare(setup, plan, &code);
        EXPECT_LE(worst.place_m, precision == "1" ? kDoubleAgrees : kFloatAgreesRounded_m);
      }
    }
  }
  EXPECT_GE(compilers, 1);
}

// Trim by other code: model/flight/trim.h.
TEST(ExportController, TheExampleHovers) {
  LIPOID_SKIP_WITHOUT_PROGRAM("cc");
  const auto folder = TestFolder();
  Export(folder, {"--gains", "aware"});
  const auto built =
      RunShell(folder + "/code",
               std::string("cc -std=c99") + kStrict +
                   "lipoid_example.c lipoid_controller.c -lm -o example && ./example");
  ASSERT_EQ(built.exit_code, 0) << built.err;
  const Vehicle vehicle = LoadVehicle("mambo-coupled");
  const double duty = HoverTrim(vehicle, Supply<double>{vehicle.nominal_voltage_V, 0.0}).duty;
  double found[4];
  ASSERT_EQ(std::sscanf(built.out.c_str(),
                        "step 0: duty %lf %lf %lf %lf,",
                        &found[0],
                        &found[1],
                        &found[2],
                        &found[3]),
            4)
      << built.out;
  // Noise of the example's sensors is a few steps of the pulse width.
  for (const double one : found) EXPECT_NEAR(one, duty, 0.02);
  const auto timed = RunShell(folder + "/code", "./example 2000");
  EXPECT_NE(timed.out.find("2000 steps, "), std::string::npos) << timed.out;
  EXPECT_NE(timed.out.find("memory: controller "), std::string::npos) << timed.out;
}

TEST(ExportController, SanitizersFindNothing) {
  LIPOID_SKIP_WITHOUT_PROGRAM("cc");
  for (const std::string options : {"", "--controller pid --set controller.pwm=continuous"}) {
    for (const std::string precision : {"0", "1"}) {
      const auto folder = TestFolder();
      const auto exported =
          RunShell(folder, "\"$LIPOID\" export-controller " + options + " -o code --quiet");
      ASSERT_EQ(exported.exit_code, 0) << exported.err;
      const auto run =
          RunShell(folder + "/code",
                   "cc -std=c99 -g -O1 -fsanitize=address,undefined -fno-sanitize-recover=all "
                   "-fsanitize=float-cast-overflow,float-divide-by-zero -DLIPOID_DOUBLE=" +
                       precision +
                       " lipoid_example.c lipoid_controller.c -lm -o example && ./example 100000");
      EXPECT_EQ(run.exit_code, 0) << run.err;
      EXPECT_EQ(run.err, "");
    }
  }
}

TEST(ExportController, WhatIsNoNumberKeepsTheLastOutputAndIsForgotten) {
  LIPOID_SKIP_WITHOUT_PROGRAM("cc");
  const auto folder = TestFolder();
  Export(folder, {"--precision", "double"});
  Loaded code(folder, "cc -std=c99", "controller");
  Loaded twin(folder, "cc -std=c99", "twin");
  ASSERT_TRUE(code.usable() && twin.usable());
  const MeasuredState rest{.battery_V = 4.0};
  code.Reset(rest);
  twin.Reset(rest);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::array<double, 9> out{};
  MeasuredState bad = rest;
  bad.angles_rad[1] = nan;
  EXPECT_EQ(code.StepInto({}, bad, out), 1);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(out[k], 0.0);       // motors off before the first good step
    EXPECT_EQ(out[4 + k], 10.0);  // the lowest pulse width
  }
  FlightCommand up{.altitude_m = 0.5, .yaw_rad = 0.1};
  for (int k = 0; k < 20; ++k) EXPECT_EQ(code.Step(up, rest), twin.Step(up, rest));
  const auto before = code.out();
  for (std::size_t k = 0; k < 13; ++k) {
    for (const double value : {nan, std::numeric_limits<double>::infinity()}) {
      bad = rest;
      double* const all[] = {bad.position_m.data(),
                             bad.velocity_m_per_s.data(),
                             bad.angles_rad.data(),
                             bad.body_rates_rad_per_s.data(),
                             &bad.battery_V};
      all[k / 3][k % 3] = value;
      EXPECT_EQ(code.StepInto(up, bad, out), 1) << k;
      EXPECT_EQ(out, before) << k;
    }
  }
  FlightCommand none = up;
  none.x_m = nan;
  EXPECT_EQ(code.StepInto(none, rest, out), 1);
  none.hold_position = false;  // then x is not asked for
  EXPECT_EQ(code.Step(up, rest), twin.Step(up, rest));
  EXPECT_EQ(code.code(), 0);
}

// A Cortex-M4 computes floats only: a double would be emulated.
TEST(ExportController, FitsACortexM4AndNeedsNoDouble) {
  LIPOID_SKIP_WITHOUT_PROGRAM("arm-none-eabi-gcc");
  const auto folder = TestFolder();
  Export(folder, {"--compensate"});
  std::ofstream(folder + "/code/m4.c")
      << "#include \"lipoid_controller.h\"\n"
         "lipoid_controller controller; lipoid_estimator estimator;\n"
         "lipoid_readings readings; lipoid_command command; lipoid_state state;\n"
         "lipoid_output output;\n"
         "int main(void) {\n"
         "  lipoid_estimator_reset(&estimator, &state);\n"
         "  lipoid_estimator_calibrate(&estimator, &readings);\n"
         "  lipoid_controller_reset(&controller, &state);\n"
         "  for (;;) {\n"
         "    lipoid_estimator_step(&estimator, &readings, &state);\n"
         "    lipoid_controller_step(&controller, &command, &state, &output);\n"
         "  }\n"
         "}\n";
  const std::string arm =
      "arm-none-eabi-gcc -mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16 -std=c99 -Os "
      "-Wall -Wextra -Wconversion -Wdouble-promotion -pedantic -Werror -ffunction-sections "
      "-fdata-sections ";
  const auto built =
      RunShell(folder + "/code",
               arm + "-c lipoid_controller.c && arm-none-eabi-size lipoid_controller.o && " + arm +
                   "-nostartfiles -Wl,--gc-sections -Wl,-e,main m4.c lipoid_controller.c -lm "
                   "--specs=nosys.specs -o m4.elf && arm-none-eabi-size m4.elf && "
                   "arm-none-eabi-nm m4.elf");
  ASSERT_EQ(built.exit_code, 0) << built.err;
  EXPECT_EQ(built.err, "");
  EXPECT_EQ(built.out.find("__aeabi_d"), std::string::npos) << built.out;
  EXPECT_EQ(built.out.find("__aeabi_f2d"), std::string::npos) << built.out;
  EXPECT_EQ(built.out.find("malloc"), std::string::npos) << built.out;
  long text = 0;
  long data = 0;
  long bss = 0;
  const std::string kHead = "filename\n";
  auto at = built.out.find(kHead);
  ASSERT_NE(at, std::string::npos) << built.out;
  ASSERT_EQ(std::sscanf(built.out.c_str() + at + kHead.size(), "%ld %ld %ld", &text, &data, &bss),
            3);
  std::printf("Cortex-M4: %ld bytes of code", text);
  EXPECT_LT(text, 8 * 1024);
  EXPECT_EQ(data + bss, 0);  // no state of its own
  at = built.out.find(kHead, at + 1);
  ASSERT_NE(at, std::string::npos) << built.out;
  ASSERT_EQ(std::sscanf(built.out.c_str() + at + kHead.size(), "%ld %ld %ld", &text, &data, &bss),
            3);
  std::printf(", %ld with libm, %ld of RAM\n", text, data + bss);
  EXPECT_LT(text, 16 * 1024);
  EXPECT_LT(data + bss, 2048);  // 1.1 kB of it is newlib's own
}

TEST(ExportController, RefusesWhatItCannotExportAndWritesNothing) {
  const auto folder = TestFolder();
  const auto refused = [&](std::vector<std::string> options, const std::string& message, int code) {
    options.insert(options.begin(), {"export-controller", "-o", "code"});
    const auto run = RunLipoid(folder, options);
    EXPECT_EQ(run.exit_code, code) << run.err;
    EXPECT_NE(run.err.find(message), std::string::npos) << run.err;
    EXPECT_FALSE(std::filesystem::exists(folder + "/code"));
  };
  refused({"--controller", "pd"}, "'pd'", 2);
  refused({"--lowest-V", "3", "--cell", "gifi-600mAh-1"},
          "options --lowest-V and --cell: give one of them",
          2);
  refused({"--lowest-V", "nan"}, "--lowest-V", 2);
  refused({"--lowest-V", "500"}, "expected at most the 4.2 V of mambo-", 2);
  refused({"--gains", "none.json"}, "none.json", 3);
  refused({"--set", "controller.pwm=none"}, "option pwm: expected one of", 2);
  std::string vehicle = ReadTextFile(SourcePath("fixtures/vehicles/mambo-coupled.toml"));
  const std::string drag = "torque_coefficient_N_m_s2 = 9.6223e-11";
  ASSERT_NE(vehicle.find(drag), std::string::npos);
  vehicle.replace(vehicle.find(drag), drag.size(), "torque_coefficient_N_m_s2 = 9.6223e-41");
  std::ofstream(folder + "/small.toml") << vehicle;
  refused({"--vehicle", "small.toml"},
          "torque_coefficient_N_m_s2: expected a torque per square of rad/s from 1e-16 to 1 N m s²",
          3);
}

// Gains of zero hold nothing, and at 1 V no Mambo hovers: the code is written, and this is said first.
TEST(ExportController, SaysWhatIsNotToBeFlown) {
  const auto folder = TestFolder();
  Gains none = LoadGains("aware");
  none.altitude = none.attitude = none.yaw = {};
  std::ofstream(folder + "/none.json") << GainsToJson(none).dump();
  const auto loose = RunLipoid(folder, {"export-controller", "--gains", "none.json", "-o", "code"});
  EXPECT_EQ(loose.exit_code, 1) << loose.err;
  EXPECT_EQ(loose.err.find("the altitude loop is unstable at xi = "), 0U) << loose.err;
  EXPECT_NE(loose.err.find("this controller is not to be flown"), std::string::npos) << loose.err;
  const auto low = RunLipoid(
      folder, {"export-controller", "--lowest-V", "1", "-o", "low", "--summary", "s.json"});
  EXPECT_EQ(low.exit_code, 0) << low.err;
  EXPECT_NE(low.err.find("\nmambo-coupled cannot hover at 1 V, "), std::string::npos) << low.err;
  EXPECT_EQ(ReadJson(folder, "s.json").at("loops").size(), 4U);  // at take-off alone
}

// A vehicle of four cells in series does not end its flight at the cut-off of one.
TEST(ExportController, TakesThePackThatTheVehicleIsMadeFor) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"export-controller",
                              "--vehicle",
                              "f450",
                              "--cell",
                              "grepow-32Ah-1",
                              "-o",
                              "code",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(ReadJson(folder, "s.json").at("lowest_V"), 4 * 3.0);
  EXPECT_NE(run.err.find("4 cells in series, for which f450 is made"), std::string::npos)
      << run.err;
}

TEST(ExportController, NamesFromFilesEndNoComment) {
  LIPOID_SKIP_WITHOUT_PROGRAM("cc");
  const auto folder = TestFolder();
  std::string vehicle = ReadTextFile(SourcePath("fixtures/vehicles/mambo-coupled.toml"));
  vehicle.replace(0, vehicle.find('\n'), R"(name = "*/ #error hostile\n int main(){} /* ?\\ ??/")");
  std::ofstream(folder + "/hostile.toml") << vehicle;
  std::filesystem::rename(folder + "/hostile.toml", folder + "/a*b .toml");
  Export(folder, {"--vehicle", "a*b .toml"});
  const auto run = RunShell(folder + "/code",
                            std::string("cc -std=c99") + kStrict + "-c lipoid_controller.c -o a.o");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
}

TEST(ExportController, SaysWhatItWrote) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder, {"export-controller", "-o", "code", "--summary", "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(
      FilesIn(folder + "/code"),
      (std::vector<std::string>{
          "lipoid_controller.c", "lipoid_controller.h", "lipoid_example.c", "lipoid_numbers.h"}));
  const auto summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary.at("files").size(), 4U);
  EXPECT_EQ(summary.at("vehicle"), "mambo-coupled");
  EXPECT_EQ(summary.at("gains"), "aware");
  EXPECT_EQ(summary.at("controller"), "inversion");
  EXPECT_EQ(summary.at("precision"), "float");
  EXPECT_EQ(summary.at("lowest_V"), 3.0);
  // The code flies by the references that were exported, unless its estimator asks for slower ones.
  const auto& references = summary.at("references");
  EXPECT_EQ(references.at("attitude_rad_per_s"), 100.0);
  EXPECT_EQ(references.at("slower_by_estimator"), true);
  // 1/(tau + half a control step of 5 ms) with tau of the motors' speed equation about hover,
  // J w' = -(k_e²/r_a + b + 2 k_N w) w, by the numbers of the vehicle file.
  const Vehicle v = LoadVehicle("mambo-coupled");
  const double speed = std::sqrt(v.mass_kg * 9.81 / 4.0 / v.thrust_coefficient_N_s2);
  const double lag_s =
      v.rotor_inertia_kg_m2 /
      (v.motor_constant_N_m_per_A * v.motor_constant_N_m_per_A / v.armature_resistance_Ohm +
       v.friction_N_m_s + 2.0 * v.torque_coefficient_N_m_s2 * speed);
  constexpr double kGravity = 1e-3;  // 9.81 or 9.80665 m/s²
  const double expected = 1.0 / (lag_s + 0.0025);
  EXPECT_NEAR(references.at("attitude_by_estimator_rad_per_s").get<double>(),
              expected,
              kGravity * expected);
  const auto numbers = ReadTextFile(folder + "/code/lipoid_numbers.h");
  for (const char* const part : {"Vehicle: mambo-coupled.",
                                 "Gains aware, shipped with lipoid.",
                                 "#define LIPOID_MASS_KG 0.063 /* kg */",
                                 "#define LIPOID_DOUBLE 0"}) {
    EXPECT_NE(numbers.find(part), std::string::npos) << part;
  }
}

}  // namespace
}  // namespace lipoid::test
