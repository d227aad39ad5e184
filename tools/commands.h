#pragma once

/// @file
/// The only list of commands. Help, dispatch and messages are made from it. To add one: a file in
/// tools/commands/, a declaration and a row here.

#include <algorithm>

#include "tools/cli/command_line.h"

namespace lipoid {

cli::ExitCode AgeingCommand(cli::CommandLine& line);
cli::ExitCode CompareCommand(cli::CommandLine& line);
cli::ExitCode ConvertCommand(cli::CommandLine& line);
cli::ExitCode DesignCommand(cli::CommandLine& line);
cli::ExitCode EnduranceCommand(cli::CommandLine& line);
cli::ExitCode ExportCommand(cli::CommandLine& line);
cli::ExitCode ExportControllerCommand(cli::CommandLine& line);
cli::ExitCode FlyCommand(cli::CommandLine& line);
cli::ExitCode HealthCommand(cli::CommandLine& line);
cli::ExitCode IdentifyCommand(cli::CommandLine& line);
cli::ExitCode ImportCommand(cli::CommandLine& line);
cli::ExitCode InspectCommand(cli::CommandLine& line);
cli::ExitCode ListCommand(cli::CommandLine& line);
cli::ExitCode PlanCommand(cli::CommandLine& line);
cli::ExitCode PolesCommand(cli::CommandLine& line);
cli::ExitCode ReportCommand(cli::CommandLine& line);
cli::ExitCode ServeCommand(cli::CommandLine& line);
cli::ExitCode SimulateCommand(cli::CommandLine& line);
cli::ExitCode SitlCommand(cli::CommandLine& line);
cli::ExitCode StudyCommand(cli::CommandLine& line);
cli::ExitCode SynthesizeCommand(cli::CommandLine& line);
cli::ExitCode ValidateCommand(cli::CommandLine& line);
cli::ExitCode VehicleCommand(cli::CommandLine& line);

inline constexpr cli::Command kCommands[] = {
    {"ageing", "what changed between cells identified at several ages", &AgeingCommand},
    {"compare", "optimizers on the same problem, side by side", &CompareCommand},
    {"convert", "a log of any known format as plain CSV or Battery Data Format", &ConvertCommand},
    {"design", "controller gains by optimization", &DesignCommand},
    {"endurance", "how long a vehicle flies on a pack, with an interval", &EnduranceCommand},
    {"export", "a cell as the battery of another simulator, with a stated error", &ExportCommand},
    {"export-controller",
     "the flight controller as C, for a microcontroller",
     &ExportControllerCommand},
    {"fly", "a maneuver of a quadrotor on an identified cell", &FlyCommand},
    {"health", "how old a pack is, from logs of flights on it", &HealthCommand},
    {"identify", "from lab logs to a cell file", &IdentifyCommand},
    {"import", "the battery of another program as a cell file", &ImportCommand},
    {"inspect", "what is in logs; drafts a campaign from them", &InspectCommand},
    {"list", "what lipoid knows by name: cells, optimizers, ...", &ListCommand},
    {"plan", "what an experiment would tell, before the lab is booked", &PlanCommand},
    {"poles", "closed-loop poles as the voltage falls", &PolesCommand},
    {"report", "results that are there already as one page with plots", &ReportCommand},
    {"serve", "the same as a page for a browser on this machine", &ServeCommand},
    {"simulate", "the voltage of a cell under a recorded current", &SimulateCommand},
    {"sitl", "the physics behind an autopilot (ArduPilot's JSON interface)", &SitlCommand},
    {"study", "one stage done in several ways: branches, v_oc(A), diffusion modes", &StudyCommand},
    {"synthesize",
     "the lab's logs of a known cell, with the truth beside them",
     &SynthesizeCommand},
    {"validate", "prediction against measurement", &ValidateCommand},
    {"vehicle", "a vehicle file from what its builder knows", &VehicleCommand},
};
static_assert(std::is_sorted(std::begin(kCommands),
                             std::end(kCommands),
                             [](const auto& a, const auto& b) { return a.name < b.name; }));

}  // namespace lipoid
