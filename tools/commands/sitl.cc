// lipoid sitl: the plant as the physics behind an autopilot, ArduPilot's JSON interface.
#include <algorithm>
#include <chrono>
#include <ctime>
#include <nlohmann/json.hpp>

#include "identify/pack_request.h"
#include "model/battery/curve_range.h"
#include "model/core/errors.h"
#include "model/flight/ardupilot_json.h"
#include "model/flight/coupling.h"
#include "model/flight/trim.h"
#include "model/vehicle/vehicle_file.h"
#include "tools/cli/run.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"
#include "tools/commands/loaded_cell.h"
#include "tools/commands/udp_server.h"
#include "tools/commands/wind_option.h"

namespace lipoid {
namespace {

using cli::Align;

// Of so many starts of the autopilot each is told of; beyond, someone plays.
constexpr std::size_t kMostFlights = 1000;

// From one start of the autopilot to the next.
struct LiveFlight {
  LiveState last;
  LiveReport report;
};

Json ToJson(const LiveFlight& flight) {
  Json json = {{"simulated_s", flight.last.time_s},
               {"charge_C", flight.report.charge_C},
               {"minimum_voltage_V", flight.report.minimum_voltage_V},
               {"final_voltage_V", flight.last.battery_V},
               {"final_soc", flight.last.soc}};
  if (flight.report.takeoff_s) json["takeoff_s"] = *flight.report.takeoff_s;
  if (flight.report.cutoff_s) json["cutoff_s"] = *flight.report.cutoff_s;
  if (flight.report.empty_s) json["empty_s"] = *flight.report.empty_s;
  if (flight.report.over) json["over"] = *flight.report.over;
  return json;
}

// Says what happens to the battery when it happens, once a flight.
class BatteryNews {
 public:
  BatteryNews(cli::CommandLine& line, double cutoff_V) : line_(line), cutoff_V_(cutoff_V) {}

  void Look(const LiveReport& report) {
    if (report.cutoff_s && !cutoff_said_) {
      line_.Message("the battery reached its cut-off: below {} V for a second at {:.1f} s",
                    cutoff_V_,
                    *report.cutoff_s);
      cutoff_said_ = true;
    }
    if (report.empty_s && !empty_said_) {
      line_.Message("the battery is empty at {:.1f} s: the motors get nothing any more",
                    *report.empty_s);
      empty_said_ = true;
    }
  }
  void Forget() { cutoff_said_ = empty_said_ = false; }

 private:
  cli::CommandLine& line_;
  double cutoff_V_;
  bool cutoff_said_ = false;
  bool empty_said_ = false;
};

void PrintLive(cli::CommandLine& line,
               const ArduPilotPhysics::Counts& counts,
               const std::vector<LiveFlight>& flights,
               double simulated_s,
               double wall_s,
               double cpu_s) {
  cli::TextTable table({{"live", Align::kLeft}, {"value"}, {"unit", Align::kLeft}});
  const auto row = [&](std::string what, std::string value, std::string unit) {
    table.Row({std::move(what), std::move(value), std::move(unit)});
  };
  row("packets", fmt::format("{}", counts.packets), "");
  if (counts.malformed > 0) row("", fmt::format("{}", counts.malformed), "malformed, ignored");
  if (counts.repeated > 0) row("", fmt::format("{}", counts.repeated), "repeated, answered again");
  if (counts.missed > 0) row("", fmt::format("{}", counts.missed), "missed");
  if (counts.restarts > 0) row("", fmt::format("{}", counts.restarts), "restarts");
  row("flown", fmt::format("{:.3f}", simulated_s), "s");
  if (wall_s > 0.0) row("", fmt::format("{:.1f}", simulated_s / wall_s), "times real time");
  if (cpu_s > 0.0)
    row("", fmt::format("{:.1f}", simulated_s / cpu_s), "times real time by lipoid's work");
  const LiveFlight& last = flights.back();
  row("charge",
      fmt::format("{:.2f}", last.report.charge_C),
      fmt::format("C, {:.4g} Ah", last.report.charge_C / 3600.0));
  row("voltage", fmt::format("{:.4f}", last.last.battery_V), "V at the end");
  row("", fmt::format("{:.4f}", last.report.minimum_voltage_V), "V at the lowest");
  row("soc", fmt::format("{:.4f}", last.last.soc), "at the end");
  line.Print("{}", table.Text());
}

}  // namespace

cli::ExitCode SitlCommand(cli::CommandLine& line) {
  std::string cell_name = "gifi-600mAh-1";
  std::string vehicle_name = "mambo-coupled";
  std::string address = "127.0.0.1";
  WindOption wind;
  int port = kArduPilotPort;
  PackRequest pack;
  std::optional<double> duration_s;
  std::optional<int> packets;
  std::optional<double> idle_s;
  LiveSetup setup;
  StartRequest start;
  line.Describe(
      "Flies the vehicle and its battery as the physics behind an autopilot, through ArduPilot's "
      "JSON interface (UDP, in lock step): pulse widths in; inertial sensors, position, attitude, "
      "velocity, battery voltage and current out. The vehicle waits on the ground until its thrust "
      "exceeds its weight. Ends with an interrupt (Ctrl-C). Exit code 1 where the flight cannot be "
      "followed further.",
      "lipoid sitl --cell gifi-600mAh-1 --vehicle mambo-coupled");
  line.Example("sim_vehicle.py -v ArduCopter --model JSON:127.0.0.1   # in another terminal");
  line.Input("cell", cell_name, "CELL", "a cell file, or the name of a shipped cell");
  line.Each(pack);
  line.Input("vehicle",
             vehicle_name,
             "VEHICLE",
             "a vehicle file, or the name of a shipped vehicle; its motors turn as ArduCopter's "
             "quad X has them");
  line.Option(
      "port", port, Range{0, 65535}, "port to listen at; 0: any free one, which is printed");
  line.Text("address", address, "ADDRESS", "address to listen at; 0.0.0.0 lets other machines in");
  wind.AddTo(line, setup.wind, "to the north, east and down");
  line.Option("duration", duration_s, Range{1e-6, 1e9}, "end after so many simulated seconds");
  line.Option("packets", packets, Range{1, 2'000'000'000}, "end after so many packets");
  line.Option("idle-s", idle_s, Range{0.001, 1e6}, "end when no packet came for so many seconds");
  line.Each(start);
  if (!line.Parse()) return cli::ExitCode::kDone;

  setup.cell = LoadCell(line, cell_name);
  pack.ApplyTo(setup.cell);
  setup.initial_soc = start.Soc(setup.cell);
  setup.vehicle = ForArduCopter(LoadVehicle(vehicle_name));
  setup.seed = line.seed();
  wind.ReadInto(setup.wind);
  const auto plant = MakeLivePlant(setup);
  ArduPilotPhysics physics(*plant, Blows(setup.wind));
  UdpServer server(address, static_cast<std::uint16_t>(port));
  const cli::StopRequest interrupted([&server] { server.Stop(); });

  line.Message("{} on {} ({} in series, {} in parallel) waits for an autopilot at {} port {} (UDP)",
               setup.vehicle.name,
               setup.cell.name,
               setup.cell.series,
               setup.cell.parallel,
               address,
               server.port());
  if (!server.is_loopback()) {
    line.Message("anyone who reaches {} may fly it: the interface asks for no password", address);
  }
  BatterySupply full(setup.cell, setup.initial_soc);
  const Trim trim = HoverTrim(setup.vehicle, full);
  if (trim.possible()) {
    line.Message("it hovers at first with pulse widths of {:.0f} (duty {:.3f}) and {:.3f} A",
                 1000.0 + 1000.0 * trim.duty,
                 trim.duty,
                 trim.battery_A);
  } else {
    line.Message("it cannot hover on this battery: give another --cell, or more --series");
  }

  using Clock = std::chrono::steady_clock;
  std::vector<LiveFlight> flights;
  double earlier_s = 0.0;  // flown before the last start of the autopilot
  BatteryNews news(line, setup.cell.series * setup.cell.cutoff_V);
  physics.OnRestart([&] {
    earlier_s += plant->state().time_s;
    news.Forget();
    if (flights.size() >= kMostFlights) return;
    flights.push_back({plant->state(), plant->report()});
    line.Message(
        "the autopilot started anew after {:.1f} s: so does the flight, on a battery as at "
        "first",
        plant->state().time_s);
  });
  Clock::time_point first;
  Clock::time_point last;
  const std::clock_t cpu_before = std::clock();
  const auto ended = server.Run(
      [&](std::string_view datagram) -> UdpServer::Reply {
        last = Clock::now();
        if (physics.counts().packets == 0) first = last;
        const auto answer = physics.Answer(datagram);
        news.Look(plant->report());
        const bool enough = (packets && physics.counts().packets >= std::uint64_t(*packets)) ||
                            (duration_s && earlier_s + plant->state().time_s >= *duration_s - 1e-9);
        return {answer.value_or(std::string_view()), enough || plant->report().over.has_value()};
      },
      idle_s);
  const double cpu_s = double(std::clock() - cpu_before) / double(CLOCKS_PER_SEC);
  const double wall_s = std::chrono::duration<double>(last - first).count();
  flights.push_back({plant->state(), plant->report()});
  const double simulated_s = earlier_s + plant->state().time_s;
  const ArduPilotPhysics::Counts& counts = physics.counts();

  Json all = Json::array();
  for (const LiveFlight& flight : flights) all.push_back(ToJson(flight));
  const char* const reason = plant->report().over                  ? "over"
                             : ended == UdpServer::Ended::kIdle    ? "idle"
                             : ended == UdpServer::Ended::kStopped ? "interrupted"
                                                                   : "limit";
  line.summary() = {{"vehicle", setup.vehicle.name},
                    {"battery", setup.cell.name},
                    {"ended_by", reason},
                    {"packets", counts.packets},
                    {"malformed", counts.malformed},
                    {"frames", counts.frames},
                    {"repeated", counts.repeated},
                    {"missed", counts.missed},
                    {"restarts", counts.restarts},
                    {"simulated_s", simulated_s},
                    {"wall_s", wall_s},
                    {"cpu_s", cpu_s},
                    {"hover_A", trim.battery_A},
                    {"flights", std::move(all)}};
  PrintLive(line, counts, flights, simulated_s, wall_s, cpu_s);
  double lowest_soc = setup.initial_soc;
  for (const LiveFlight& flight : flights) lowest_soc = std::min(lowest_soc, flight.last.soc);
  if (const auto doubt = DoubtAboutCurve(setup.cell, lowest_soc, setup.initial_soc); !doubt.empty())
    line.Message("{}", doubt);
  if (plant->report().over) line.Message("{}", *plant->report().over);
  if (counts.frames == 0) line.Message("no autopilot was heard");
  return plant->report().over || counts.frames == 0 ? cli::ExitCode::kIncomplete
                                                    : cli::ExitCode::kDone;
}

}  // namespace lipoid
