#pragma once

/// @file
/// Student's distribution: of an estimate less the truth, over its standard error, where the error
/// itself was estimated from so many degrees of freedom; and those of squares. By Boost, whose templates
/// are compiled here alone. Tests:
/// tests/model/statistics/quantiles_test.cc.

namespace lipoid {

/// The value that is not passed with this probability, in (0, 1). degrees_of_freedom > 0.
[[nodiscard]] double StudentQuantile(double degrees_of_freedom, double probability);

/// How many standard errors an interval that holds the truth in 95 % of cases reaches either way.
[[nodiscard]] double Reach95(double degrees_of_freedom);

/// What a sum of so many squares of normal numbers passes with this probability, in (0, 1).
[[nodiscard]] double ChiSquaredPassed(double degrees_of_freedom, double probability);

/// The same of Fisher's ratio: a mean of so many squares over one of others (`within`).
[[nodiscard]] double FisherPassed(double degrees_of_freedom, double within, double probability);

}  // namespace lipoid
