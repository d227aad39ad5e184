#pragma once

/// @file
/// Student's distribution: of an estimate less the truth, over its standard error, where the error
/// itself was estimated from so many degrees of freedom. Tests:
/// tests/model/statistics/student_test.cc.

namespace lipoid {

/// The value that is not passed with this probability, in (0, 1). degrees_of_freedom > 0.
[[nodiscard]] double StudentQuantile(double degrees_of_freedom, double probability);

/// How many standard errors an interval that holds the truth in 95 % of cases reaches either way.
[[nodiscard]] double Reach95(double degrees_of_freedom);

}  // namespace lipoid
