#include "identify/trust/trust.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <tuple>

#include "identify/trust/local_noise.h"
#include "model/battery/uncertain_cell.h"
#include "model/core/errors.h"
#include "model/core/parallel.h"
#include "model/core/special_values.h"
#include "model/core/stop.h"
#include "model/statistics/factorizations.h"
#include "model/statistics/order_statistics.h"
#include "model/statistics/quantiles.h"

namespace lipoid {
namespace {

// A vector has a part in a direction if that is more than this share of it.
constexpr double kHasPart = 1e-4;
// Series that tell what the fit leaves of a component of the noise. With 4 of them, and 12
// simulations, the chance in them moved the half width of an interval by a third.
constexpr Eigen::Index kSeriesPerComponent = 16;
// A component of which less is left cannot be seen in the residuals at all.
constexpr double kSwallowed = 0.05;
// With fewer degrees of freedom Student's quantile is a statement about its own tails.
constexpr double kLeastFreedom = 3.0;
constexpr double kMostFreedom = 1e4;

// A symmetric matrix of information, turned round: each coordinate in the unit in which its own
// entry is 1, and directions without information left out.
class Information {
 public:
  explicit Information(const Eigen::MatrixXd& matrix) {
    const Eigen::Index n = matrix.rows();
    const Eigen::VectorXd diagonal = matrix.diagonal();
    unit_.resize(n);
    for (Eigen::Index k = 0; k < n; ++k)
      unit_[k] = diagonal[k] > 0.0 ? 1.0 / std::sqrt(diagonal[k]) : 0.0;
    if (n == 0) return;
    const SymmetricEigen eigen = EigenOfSymmetric(unit_.asDiagonal() * matrix * unit_.asDiagonal());
    const Eigen::VectorXd& values = eigen.values;
    const double least = kNoInformation * std::max(values[n - 1], 0.0);
    Eigen::Index empty = 0;
    while (empty < n && !(values[empty] > least)) ++empty;
    nothing_ = eigen.vectors.leftCols(empty);
    const Eigen::MatrixXd known = unit_.asDiagonal() * eigen.vectors.rightCols(n - empty);
    inverse_ = known * values.tail(n - empty).cwiseInverse().asDiagonal() * known.transpose();
  }

  /// A generalized inverse: right for every combination that is known.
  [[nodiscard]] const Eigen::MatrixXd& inverse() const { return inverse_; }

  /// Does the matrix hold information on this combination of the coordinates?
  [[nodiscard]] bool Knows(const Eigen::VectorXd& combination) const {
    for (Eigen::Index k = 0; k < unit_.size(); ++k) {
      if (unit_[k] == 0.0 && combination[k] != 0.0) return false;
    }
    const Eigen::VectorXd scaled = combination.cwiseProduct(unit_);
    return (nothing_.transpose() * scaled).norm() <= kHasPart * scaled.norm();
  }

 private:
  Eigen::VectorXd unit_;
  Eigen::MatrixXd nothing_;
  Eigen::MatrixXd inverse_;
};

// The place of each log by what is in it: noise that is drawn for it is the same in whatever order
// the logs were named.
std::vector<std::uint32_t> PlacesByContent(std::span<const FittedRows> logs) {
  std::vector<std::tuple<Eigen::Index, double, double>> content;
  for (const FittedRows& log : logs)
    content.emplace_back(log.residual_V.size(),
                         log.time_s.empty() ? 0.0 : log.time_s.back() - log.time_s.front(),
                         log.residual_V.squaredNorm());
  std::vector<std::uint32_t> order(logs.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return content[a] < content[b];
  });
  std::vector<std::uint32_t> place(logs.size());
  for (std::uint32_t k = 0; k < order.size(); ++k) place[order[k]] = k;
  return place;
}

Eigen::Index Size(const std::vector<Eigen::Index>& list) {
  return static_cast<Eigen::Index>(list.size());
}

// J'WJ of all logs, a strip of rows at a time. The strips are dealt out to lanes, whose sums are
// added in their order: the same bits with any number of threads.
Eigen::MatrixXd Gram(std::span<const FittedRows> logs) {
  constexpr Eigen::Index kStrip = 256;
  constexpr std::size_t kLanes = 8;
  struct Strip {
    const FittedRows& log;
    Eigen::Index from;
  };
  std::vector<Strip> strips;
  for (const FittedRows& log : logs) {
    for (Eigen::Index k = 0; k < log.sensitivity.rows(); k += kStrip) strips.push_back({log, k});
  }
  const Eigen::Index p = logs[0].sensitivity.cols();
  std::vector<Eigen::MatrixXd> lanes(std::clamp<std::size_t>(strips.size(), 1, kLanes));
  ParallelFor(lanes.size(), [&](std::size_t lane) {
    Eigen::MatrixXd& sum = lanes[lane];
    sum.setZero(p, p);
    Eigen::MatrixXd weighted;
    for (std::size_t k = lane; k < strips.size(); k += lanes.size()) {
      const auto& [log, from] = strips[k];
      const Eigen::Index rows = std::min(kStrip, log.sensitivity.rows() - from);
      weighted = log.weight.segment(from, rows).cwiseSqrt().asDiagonal() *
                 log.sensitivity.middleRows(from, rows);
      sum.selfadjointView<Eigen::Lower>().rankUpdate(weighted.transpose());
    }
  });
  for (std::size_t lane = 1; lane < lanes.size(); ++lane) lanes[0] += lanes[lane];
  return lanes[0].selfadjointView<Eigen::Lower>();
}

// Adds that to the covariance of quantities or combinations that varies already: what is held
// stays.
template <class Combinations>
void AddSpread(const Combinations& of, Eigen::MatrixXd& covariance) {
  Eigen::Index moves = 0;
  for (const auto& one : of) moves = std::max(moves, one.added_spread.size());
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(covariance.rows(), moves);
  for (Eigen::Index k = 0; k < spread.rows(); ++k) {
    const Eigen::VectorXd& one = of[static_cast<std::size_t>(k)].added_spread;
    if (one.size() > 0 && covariance(k, k) > 0.0) spread.row(k).head(one.size()) = one.transpose();
  }
  if (moves > 0) covariance += spread * spread.transpose();
}

// Makes a covariance symmetric and, where rounding left a combination a variance that is negative
// by more than a cell file lets pass, no longer negative; in units in which each own variance is 1.
void EndRounding(Eigen::MatrixXd& covariance) {
  covariance = 0.5 * (covariance + covariance.transpose()).eval();
  const Eigen::VectorXd unit = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd per_unit =
      (unit.array() > 0.0).select(unit.cwiseInverse(), 0.0 * unit).eval();
  const Eigen::MatrixXd own = per_unit.asDiagonal() * covariance * per_unit.asDiagonal();
  const auto one = Eigen::MatrixXd::Identity(own.rows(), own.cols());
  if ((own + kCovarianceRounding * one).llt().info() == Eigen::Success) return;
  const SymmetricEigen eigen = EigenOfSymmetric(own);
  const Eigen::MatrixXd root =
      unit.asDiagonal() * eigen.vectors * eigen.values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
  covariance = root * root.transpose();
}

class Assessment {
 public:
  Assessment(std::span<const FittedRows> logs,
             const Eigen::MatrixXd& penalty,
             const std::vector<TrustedQuantity>& quantities,
             const TrustOptions& options)
      : logs_(logs), quantities_(quantities), options_(options) {
    Check(penalty);
    place_ = PlacesByContent(logs_);
    FindFree();
    FindLocalNoise();
    const Eigen::MatrixXd h = SumRows(penalty);
    ParallelInvoke(
        [&] {
          if (!options_.assumed || !options_.drawn.empty()) fit_.emplace(h);
        },
        [&] { ReduceToQuantities(h); });
  }

  TrustReport Run() {
    if (options_.assumed) {
      AssumeCorrelation(*options_.assumed);
    } else {
      FindCorrelation();
    }
    FindSampling();
    SumScores();
    Judge();
    FindCombinations();
    FindDrawn();
    report_.sentence = TrustSentence(report_);
    return std::move(report_);
  }

 private:
  void Check(const Eigen::MatrixXd& penalty) const {
    Require(!logs_.empty(), "a log");
    const Eigen::Index p = logs_[0].sensitivity.cols();
    for (const FittedRows& log : logs_) {
      const Eigen::Index rows = log.residual_V.size();
      Require(static_cast<Eigen::Index>(log.time_s.size()) == rows && log.weight.size() == rows &&
                  log.sensitivity.rows() == rows && log.sensitivity.cols() == p &&
                  (log.averaged.size() == 0 || log.averaged.size() == rows),
              "as many times, weights and sensitivities as residuals");
      Require(log.residual_V.allFinite() && log.weight.allFinite() && log.sensitivity.allFinite(),
              "finite residuals, weights and sensitivities");
    }
    Require(penalty.size() == 0 || (penalty.rows() == p && penalty.cols() == p),
            "a penalty of p x p");
    for (const TrustedQuantity& q : quantities_)
      Require(q.combination.size() == p, "a combination of the p parameters");
  }

  // Parameters that no bound holds, and the quantities that depend on them.
  void FindFree() {
    const Eigen::Index p = logs_[0].sensitivity.cols();
    std::vector<bool> held(static_cast<std::size_t>(p), false);
    for (const Eigen::Index k : options_.held) held.at(static_cast<std::size_t>(k)) = true;
    for (const TrustedQuantity& q : quantities_) {
      for (Eigen::Index k = 0; q.at_bound && k < p; ++k) {
        if (q.combination[k] != 0.0) held[static_cast<std::size_t>(k)] = true;
      }
    }
    for (Eigen::Index k = 0; k < p; ++k) {
      if (!held[static_cast<std::size_t>(k)]) free_.push_back(k);
    }
  }

  // Noise that is assumed is as large everywhere.
  void FindLocalNoise() {
    for (const FittedRows& log : logs_) {
      local_.push_back(options_.assumed ? Eigen::VectorXd::Ones(log.residual_V.size()).eval()
                                        : LocalNoise(log.time_s, log.residual_V, log.averaged));
      weighted_.push_back(log.weight.cwiseProduct(local_.back()));
    }
  }

  // H of the free parameters.
  Eigen::MatrixXd SumRows(const Eigen::MatrixXd& penalty) {
    for (const FittedRows& log : logs_) {
      weight_ += log.weight.sum();
      rows_ +=
          log.averaged.size() > 0 ? log.averaged.sum() : static_cast<double>(log.weight.size());
    }
    Eigen::MatrixXd all = Gram(logs_);
    if (penalty.size() > 0) all += penalty;
    return all(free_, free_);
  }

  // The information on the quantities, with the other parameters left to follow: a change of the
  // quantities by dq moves the free parameters by D dq, and
  //   A = D'HD,   covariance = A^{-1} (D'J'W Sigma W J D) A^{-1}
  void ReduceToQuantities(const Eigen::MatrixXd& h) {
    // In units in which each parameter carries as much as another.
    Eigen::VectorXd unit(Size(free_));
    for (Eigen::Index k = 0; k < Size(free_); ++k)
      unit[k] = h(k, k) > 0.0 ? 1.0 / std::sqrt(h(k, k)) : 1.0;
    // Quantities that do not follow from those before them.
    Eigen::MatrixXd c(0, Size(free_));
    Eigen::VectorXd size;
    Eigen::MatrixXd orthogonal(Size(free_), 0);
    for (const TrustedQuantity& q : quantities_) {
      Eigen::VectorXd row = q.combination(free_).cwiseProduct(unit);
      Eigen::VectorXd rest = row;
      for (int twice = 0; twice < 2; ++twice) rest -= orthogonal * (orthogonal.transpose() * rest);
      if (q.at_bound || !(rest.norm() > 1e-9 * row.norm())) continue;
      primary_.push_back(static_cast<Eigen::Index>(&q - quantities_.data()));
      c.conservativeResize(c.rows() + 1, Eigen::NoChange);
      c.bottomRows(1) = row.normalized().transpose();
      size.conservativeResize(c.rows());
      size[c.rows() - 1] = row.norm();
      orthogonal.conservativeResize(Eigen::NoChange, orthogonal.cols() + 1);
      orthogonal.rightCols(1) = rest.normalized();
    }
    const Eigen::Index n = Size(primary_);
    const Eigen::MatrixXd per_size = size.cwiseInverse().asDiagonal();
    const Eigen::MatrixXd moves = c.transpose() * (c * c.transpose()).ldlt().solve(per_size);
    Eigen::MatrixXd d = moves;
    if (n < Size(free_)) {
      const Eigen::MatrixXd basis = OrthogonalBasis(orthogonal);
      const Eigen::MatrixXd others = basis.rightCols(Size(free_) - n);
      const Eigen::MatrixXd scaled = unit.asDiagonal() * h * unit.asDiagonal();
      const Eigen::MatrixXd coupling = others.transpose() * scaled;
      d -= others * (Information(coupling * others).inverse() * (coupling * moves));
    }
    d = unit.asDiagonal() * d;
    information_ = d.transpose() * h * d;
    information_ = 0.5 * (information_ + information_.transpose()).eval();
    // What each quantity is in terms of the primary ones.
    terms_.setZero(static_cast<Eigen::Index>(quantities_.size()), n);
    for (std::size_t q = 0; q < quantities_.size(); ++q) {
      if (quantities_[q].at_bound) continue;
      terms_.row(static_cast<Eigen::Index>(q)) =
          quantities_[q].combination(free_).cwiseProduct(unit).transpose() * moves;
    }
    for (Eigen::Index k = 0; k < n; ++k) {
      terms_.row(primary_[static_cast<std::size_t>(k)]).setZero();
      terms_(primary_[static_cast<std::size_t>(k)], k) = 1.0;
    }
    Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(logs_[0].sensitivity.cols(), n);
    spread(free_, Eigen::all) = d;
    scores_.resize(logs_.size());
    ParallelFor(logs_.size(), [&](std::size_t l) {
      scores_[l] = (logs_[l].sensitivity * spread).transpose() * weighted_[l].asDiagonal();
    });
  }

  // What the fit leaves of noise: series x rows of every log over its local size, in place. Logs
  // without rows are quiet.
  void Project(std::vector<Eigen::MatrixXd>& noise) const {
    Eigen::MatrixXd score;
    for (std::size_t l = 0; l < logs_.size(); ++l) {
      if (noise[l].size() == 0) continue;
      if (score.size() == 0) score.setZero(noise[l].rows(), logs_[l].sensitivity.cols());
      score.noalias() += (noise[l] * weighted_[l].asDiagonal()) * logs_[l].sensitivity;
    }
    if (score.size() == 0) return;
    Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(score.rows(), score.cols());
    moved(Eigen::all, free_) = score(Eigen::all, free_) * fit_->inverse();
    for (std::size_t l = 0; l < logs_.size(); ++l) {
      if (noise[l].size() == 0) continue;
      noise[l].noalias() -=
          moved * logs_[l].sensitivity.transpose() * local_[l].cwiseInverse().asDiagonal();
    }
  }

  // Of the noise of a log: each purpose its own.
  enum class Noise : std::uint32_t { kLikeResiduals, kOfComponent };
  [[nodiscard]] std::uint32_t Stream(std::size_t log, Noise purpose) const {
    return 2U * place_[log] + static_cast<std::uint32_t>(purpose);
  }

  // A log and a component of its noise: what is done for each of them is done on all cores.
  struct Part {
    std::size_t log;
    Eigen::Index component;
  };
  [[nodiscard]] std::vector<Part> Parts() const {
    std::vector<Part> parts;
    for (std::size_t l = 0; l < models_.size(); ++l) {
      for (Eigen::Index m = 0; m < models_[l].components(); ++m) parts.push_back({l, m});
    }
    return parts;
  }

  // The variogram that noise of one component has left when the fit has followed it: from what it was
  // without a fit, in place. And its squares.
  void FindDesignOfResiduals(const Part& part,
                             Eigen::MatrixXd& designs,
                             Eigen::MatrixXd& parts) const {
    const auto [l, m] = part;
    const CorrelationModel& model = models_[l];
    std::vector<Eigen::MatrixXd> all(logs_.size());
    Eigen::MatrixXd& noise = all[l];
    noise = model.Simulate(Eigen::VectorXd::Unit(model.components(), m),
                           kSeriesPerComponent,
                           options_.seed,
                           Stream(l, Noise::kOfComponent));
    const Eigen::VectorXd before = model.Variogram(noise).rowwise().sum();
    const Eigen::MatrixXd drawn = noise;
    Project(all);
    const Squares squares = SquaresOf(l, drawn, noise);
    parts.col(m) << squares.own.mean(), squares.left.mean(), squares.followed.mean();
    const Eigen::VectorXd after = model.Variogram(noise).rowwise().sum();
    auto design = designs.col(m);
    const Eigen::Index last = design.size() - 1;
    if (!(before[last] > 0.0)) return;
    const double largest = design.maxCoeff();
    const double mean_square = design[last];
    // The part that is left, so that the chance of the noise drops out.
    for (Eigen::Index k = 0; k <= last; ++k) {
      design[k] = before[k] > 0.0 ? design[k] * after[k] / before[k]
                                  : mean_square * after[k] / before[last];
    }
    if (!(design.maxCoeff() > kSwallowed * largest)) design.setZero();
  }

  // White first, then the one time constant; nothing is to be found, and nothing is uncertain.
  void AssumeCorrelation(const ResidualCorrelation& assumed) {
    for (std::size_t l = 0; l < logs_.size(); ++l) {
      models_.emplace_back(logs_[l].time_s, logs_[l].averaged, assumed.correlation_s);
      const double slow_V = assumed.correlated_V;
      variances_.push_back(Eigen::Vector2d(assumed.white_V * assumed.white_V, slow_V * slow_V));
      simulated_.emplace_back(2, 0);
      report_.new_over_fitted.push_back(1.0);
    }
  }

  void FindCorrelation() {
    std::vector<Eigen::MatrixXd> designs;
    for (const FittedRows& log : logs_) {
      models_.emplace_back(log.time_s, log.averaged);
      designs.push_back(models_.back().design());
      parts_.emplace_back(Eigen::MatrixXd::Zero(3, models_.back().components()));
    }
    const std::vector<Part> parts = Parts();
    ParallelFor(parts.size(), [&](std::size_t k) {
      StopIfAsked();
      FindDesignOfResiduals(parts[k], designs[parts[k].log], parts_[parts[k].log]);
    });
    const Eigen::Index series = options_.simulations;
    std::vector<Eigen::MatrixXd> noise(logs_.size());
    variances_.resize(logs_.size());
    ParallelFor(logs_.size(), [&](std::size_t l) {
      StopIfAsked();
      const CorrelationModel& model = models_[l];
      const Eigen::VectorXd even = logs_[l].residual_V.cwiseQuotient(local_[l]);
      variances_[l] = model.Fit(model.Variogram(even.transpose()), designs[l]);
      noise[l] =
          model.Simulate(variances_[l], series, options_.seed, Stream(l, Noise::kLikeResiduals));
    });
    // The same of noise that has the correlation found.
    const std::vector<Eigen::MatrixXd> drawn = noise;
    Project(noise);
    simulated_.resize(logs_.size());
    ParallelFor(logs_.size(), [&](std::size_t l) {
      const Eigen::MatrixXd variograms = models_[l].Variogram(noise[l]);
      simulated_[l].resize(variances_[l].size(), series);
      for (Eigen::Index s = 0; s < series; ++s)
        simulated_[l].col(s) = models_[l].Fit(variograms.col(s), designs[l]);
    });
    CompareNewWithFitted(drawn, noise);
  }

  // Sums over the rows of a log, of each series: of noise, of what is left of it in the logs of the fit,
  // and of what the fit has followed.
  struct Squares {
    Eigen::ArrayXd own, left, followed;
  };
  [[nodiscard]] Squares SquaresOf(std::size_t l,
                                  const Eigen::MatrixXd& drawn,
                                  const Eigen::MatrixXd& left) const {
    const Eigen::VectorXd weight = local_[l].cwiseAbs2().cwiseProduct(Count(l));
    const auto sum = [&](const Eigen::MatrixXd& of) -> Eigen::ArrayXd {
      return (of.cwiseAbs2() * weight).array();
    };
    return {sum(drawn), sum(left), sum(drawn - left)};
  }
  [[nodiscard]] Eigen::VectorXd Count(std::size_t l) const {
    const FittedRows& log = logs_[l];
    if (log.averaged.size() > 0) return log.averaged;
    return Eigen::VectorXd::Ones(log.residual_V.size());
  }
  // What rows that were taken together have about their mean, which no fit follows, at these variances.
  [[nodiscard]] double Within(std::size_t l, const Eigen::VectorXd& variances) const {
    return variances[0] * local_[l].cwiseAbs2().dot((Count(l).array() - 1.0).matrix());
  }
  // Of a new log over that in the fit, by what the log's own noise of these variances does.
  [[nodiscard]] double NewOverFitted(std::size_t l, const Eigen::VectorXd& variances) const {
    const Eigen::Vector3d squares = parts_[l] * variances;
    const double within = Within(l, variances);
    const double left = squares[1] + within;
    return left > 0.0 ? std::sqrt((squares[0] + squares[2] + within) / left) : 1.0;
  }

  // A new log has noise of its own, and in it the fit's error, which is what the fit has followed of
  // the noise `drawn`: squares of both add. In the logs of the fit only what is `left` is seen. How
  // slow the noise is can hardly be told from that: one fit finds 1 where another finds 5. The mean of
  // what noise like the residuals' leads to is therefore taken (bagging), and its scatter counts.
  void CompareNewWithFitted(const std::vector<Eigen::MatrixXd>& drawn,
                            const std::vector<Eigen::MatrixXd>& left) {
    const Eigen::Index series = options_.simulations;
    // Sums of the logs' rms, of each series: what is said from the fitted rows, and what is so.
    Eigen::ArrayXd said_V = Eigen::ArrayXd::Zero(series);
    Eigen::ArrayXd new_V = Eigen::ArrayXd::Zero(series);
    for (std::size_t l = 0; l < logs_.size(); ++l) {
      report_.new_over_fitted.push_back(1.0);
      if (logs_[l].residual_V.size() == 0) continue;
      const Squares squares = SquaresOf(l, drawn[l], left[l]);
      const double within = Within(l, variances_[l]);
      const Eigen::ArrayXd fitted = squares.left + within;
      const Eigen::ArrayXd anew = squares.followed + squares.own.mean() + within;
      if (!(fitted.minCoeff() > 0.0)) continue;
      Eigen::ArrayXd found_again(series);
      for (Eigen::Index s = 0; s < series; ++s)
        found_again[s] = std::log(NewOverFitted(l, simulated_[l].col(s)));
      const double ratio = std::sqrt(anew.mean() / fitted.mean());
      const double usual = std::exp(found_again.mean());
      report_.new_over_fitted.back() =
          std::max(1.0, ratio * usual / NewOverFitted(l, variances_[l]));
      const double rows = Count(l).sum();
      said_V += found_again.exp() / usual * ratio * (fitted / rows).sqrt();
      new_V += (anew / rows).sqrt();
    }
    if (!(said_V.minCoeff() > 0.0)) return;
    const Eigen::ArrayXd miss = (new_V / said_V).log();
    report_.new_over_fitted_spread =
        std::sqrt((miss - miss.mean()).square().sum() / static_cast<double>(series - 1));
  }

  void FindSampling() {
    for (const FittedRows& log : logs_) {
      if (log.time_s.size() < 2) continue;
      report_.span_s = std::max(report_.span_s, log.time_s.back() - log.time_s.front());
      // The shortest steps that are more than an exception.
      std::vector<double> steps;
      for (std::size_t k = 1; k < log.time_s.size(); ++k)
        steps.push_back(log.time_s[k] - log.time_s[k - 1]);
      const double shortest_s = ValueAtPlace(steps, steps.size() / 100);
      report_.sampling_s =
          report_.sampling_s > 0.0 ? std::min(report_.sampling_s, shortest_s) : shortest_s;
    }
  }

  void SumScores() {
    for (std::size_t l = 0; l < logs_.size(); ++l)
      report_.residual_correlation.push_back(models_[l].Describe(variances_[l]));
    const std::vector<Part> parts = Parts();
    sums_.resize(parts.size());
    ParallelFor(parts.size(), [&](std::size_t k) {
      const auto [l, m] = parts[k];
      const bool seen = variances_[l][m] > 0.0 || (simulated_[l].row(m).array() > 0.0).any();
      if (seen) sums_[k] = models_[l].QuadraticSum(scores_[l], m);
    });
  }

  // D'J'W Sigma W J D with the variances that `of(log)` gives.
  template <class Variances>
  [[nodiscard]] Eigen::MatrixXd Scatter(Variances&& of) const {
    const Eigen::Index n = Size(primary_);
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(n, n);
    std::size_t at = 0;
    for (std::size_t l = 0; l < logs_.size(); ++l) {
      const Eigen::VectorXd variances = of(l);
      for (Eigen::Index m = 0; m < variances.size(); ++m, ++at) {
        if (variances[m] > 0.0) sum += variances[m] * sums_[at];
      }
    }
    return sum;
  }

  void Judge() {
    const Eigen::MatrixXd scatter = Scatter([&](std::size_t l) { return variances_[l]; });
    const Information known(information_);
    const Eigen::MatrixXd& inverse = known.inverse();
    const Eigen::MatrixXd covariance = inverse * scatter * inverse;
    const Eigen::VectorXd freedom = DegreesOfFreedom(inverse);
    Eigen::MatrixXd all = terms_ * covariance * terms_.transpose();
    AddSpread(quantities_, all);
    for (Eigen::Index k = 0; k < all.rows(); ++k) {
      const TrustedQuantity& q = quantities_[static_cast<std::size_t>(k)];
      if (q.from_elsewhere) all(k, k) = q.added_spread.squaredNorm();
    }
    report_.covariance = all;
    double squares = 0.0;
    for (std::size_t l = 0; l < logs_.size(); ++l) {
      const FittedRows& log = logs_[l];
      squares += log.residual_V.cwiseAbs2().dot(log.weight);
      // What rows that were taken together had about their mean.
      if (log.averaged.size() == 0) continue;
      squares += variances_[l][0] *
                 log.weight.cwiseQuotient(log.averaged).dot((log.averaged.array() - 1.0).matrix());
    }
    const double freedom_left = std::max(1.0, rows_ - static_cast<double>(free_.size()));
    const double white = squares / freedom_left;  // of a row of weight 1

    for (std::size_t k = 0; k < quantities_.size(); ++k) {
      const TrustedQuantity& q = quantities_[k];
      const auto index = static_cast<Eigen::Index>(k);
      const Eigen::VectorXd term = terms_.row(index).transpose();
      QuantityTrust trust;
      trust.name = q.name;
      trust.unit = q.unit;
      trust.estimate = q.value;
      trust.degrees_of_freedom = freedom[index];
      const bool held = !q.from_elsewhere && (q.at_bound || term.isZero(0.0));
      const bool known_at_all = q.from_elsewhere || (!held && known.Knows(term));
      const double variance = std::max(0.0, all(index, index));
      trust.standard_error = held ? kNaN : known_at_all ? std::sqrt(variance) : kInfinity;
      trust.model_standard_error = q.added_spread.norm();
      trust.relative_standard_error = trust.standard_error / Scale(q);
      const double reach = Reach95(freedom[index]);
      trust.low = std::clamp(q.value - reach * trust.standard_error, q.lower, q.upper);
      trust.high = std::clamp(q.value + reach * trust.standard_error, q.lower, q.upper);
      const double spread = term.dot(inverse * term);
      // A plan has no residuals from which the formula could take the noise.
      trust.white_standard_error = options_.assumed || q.from_elsewhere ? kNaN
                                   : known_at_all                       ? std::sqrt(white * spread)
                                                                        : trust.standard_error;
      trust.objective_rise_95 =
          known_at_all && !q.from_elsewhere ? reach * reach * variance / spread : kNaN;
      for (Eigen::Index n = 0; n < term.size(); ++n)
        trust.insensitive = trust.insensitive || (term[n] != 0.0 && !(information_(n, n) > 0.0));
      if (held) {
        trust.verdict = Verdict::kAtBound;
      } else if (reach * trust.relative_standard_error <= kIdentifiedHalfWidth) {
        trust.verdict = Verdict::kIdentified;
      } else if (std::isfinite(trust.standard_error)) {
        const double of_noise = std::sqrt(std::max(0.0, variance - q.added_spread.squaredNorm()));
        trust.open_by_model = reach * of_noise <= kIdentifiedHalfWidth * Scale(q);
      }
      if (!known_at_all) {
        report_.covariance.row(index).setConstant(kNaN);
        report_.covariance.col(index).setConstant(kNaN);
        report_.covariance(index, index) = trust.standard_error;
      }
      report_.quantities.push_back(std::move(trust));
    }
    ParallelFor(quantities_.size(), [&](std::size_t k) {
      QuantityTrust& trust = report_.quantities[k];
      // To know its partners takes nothing from what the choice of the model adds.
      if (trust.verdict == Verdict::kWeak && !trust.insensitive && !trust.open_by_model)
        FindPartners(static_cast<Eigen::Index>(k), scatter, trust);
    });
  }

  // Noise of the correlation found gives, by the same way, a variance of each quantity: its spread
  // tells how many degrees of freedom the variance has.
  [[nodiscard]] Eigen::VectorXd DegreesOfFreedom(const Eigen::MatrixXd& inverse) const {
    Eigen::VectorXd freedom = Eigen::VectorXd::Constant(terms_.rows(), kMostFreedom);
    const auto variances_of = [&](const Eigen::MatrixXd& scatter) -> Eigen::VectorXd {
      const Eigen::MatrixXd side = terms_ * inverse;
      return (side * scatter).cwiseProduct(side).rowwise().sum();
    };
    const Eigen::Index series = simulated_.front().cols();
    if (series < 2) return freedom;
    Eigen::MatrixXd found(terms_.rows(), series);
    for (Eigen::Index s = 0; s < series; ++s)
      found.col(s) =
          variances_of(Scatter([&](std::size_t l) { return simulated_[l].col(s).eval(); }));
    for (Eigen::Index k = 0; k < terms_.rows(); ++k) {
      const double mean = found.row(k).mean();
      if (!(mean > 0.0)) continue;
      const Eigen::ArrayXd log = found.row(k).transpose().array().max(1e-9 * mean).log();
      const double spread = (log - log.mean()).square().sum() / static_cast<double>(series - 1);
      // The logarithm of a variance of n degrees of freedom has the variance 2/n + 2/n² or so.
      freedom[k] =
          std::clamp((1.0 + std::sqrt(1.0 + 2.0 * spread)) / spread, kLeastFreedom, kMostFreedom);
    }
    return freedom;
  }

  // Would it be identified if others were known?
  void FindPartners(Eigen::Index quantity,
                    const Eigen::MatrixXd& scatter,
                    QuantityTrust& trust) const {
    const auto place = std::find(primary_.begin(), primary_.end(), quantity);
    if (place == primary_.end()) return;
    const TrustedQuantity& q = quantities_[static_cast<std::size_t>(quantity)];
    const double reach = Reach95(trust.degrees_of_freedom);
    std::vector<Eigen::Index> free;
    for (Eigen::Index k = 0; k < Size(primary_); ++k) free.push_back(k);
    const auto self = place - primary_.begin();
    const auto error_with = [&](const std::vector<Eigen::Index>& some) {
      const Information known(information_(some, some));
      const auto at = std::find(some.begin(), some.end(), self) - some.begin();
      if (!known.Knows(Eigen::VectorXd::Unit(Size(some), at))) return kInfinity;
      const Eigen::VectorXd side = known.inverse().col(at);
      return std::sqrt(std::max(0.0, side.dot(scatter(some, some) * side)));
    };
    std::vector<std::string> with;
    double error = kInfinity;
    for (int partners = 0; partners < kMostPartners && free.size() > 1; ++partners) {
      std::vector<Eigen::Index> best;
      double least = kInfinity;
      Eigen::Index known = -1;
      for (const Eigen::Index other : free) {
        if (other == self) continue;
        std::vector<Eigen::Index> some = free;
        std::erase(some, other);
        const double here = error_with(some);
        if (known < 0 || here < least) {
          least = here;
          best = some;
          known = other;
        }
      }
      free = best;
      error = least;
      with.push_back(
          quantities_[static_cast<std::size_t>(primary_[static_cast<std::size_t>(known)])].name);
      if (reach * error <= kIdentifiedHalfWidth * Scale(q)) break;
    }
    if (reach * error <= kIdentifiedHalfWidth * Scale(q) &&
        kPartnersShrink * error <= trust.standard_error) {
      trust.verdict = Verdict::kOnlyInCombination;
      trust.with = std::move(with);
    }
  }

  void FindCombinations() {
    const Eigen::Index n = Size(primary_);
    if (n == 0) return;
    Eigen::VectorXd scale(n);
    for (Eigen::Index k = 0; k < n; ++k)
      scale[k] =
          Scale(quantities_[static_cast<std::size_t>(primary_[static_cast<std::size_t>(k)])]);
    const SymmetricEigen eigen =
        EigenOfSymmetric(scale.asDiagonal() * information_ * scale.asDiagonal());
    for (Eigen::Index k = 0; k < n; ++k) {
      CarriedCombination combination;
      combination.singular_value_V =
          std::sqrt(std::max(0.0, eigen.values[k]) / std::max(weight_, 1e-300));
      combination.weights.assign(quantities_.size(), 0.0);
      // The largest weight is positive.
      Eigen::VectorXd weights = eigen.vectors.col(k);
      Eigen::Index largest = 0;
      weights.cwiseAbs().maxCoeff(&largest);
      if (weights[largest] < 0.0) weights = -weights;
      for (Eigen::Index j = 0; j < n; ++j)
        combination.weights[static_cast<std::size_t>(primary_[static_cast<std::size_t>(j)])] =
            weights[j];
      report_.combinations.push_back(std::move(combination));
    }
  }

  // H^{-1} J'W Sigma W J H^{-1} of the combinations that cells are drawn from.
  void FindDrawn() {
    const std::vector<NamedCombination>& drawn = options_.drawn;
    if (drawn.empty()) return;
    Eigen::MatrixXd of_free(static_cast<Eigen::Index>(drawn.size()), Size(free_));
    for (Eigen::Index k = 0; k < of_free.rows(); ++k) {
      const NamedCombination& one = drawn[static_cast<std::size_t>(k)];
      Require(one.combination.size() == logs_[0].sensitivity.cols(),
              "a combination of the p parameters");
      of_free.row(k) = one.combination(free_).transpose();
      report_.drawn.push_back(one.name);
    }
    std::vector<Eigen::MatrixXd> sums(logs_.size());
    ParallelFor(logs_.size(), [&](std::size_t l) {
      const Eigen::MatrixXd scores =
          logs_[l].sensitivity(Eigen::all, free_).transpose() * weighted_[l].asDiagonal();
      sums[l] = models_[l].QuadraticSum(scores, variances_[l]);
    });
    for (std::size_t l = 1; l < sums.size(); ++l) sums[0] += sums[l];
    const Eigen::MatrixXd moves = of_free * fit_->inverse();
    report_.drawn_covariance = moves * sums[0] * moves.transpose();
    AddSpread(drawn, report_.drawn_covariance);
    EndRounding(report_.drawn_covariance);
  }

  static double Scale(const TrustedQuantity& q) {
    if (q.scale > 0.0) return q.scale;
    return q.value != 0.0 ? std::abs(q.value) : 1.0;
  }

  std::span<const FittedRows> logs_;
  const std::vector<TrustedQuantity>& quantities_;
  const TrustOptions& options_;

  std::vector<Eigen::Index> free_;       // parameters
  std::vector<Eigen::Index> primary_;    // quantities that do not follow from others
  std::optional<Information> fit_;       // H of the free parameters
  Eigen::MatrixXd information_;          // A of the primary quantities
  Eigen::MatrixXd terms_;                // every quantity in terms of the primary ones
  std::vector<Eigen::MatrixXd> scores_;  // D'J'Ws of each log, a column per row
  double weight_ = 0.0;
  double rows_ = 0.0;  // of the logs themselves

  std::vector<std::uint32_t> place_;       // of each log, by its content
  std::vector<Eigen::VectorXd> local_;     // s of each log: its noise is s times an even one
  std::vector<Eigen::VectorXd> weighted_;  // W s
  std::vector<CorrelationModel> models_;
  std::vector<Eigen::VectorXd> variances_;  // of the residuals' correlation
  std::vector<Eigen::MatrixXd> simulated_;  // found again in each simulation
  std::vector<Eigen::MatrixXd> parts_;      // of each log: Squares of noise of each component
  std::vector<Eigen::MatrixXd> sums_;       // of the scores, for each log and component in turn
  TrustReport report_;
};

}  // namespace

TrustReport AssessTrust(std::span<const FittedRows> logs,
                        const Eigen::MatrixXd& penalty,
                        const std::vector<TrustedQuantity>& quantities,
                        const TrustOptions& options) {
  return Assessment(logs, penalty, quantities, options).Run();
}

QuantityTrust TrustOfEstimate(std::string name,
                              std::string unit,
                              double estimate,
                              double standard_error,
                              double degrees_of_freedom) {
  QuantityTrust trust;
  trust.name = std::move(name);
  trust.unit = std::move(unit);
  trust.estimate = estimate;
  const bool known = degrees_of_freedom > 0.0 && std::isfinite(standard_error);
  trust.degrees_of_freedom = std::max(0.0, degrees_of_freedom);
  trust.standard_error = trust.white_standard_error = known ? standard_error : kInfinity;
  trust.relative_standard_error = trust.standard_error / std::abs(estimate);
  const double reach = known ? Reach95(degrees_of_freedom) : 1.0;
  trust.low = std::max(0.0, estimate - reach * trust.standard_error);
  trust.high = estimate + reach * trust.standard_error;
  trust.objective_rise_95 = kNaN;
  trust.verdict = reach * trust.relative_standard_error <= kIdentifiedHalfWidth
                      ? Verdict::kIdentified
                      : Verdict::kWeak;
  return trust;
}

const QuantityTrust* FindQuantity(const TrustReport& trust, const std::string& name) {
  for (const QuantityTrust& quantity : trust.quantities) {
    if (quantity.name == name) return &quantity;
  }
  return nullptr;
}

double Reach95(const QuantityTrust& quantity) {
  if (!std::isfinite(quantity.standard_error) || !(quantity.degrees_of_freedom > 0.0))
    return quantity.standard_error;
  return quantity.standard_error * Reach95(quantity.degrees_of_freedom);
}

}  // namespace lipoid
