#pragma once

/// @file
/// identify() and validate() for Python, and the keywords of every function that finds parameters by
/// stages.

#include <nanobind/nanobind.h>

#include <optional>
#include <string>

#include "identify/identification.h"
#include "python/src/keywords.h"

namespace lipoid::python {

/// alpha_C, open_circuit_voltage, branches, no_diffusion, fix, start, bounds, and the groups of the
/// stages: as tools/commands/staged_arguments.h has them.
void DeclareStages(Keywords& keywords,
                   StagedOptions& options,
                   StagedGiven& given,
                   std::optional<int>& branches);

void AddIdentification(nb::module_& module);

}  // namespace lipoid::python
