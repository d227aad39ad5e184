#pragma once

/// @file
/// The only list of studies. Help and messages are made from it. To add one: a file in
/// identify/studies/ and a row here.

#include <algorithm>

#include "identify/studies/study.h"
#include "model/core/nearest_name.h"

namespace lipoid {

inline constexpr Study kStudies[] = {
    {"branches", "0 to 5 branches: time, errors, and how many are recommended", &StudyBranches},
    {"ocv", "forms of v_oc(A): errors in the fit and on held-out rows", &StudyOcv},
    {"terms", "diffusion modes, with and without the tail", &StudyTerms},
};
static_assert(std::is_sorted(std::begin(kStudies),
                             std::end(kStudies),
                             [](const auto& a, const auto& b) { return a.name < b.name; }));

/// OptionError that names the nearest where there is none of that name.
[[nodiscard]] inline const Study& FindStudy(std::string_view name) {
  return FindNamed("study", name, kStudies);
}

}  // namespace lipoid
