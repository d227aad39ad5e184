#pragma once

/// @file
/// Factorizations of dense matrices of any size, by Eigen. Its templates are compiled once, here: where
/// everyone instantiated them they were a third of what a build takes.
/// Tests: tests/model/statistics/factorizations_test.cc.

#include <Eigen/Core>
#include <optional>

namespace lipoid {

/// matrix = vectors diag(values) vectors'.
struct SymmetricEigen {
  Eigen::VectorXd values;   ///< increasing
  Eigen::MatrixXd vectors;  ///< n x n, orthonormal columns
};

/// Of a symmetric matrix, of which the lower triangle is read. Numbers that are not finite give such.
[[nodiscard]] SymmetricEigen EigenOfSymmetric(const Eigen::MatrixXd& matrix);

/// R of rows = Q R, upper triangular, min(rows, columns) x columns: R'R = rows' rows.
[[nodiscard]] Eigen::MatrixXd TriangularFactor(const Eigen::MatrixXd& rows);

/// Q of columns = Q R, n x n: its first columns span those given, the others what is orthogonal to them.
[[nodiscard]] Eigen::MatrixXd OrthogonalBasis(const Eigen::MatrixXd& columns);

/// Of a symmetric positive definite matrix, by Cholesky: its inverse, and the x of matrix x = right. Only
/// the lower triangle is read; that of a matrix which is not positive definite is nonsense.
[[nodiscard]] Eigen::MatrixXd InverseOfPositive(const Eigen::MatrixXd& matrix);
[[nodiscard]] Eigen::MatrixXd SolvePositive(const Eigen::MatrixXd& matrix,
                                            const Eigen::MatrixXd& right);
[[nodiscard]] Eigen::VectorXd SolvePositive(const Eigen::MatrixXd& matrix,
                                            const Eigen::VectorXd& right);

/// The x for which |matrix x - right| is least, matrix of full column rank; or of these, where there are
/// many, the shortest.
[[nodiscard]] Eigen::VectorXd LeastSquares(const Eigen::MatrixXd& matrix,
                                           const Eigen::VectorXd& right);
[[nodiscard]] Eigen::VectorXd ShortestLeastSquares(const Eigen::MatrixXd& matrix,
                                                   const Eigen::VectorXd& right);

/// The inverse of a square matrix, none where it is singular to rounding; and of any the pseudoinverse.
[[nodiscard]] std::optional<Eigen::MatrixXd> Inverse(const Eigen::MatrixXd& matrix);
[[nodiscard]] Eigen::MatrixXd PseudoInverse(const Eigen::MatrixXd& matrix);

/// Of a square matrix, in no order; n x n vectors of length 1, those of real eigenvalues real.
struct GeneralEigen {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors;
};
[[nodiscard]] std::optional<GeneralEigen> EigenOf(const Eigen::MatrixXd& matrix);
[[nodiscard]] Eigen::VectorXcd EigenvaluesOf(const Eigen::MatrixXd& matrix);

/// Of a polynomial, its coefficients by rising powers, the last not 0: degree >= 1.
[[nodiscard]] Eigen::VectorXcd RootsOf(const Eigen::VectorXd& coefficients);

}  // namespace lipoid
