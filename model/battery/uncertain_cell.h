#pragma once

/// @file
/// A cell as a point among those that its identification could as well have meant: its parameters with
/// their covariance (Cell::Uncertainty) as vectors, and the cell that belongs to any vector.
///
/// Voltages are linear in resistances and in v_oc, so those are taken as they are, and so are time
/// constants. The charge that diffusion holds back goes with 1/beta², so this stands for beta: where beta is
/// hardly known, draws of beta or of its logarithm would hold back hundreds of times what the logs show.
///
/// In range are resistances, rho_h and M of at least 0, beta of at most 1, alpha, c_j, tau_j, tau_h,
/// i_0, gamma, C_th and R_th of at least a hundredth of the estimate, and v_oc that does not fall with A, except where the estimate falls. Tests: tests/model/battery/uncertain_cell_test.cc.

#include <Eigen/Core>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "model/battery/cell.h"

namespace lipoid {

struct CellParameterKind;

class UncertainCell {
 public:
  /// PreconditionError where the cell has no uncertainty, or one of parameters that it does not have.
  explicit UncertainCell(const Cell& cell);

  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  [[nodiscard]] double degrees_of_freedom() const { return freedom_; }
  [[nodiscard]] const Eigen::VectorXd& estimate() const { return estimate_; }
  [[nodiscard]] const Eigen::MatrixXd& covariance() const { return covariance_; }
  /// F with F F' = covariance: the principal axes of the parameters, each in the unit in which its variance is 1,
  /// by rising variance.
  [[nodiscard]] const Eigen::MatrixXd& factor() const { return factor_; }
  /// The variance of each column of F in those units.
  [[nodiscard]] const Eigen::VectorXd& variances() const { return variances_; }

  /// Takes a vector out of range to one in range that is near in the metric of the covariance, as the
  /// estimator itself stops at its bounds: a resistance that may not become negative takes its partners
  /// along, and their well-known sum stays. Parameters that are one number come first; the nodes of tables,
  /// of which some are out of range in nearly every draw, then move with those held, or alpha and beta would
  /// hardly vary. Whether it was out of range.
  bool MoveIntoRange(Eigen::VectorXd& x) const;

  /// The cell of a vector in range, without the run record and the uncertainty of the one it started from.
  [[nodiscard]] Cell At(const Eigen::VectorXd& x) const;

  /// The uncertainty of a cell At(x) whose covariance, in the coordinates of the vectors, is another.
  [[nodiscard]] Cell::Uncertainty WithCovariance(const Eigen::VectorXd& x,
                                                 const Eigen::MatrixXd& covariance) const;

 private:
  [[nodiscard]] const std::string& Name(Eigen::Index k) const {
    return names_[static_cast<std::size_t>(k)];
  }
  [[nodiscard]] const CellParameterKind* Kind(Eigen::Index k) const {
    return kinds_[static_cast<std::size_t>(k)];
  }
  void FindRange();
  void FindMoves();
  bool Move(Eigen::VectorXd& x, Eigen::Index first, Eigen::Index last) const;
  [[nodiscard]] double LeastRise(std::size_t node) const;
  void SetVoltages(Cell& cell, const Eigen::VectorXd& x) const;

  // A bound of the range: x[more] - x[less] >= least, where -1 stands for none.
  struct Bound {
    Eigen::Index more = -1;
    Eigen::Index less = -1;
    double least = 0.0;

    [[nodiscard]] double Of(const Eigen::VectorXd& x) const {
      return (more < 0 ? 0.0 : x[more]) - (less < 0 ? 0.0 : x[less]);
    }
  };

  Cell base_;
  std::vector<std::string> names_;
  std::vector<const CellParameterKind*> kinds_;  // of each
  double freedom_ = 0.0;
  bool soc_follows_alpha_ = false;
  Eigen::VectorXd estimate_;    // ln beta for beta
  Eigen::MatrixXd covariance_;  // of these
  Eigen::MatrixXd factor_;
  Eigen::VectorXd variances_;
  std::vector<Eigen::Index> node_;  // which parameter a node of v_oc is; -1: none
  std::vector<Bound> range_;        // first those of parameters that are one number
  Eigen::Index of_numbers_ = 0;     // how many they are
  Eigen::MatrixXd carried_;         // how all move with one unit of lambda of a bound
  Eigen::VectorXd variance_;        // of what each bound is for; 0: it does not vary
};

/// The columns of F of at least this variance, that of a single parameter being 1; the largest first.
[[nodiscard]] Eigen::MatrixXd PrincipalMoves(const UncertainCell& around, double least_variance);

/// The uncertainty of some of the parameters, whatever the others are. The cell has one.
[[nodiscard]] Cell::Uncertainty UncertaintyAmong(
    const Cell& cell, const std::function<bool(const std::string&)>& taken);

/// A matrix whose eigenvalues, each coordinate in the unit in which its variance is 1, are negative
/// by no more than this has no negative ones but for rounding. Entries may differ by as much from
/// their mirror images.
inline constexpr double kCovarianceRounding = 1e-8;

/// The least eigenvalue in those units; 0 of an empty matrix. The matrix is square.
[[nodiscard]] double LeastEigenvalue(const std::vector<std::vector<double>>& covariance);

}  // namespace lipoid
