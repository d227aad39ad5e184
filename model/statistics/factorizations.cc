#include "model/statistics/factorizations.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <unsupported/Eigen/Polynomials>

namespace lipoid {

SymmetricEigen EigenOfSymmetric(const Eigen::MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::MatrixXd TriangularFactor(const Eigen::MatrixXd& rows) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(rows);
  return qr.matrixQR().topRows(std::min(rows.rows(), rows.cols())).triangularView<Eigen::Upper>();
}

Eigen::MatrixXd OrthogonalBasis(const Eigen::MatrixXd& columns) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(columns);
  return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), columns.rows());
}

Eigen::MatrixXd InverseOfPositive(const Eigen::MatrixXd& matrix) {
  return SolvePositive(matrix, Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols()).eval());
}

Eigen::MatrixXd SolvePositive(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& right) {
  // Eigen looks at the first entry of what it solves for, which is none where nothing is asked.
  if (right.size() == 0) return right;
  return matrix.llt().solve(right);
}

Eigen::VectorXd SolvePositive(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  return matrix.llt().solve(right);
}

Eigen::VectorXd LeastSquares(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  return matrix.colPivHouseholderQr().solve(right);
}

Eigen::VectorXd ShortestLeastSquares(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  return matrix.completeOrthogonalDecomposition().solve(right);
}

std::optional<Eigen::MatrixXd> Inverse(const Eigen::MatrixXd& matrix) {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factor(matrix);
  if (!factor.isInvertible()) return std::nullopt;
  return factor.inverse();
}

Eigen::MatrixXd PseudoInverse(const Eigen::MatrixXd& matrix) {
  return matrix.completeOrthogonalDecomposition().pseudoInverse();
}

std::optional<GeneralEigen> EigenOf(const Eigen::MatrixXd& matrix) {
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(matrix);
  if (solver.info() != Eigen::Success) return std::nullopt;
  return GeneralEigen{solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::VectorXcd EigenvaluesOf(const Eigen::MatrixXd& matrix) {
  return Eigen::EigenSolver<Eigen::MatrixXd>(matrix, /*computeEigenvectors=*/false).eigenvalues();
}

Eigen::VectorXcd RootsOf(const Eigen::VectorXd& coefficients) {
  return Eigen::PolynomialSolver<double, Eigen::Dynamic>(coefficients).roots();
}

}  // namespace lipoid
