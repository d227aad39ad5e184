#pragma once

/// @file
/// Independent standard normal numbers that are the same wherever they are drawn: the standard
/// library's normal_distribution is not, Boost's ziggurat is. Drawing does not allocate. Tests:
/// tests/model/statistics/normal_noise_test.cc.

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cstdint>
#include <random>

namespace lipoid {

class NormalNoise {
 public:
  /// One seed gives as many independent streams as are asked for by number.
  NormalNoise(std::uint64_t seed, std::uint32_t stream) {
    std::seed_seq sequence{
        static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32U), stream};
    engine_.seed(sequence);
  }

  double operator()() { return normal_(engine_); }

 private:
  boost::random::mt19937_64 engine_;
  boost::random::normal_distribution<double> normal_;
};

}  // namespace lipoid
