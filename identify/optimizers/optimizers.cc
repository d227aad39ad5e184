#include "identify/optimizers/optimizers.h"

#include "identify/optimizers/levenberg_marquardt.h"

namespace lipoid {

const std::vector<OptimizerEntry>& Optimizers() {
  static const std::vector<OptimizerEntry> table = {
      {"levenberg-marquardt",
       "Ceres",
       "damped Gauss-Newton steps with exact gradients and bounds; the default",
       &DescribeOptions<LevenbergMarquardtOptions>},
  };
  return table;
}

}  // namespace lipoid
