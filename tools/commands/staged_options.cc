#include "tools/commands/staged_options.h"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <string_view>

#include "model/core/errors.h"

namespace lipoid {
namespace {

[[noreturn]] void Refuse(std::string_view option, std::string_view set) {
  throw OptionError(
      fmt::format("options {} and --set {} contradict each other; leave one out", option, set));
}

void CheckBranches(const cli::CommandLine& line,
                   std::optional<int> branches,
                   std::string_view group,
                   int set) {
  const std::string name = fmt::format("{}.branches=", group);
  if (branches && line.Sets(name) && set != *branches)
    Refuse(fmt::format("--branches {}", *branches), fmt::format("{}{}", name, set));
}

}  // namespace

void CheckSaidOnce(const cli::CommandLine& line, const StagedRequest& request) {
  const PulseFitOptions& pulses = request.options.pulses;
  CheckBranches(line, request.branches, "pulses", pulses.branches);
  if (request.no_diffusion && line.Sets("pulses.diffusion=") && pulses.diffusion)
    Refuse("--no-diffusion", "pulses.diffusion=true");
}

void CheckSaidOnce(const cli::CommandLine& line, const IdentifyRequest& request) {
  CheckSaidOnce(line, request.staged);
  if (request.method == IdentifyMethod::kJoint)
    CheckBranches(line, request.staged.branches, "joint", request.joint.branches);
}

}  // namespace lipoid
