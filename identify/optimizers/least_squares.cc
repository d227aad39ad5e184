#include "identify/optimizers/least_squares.h"

namespace lipoid {

double LeastSquaresProblem::Cost(const Eigen::VectorXd& x) const {
  return 0.5 * Factor(x, false).rightCols(1).squaredNorm();
}

double LeastSquaresProblem::Gradient(const Eigen::VectorXd& x, Eigen::VectorXd& gradient) const {
  const Eigen::MatrixXd factor = Factor(x, true);
  gradient = factor.leftCols(x.size()).transpose() * factor.rightCols(1);
  return 0.5 * factor.rightCols(1).squaredNorm();
}

}  // namespace lipoid
