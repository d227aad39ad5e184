#include "identify/stages/voltage_sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "identify/joint/joint_fit.h"
#include "identify/logs/columns.h"
#include "identify/stages/row_factor.h"
#include "model/battery/record_stepper.h"
#include "model/core/errors.h"
#include "model/core/parallel.h"
#include "model/core/stop.h"

namespace lipoid {
namespace {

// One log of a plain cell (CellRows::Plain) swept with one set of parameters. What becomes of its points is the visitor's:
//   Row(k, soc, row)                      row k of the log
//   Begin(piece, shape), Node(piece, shape, j, soc, row) for every node, End(piece, shape)
//                                         a block whose sums its nodes carry exactly
// A block that crosses a knot of v_oc(A) comes as its rows.
class LogSweep {
 public:
  /// Slopes are those at the linear unknowns x; none where it is null. All must outlive this.
  LogSweep(const JointSetup& setup,
           const CondensedLog& log,
           double initial_soc,
           const JointStructure& structure,
           const JointRates& rates,
           const Eigen::VectorXd* x,
           bool knots_matter)
      : log_(log),
        curve_(setup.open_circuit_voltage),
        knots_matter_(knots_matter),
        branches_(structure.branches),
        slopes_(x != nullptr),
        soc_(setup,
             setup.alpha_C,
             rates.beta_per_sqrt_s,
             setup.alpha_C * (1.0 - initial_soc),
             slopes_),
        rows_(setup,
              structure,
              rates,
              1.0,
              x == nullptr ? nullptr : x->data(),
              CurveSlope::kOfSegments) {
    Require(CellRows::Plain(structure), "a structure of constant resistances and a given curve");
  }

  template <class Visitor>
  void Run(Visitor&& visitor) {
    std::vector<BlockSteps> blocks(log_.shapes().size());
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      const BlockShape& shape = log_.shapes()[k];
      std::vector<double> times_s(shape.node_s.begin(), shape.node_s.end());
      times_s.push_back(shape.duration_s());
      soc_.SetSpan(times_s, blocks[k].soc);
      std::adjacent_difference(times_s.begin(), times_s.end(), times_s.begin());
      rows_.SetSteps(times_s, blocks[k].rows);
    }
    for (const CondensedPiece& piece : log_.pieces()) {
      if (!piece.plain()) {
        TakeBlock(piece, blocks[piece.shape], visitor);
        continue;
      }
      for (std::size_t k = piece.first; k < piece.first + piece.rows; ++k) TakeRow(k, visitor);
    }
  }

 private:
  struct Steps {
    ModeSteps soc, rows;
  };
  struct BlockSteps {
    SocSpan soc;     // to the nodes and the end from the start
    ModeSteps rows;  // to each from the one before
  };

  template <class Visitor>
  void TakeRow(std::size_t k, Visitor& visitor) {
    const Record& record = log_.record();
    const double current_A = record.current_A[k];
    if (k > 0) {
      const double dt_s = record.time_s[k] - record.time_s[k - 1];
      const double step_A = record.hold == Hold::kBackward ? current_A : record.current_A[k - 1];
      const Steps& steps = cache_.Get(dt_s, record.time_s[k], [&](double dt, Steps& made) {
        soc_.SetSteps(std::array{dt}, made.soc);
        rows_.SetSteps(std::array{dt}, made.rows);
      });
      rows_.Step<true>(steps.rows, 0, {.current_A = step_A});  // constant resistances look at no A
      soc_.Step(steps.soc, 0, step_A, dt_s);
    }
    const double soc = soc_.Soc(current_A);
    const CellRows::At point{.current_A = current_A,
                             .soc = soc,
                             .slopes = {.beta = soc_.Slope(current_A)},
                             .v_oc = curve_.Evaluate(soc)};
    visitor.Row(k, soc, rows_.MakeRow<true>(point, record.voltage_V[k]));
  }

  template <class Visitor>
  void TakeBlock(const CondensedPiece& piece, const BlockSteps& block, Visitor& visitor) {
    const BlockShape& shape = log_.shapes()[piece.shape];
    const double current_A = piece.current_A;
    const Eigen::Index nodes = shape.nodes();
    soc_.Reach(block.soc, current_A, at_, slope_);
    std::size_t formula = 0;
    bool crosses = false;
    if (knots_matter_) {
      // Its ends reach a little beyond the nodes.
      const auto [low, high] = std::minmax_element(at_.begin(), at_.begin() + nodes);
      const double reach = 0.1 * (*high - *low);
      formula = curve_.Formula(*low - reach);
      crosses = curve_.Formula(*high + reach) != formula;
    }
    const auto node =
        [&](Eigen::Index j, OpenCircuitVoltage::ValueAndSlope v_oc, double measured_V) {
          rows_.Step<true>(block.rows, j, {.current_A = current_A});
          return rows_.MakeRow<true>({.current_A = current_A,
                                      .soc = at_[j],
                                      .slopes = {.beta = soc_.slopes() ? slope_[j] : 0.0},
                                      .v_oc = v_oc},
                                     measured_V);
        };
    if (crosses) {
      for (Eigen::Index j = 0; j < nodes; ++j) KeepNode(j, nodes, node(j, {}, 0.0));
      TakeRowsOf(piece, shape, visitor);
    } else {
      const double* voltage_V = log_.node_voltage_V(piece);
      visitor.Begin(piece, shape);
      for (Eigen::Index j = 0; j < nodes; ++j) {
        const auto v_oc = curve_.EvaluateIn(formula, at_[j]);
        visitor.Node(piece, shape, j, at_[j], node(j, v_oc, voltage_V[j]));
      }
      visitor.End(piece, shape);
    }
    rows_.Step<true>(block.rows, nodes, {.current_A = current_A});
    soc_.Step(block.soc.steps, nodes, current_A, piece.duration_s);  // by the stamps themselves
  }

  // Of a block that crosses a knot: A, its slope in beta, and what the row of a node holds beside v_oc.
  void KeepNode(Eigen::Index j, Eigen::Index nodes, const CellRow& row) {
    entries_.assign(row.index, row.index + row.entries);
    at_nodes_.resize(nodes, 1 + row.entries + (slopes_ ? 1 + branches_ : 0));
    Eigen::Index column = 0;
    at_nodes_(j, column++) = at_[j];
    for (int e = 0; e < row.entries; ++e) at_nodes_(j, column++) = row.value[e];
    if (!slopes_) return;
    at_nodes_(j, column++) = soc_.slopes() ? slope_[j] : 0.0;
    for (int b = 0; b < branches_; ++b) at_nodes_(j, column++) = row.slope[1 + b];
  }

  // All of these are polynomials, known by their values at the nodes.
  template <class Visitor>
  void TakeRowsOf(const CondensedPiece& piece, const BlockShape& shape, Visitor& visitor) {
    const auto entries = static_cast<Eigen::Index>(entries_.size());
    at_rows_.resize(shape.to_rows.rows(), at_nodes_.cols());
    for (Eigen::Index c = 0; c < at_nodes_.cols(); ++c)
      at_rows_.col(c).noalias() = shape.to_rows * at_nodes_.col(c);
    at_row_.resize(static_cast<std::size_t>(at_rows_.cols()));
    for (std::size_t r = 0; r < piece.rows; ++r) {
      for (Eigen::Index c = 0; c < at_rows_.cols(); ++c)
        at_row_[static_cast<std::size_t>(c)] = at_rows_(static_cast<Eigen::Index>(r), c);
      const double soc = at_row_[0];
      const auto v_oc = curve_.Evaluate(soc);
      double* slope = at_row_.data() + 1 + entries;
      if (slopes_) slope[0] *= v_oc.slope_V;
      const std::size_t k = piece.first + r;
      visitor.Row(k,
                  soc,
                  {static_cast<int>(entries),
                   entries_.data(),
                   at_row_.data() + 1,
                   log_.record().voltage_V[k] - v_oc.value_V,
                   slope});
    }
  }

  const CondensedLog& log_;
  const OpenCircuitVoltage& curve_;
  bool knots_matter_;
  int branches_;
  bool slopes_;
  SocState soc_;
  CellRows rows_;
  IntervalCache<Steps> cache_;
  Eigen::VectorXd at_, slope_;  // of the nodes of a block and its end
  std::vector<int> entries_;    // of a row
  Eigen::MatrixXd at_nodes_, at_rows_;
  std::vector<double> at_row_;
};

// Adds up the rows of [J r] at the unknowns x.
class FactorSum {
 public:
  double square = 0.0;  // what the blocks' polynomials leave: a residual that no parameter moves

  FactorSum(const double* x, int branches, bool jacobian)
      : x_(x),
        branches_(branches),
        jacobian_(jacobian),
        factor_(VoltageSweep::Columns(branches) + 1) {}

  [[nodiscard]] Eigen::MatrixXd Result() {
    const Eigen::Index last = VoltageSweep::Columns(branches_);
    if (!jacobian_) {
      Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(last + 1, last + 1);
      factor(last, last) = std::sqrt(sum_of_squares_ + square);
      return factor;
    }
    double* row = factor_.NextRow();
    for (Eigen::Index j = 0; j < last; ++j) row[j * factor_.stride()] = 0.0;
    row[last * factor_.stride()] = std::sqrt(square);
    factor_.Push();
    return factor_.Factor();
  }

  void Add(double weight, const CellRow& row) {
    const double residual = row.Residual(x_);  // (4.61)
    if (!jacobian_) {
      sum_of_squares_ += weight * residual * residual;
      return;
    }
    // d(residual)/d(parameter) = -d(voltage)/d(parameter): beta, r_s, r_j, tau_j.
    const double root = std::sqrt(weight);
    double* out = factor_.NextRow();
    const auto stride = factor_.stride();
    for (int j = 0; j <= branches_; ++j) out[(1 + j) * stride] = 0.0;
    for (int e = 0; e < row.entries; ++e) out[(1 + row.index[e]) * stride] = -root * row.value[e];
    out[0] = -root * row.slope[0];
    for (int j = 0; j < branches_; ++j)
      out[(2 + branches_ + j) * stride] = -root * row.slope[1 + j];
    out[(2 + 2 * branches_) * stride] = root * residual;
    factor_.Push();
  }

 private:
  const double* x_;
  int branches_;
  bool jacobian_;
  RowFactor factor_;
  double sum_of_squares_ = 0.0;
};

// Adds up the sums of a fit. What the blocks' polynomials leave no parameter moves.
template <class Sum, class Add>
class SumVisitor {
 public:
  SumVisitor(double weight, const Sum& zero, Add add)
      : weight_(weight), add_(std::move(add)), sum_(zero) {}

  void Row(std::size_t, double, const CellRow& row) { add_(sum_, weight_, row); }
  void Begin(const CondensedPiece& piece, const BlockShape&) {
    sum_.square += weight_ * piece.remainder;
  }
  void Node(
      const CondensedPiece&, const BlockShape& shape, Eigen::Index j, double, const CellRow& row) {
    add_(sum_, weight_ * shape.weight[j], row);
  }
  void End(const CondensedPiece&, const BlockShape&) {}
  [[nodiscard]] Sum& sum() { return sum_; }

 private:
  double weight_;
  Add add_;
  Sum sum_;
};

// Compares every row with its prediction.
class ErrorVisitor {
 public:
  ErrorVisitor(const double* x,
               const OpenCircuitVoltage& curve,
               const CondensedLog& log,
               ErrorAccumulator& errors)
      : x_(x), curve_(curve), record_(log.record()), log_(log), errors_(errors) {}

  void Row(std::size_t k, double soc, const CellRow& row) {
    const double measured_V = record_.voltage_V[k];
    errors_.Add(measured_V, measured_V - row.Residual(x_));
    if (!curve_.InRange(soc)) ++outside_;
  }
  void Begin(const CondensedPiece&, const BlockShape& shape) { nodes_V_.resize(shape.nodes()); }
  void Node(const CondensedPiece& piece,
            const BlockShape&,
            Eigen::Index j,
            double soc,
            const CellRow& row) {
    nodes_V_[j] = log_.node_voltage_V(piece)[j] - row.Residual(x_);
    if (j == 0 && !curve_.InRange(soc)) outside_ += piece.rows;
  }
  // The voltage is a polynomial, known by its values at the nodes.
  void End(const CondensedPiece& piece, const BlockShape& shape) {
    rows_V_.noalias() = shape.to_rows * nodes_V_;
    const double* measured_V = record_.voltage_V.data() + piece.first;
    for (std::size_t k = 0; k < piece.rows; ++k)
      errors_.Add(measured_V[k], rows_V_[static_cast<Eigen::Index>(k)]);
  }

  [[nodiscard]] std::size_t outside() const { return outside_; }

 private:
  const double* x_;
  const OpenCircuitVoltage& curve_;
  const Record& record_;
  const CondensedLog& log_;
  ErrorAccumulator& errors_;
  Eigen::VectorXd nodes_V_;
  Eigen::VectorXd rows_V_;
  std::size_t outside_ = 0;
};

// Gathers means of rows for VoltageSweep::Means().
class MeansVisitor {
 public:
  MeansVisitor(const Eigen::VectorXd& x, int rates, const CondensedLog& log, bool each_row)
      : x_(x.data()),
        record_(log.record()),
        growth_(each_row ? 0.0 : kGrowth),
        rates_(rates),
        columns_(rates + x.size()) {
    tolerance_A_ = kSameCurrent * LargestMagnitude(record_.current_A);
  }

  void Row(std::size_t k, double, const CellRow& row) {
    const double time_s = record_.time_s[k];
    Begin(time_s, time_s, record_.current_A[k]);
    Add(row, 1.0);
    time_sum_ += time_s - first_s_;
  }
  void Begin(const CondensedPiece& piece, const BlockShape&) {
    before_s_ = piece.first > 0 ? record_.time_s[piece.first - 1] : record_.time_s[0];
    Begin(before_s_, before_s_ + piece.duration_s, piece.current_A);
  }
  // The quadrature of the block: sums over its rows are sums over its nodes.
  void Node(
      const CondensedPiece&, const BlockShape& shape, Eigen::Index j, double, const CellRow& row) {
    Add(row, shape.weight[j]);
  }
  void End(const CondensedPiece& piece, const BlockShape& shape) {
    time_sum_ +=
        (before_s_ - first_s_) * static_cast<double>(piece.rows) + shape.weight.dot(shape.node_s);
  }

  // At most so many, if need be over steps of the current.
  [[nodiscard]] FittedRows Result(double weight, std::size_t most) {
    Close();
    bool within_phases = true;
    while (means_.size() > std::max<std::size_t>(most, 2)) {
      const std::size_t before = means_.size();
      Join(within_phases);
      within_phases = within_phases && means_.size() < before;
    }
    FittedRows rows;
    const auto n = static_cast<Eigen::Index>(means_.size());
    rows.residual_V.resize(n);
    rows.averaged.resize(n);
    rows.sensitivity.resize(n, columns_);
    for (Eigen::Index k = 0; k < n; ++k) {
      const Mean& mean = means_[static_cast<std::size_t>(k)];
      rows.time_s.push_back(mean.time_s);
      rows.averaged[k] = mean.rows;
      rows.residual_V[k] = mean.sum[columns_] / mean.rows;
      rows.sensitivity.row(k) = mean.sum.head(columns_).transpose() / mean.rows;
    }
    rows.weight = weight * rows.averaged;
    return rows;
  }

 private:
  // A mean is so much shorter than the time since the current changed: what a mode does in it is
  // a line, to a part in a thousand of its amplitude.
  static constexpr double kGrowth = 0.05;
  // Currents that differ by less, of the largest, are the same phase.
  static constexpr double kSameCurrent = 0.01;

  struct Mean {
    double time_s = 0.0;
    double rows = 0.0;
    std::size_t phase = 0;
    Eigen::VectorXd sum;  // of sensitivities and residual
  };

  // The next point spans these times.
  void Begin(double from_s, double to_s, double current_A) {
    const bool changed = phase_ == 0 || std::abs(current_A - phase_A_) > tolerance_A_;
    if (changed || to_s - first_s_ > growth_ * (to_s - phase_start_s_)) Close();
    if (changed) {
      ++phase_;
      phase_A_ = current_A;
      phase_start_s_ = from_s;
    }
    if (open_.rows == 0.0) first_s_ = from_s;
  }

  void Add(const CellRow& row, double rows) {
    if (open_.rows == 0.0) open_.sum.setZero(columns_ + 1);
    Eigen::VectorXd& sum = open_.sum;
    for (int j = 0; j < rates_; ++j) sum[j] += rows * row.slope[j];
    for (int e = 0; e < row.entries; ++e) sum[rates_ + row.index[e]] += rows * row.value[e];
    sum[columns_] += rows * row.Residual(x_);  // (4.61)
    open_.rows += rows;
  }

  void Close() {
    if (open_.rows == 0.0) return;
    open_.time_s = first_s_ + time_sum_ / open_.rows;
    open_.phase = phase_;
    means_.push_back(std::move(open_));
    open_ = {};
    time_sum_ = 0.0;
  }

  // Joins neighbours two by two, those of one phase only or all.
  void Join(bool within_phases) {
    std::vector<Mean> joined;
    for (std::size_t k = 0; k < means_.size(); ++k) {
      Mean& mean = means_[k];
      if (k + 1 < means_.size() && (!within_phases || means_[k + 1].phase == mean.phase)) {
        const Mean& next = means_[++k];
        mean.time_s = (mean.rows * mean.time_s + next.rows * next.time_s) / (mean.rows + next.rows);
        mean.rows += next.rows;
        mean.sum += next.sum;
        mean.phase = next.phase;
      }
      joined.push_back(std::move(mean));
    }
    means_ = std::move(joined);
  }

  const double* x_;
  const Record& record_;
  double growth_;
  int rates_;
  Eigen::Index columns_;
  double tolerance_A_ = 0.0;
  std::size_t phase_ = 0;
  double phase_A_ = 0.0;
  double phase_start_s_ = 0.0;
  double first_s_ = 0.0;
  double before_s_ = 0.0;  // the open block
  double time_sum_ = 0.0;  // since first_s_
  Mean open_;
  std::vector<Mean> means_;
};

}  // namespace

JointSolution SolutionOf(const SweepParameters& p) {
  Require(p.resistance_Ohm.size() == p.time_constant_s.size(),
          "as many resistances as time constants");
  JointSolution solution;
  solution.structure.branches = static_cast<int>(p.time_constant_s.size());
  solution.rates = {.beta_per_sqrt_s = p.beta_per_sqrt_s, .time_constant_s = p.time_constant_s};
  solution.x.resize(1 + solution.structure.branches);
  solution.x[0] = p.series_resistance_Ohm;
  for (int j = 0; j < solution.structure.branches; ++j) solution.x[1 + j] = p.resistance_Ohm[j];
  solution.active.assign(static_cast<std::size_t>(solution.x.size()), 0);
  solution.follows.assign(p.time_constant_s.size(), 0);
  return solution;
}

SweepParameters ParametersOf(const JointSolution& solution) {
  SweepParameters p;
  const double beta = solution.rates.beta_per_sqrt_s;
  p.beta_per_sqrt_s = std::isinf(beta) ? 0.0 : beta;  // no diffusion
  p.series_resistance_Ohm = solution.x[0];
  p.resistance_Ohm.assign(solution.x.begin() + 1, solution.x.end());
  p.time_constant_s = solution.rates.time_constant_s;
  return p;
}

VoltageSweep::VoltageSweep(JointSetup setup, std::vector<SweepLog> logs, const Condensation& how)
    : setup_(std::move(setup)), logs_(std::move(logs)), how_(how) {
  Require(setup_.alpha_C > 0.0, "alpha_C > 0", {{"alpha_C", setup_.alpha_C}});
  if (!setup_.diffusion) {
    setup_.terms = 0;
    setup_.tail = false;
  }
  auto condensed = std::make_shared<std::vector<CondensedLog>>();
  for (const SweepLog& log : logs_) {
    Require(log.record != nullptr, "a record");
    condensed->emplace_back(*log.record, how);
    scales_.weight_sum += log.weight * static_cast<double>(log.record->size());
    scales_.largest_A = std::max(scales_.largest_A, LargestMagnitude(log.record->current_A));
  }
  condensed_ = std::move(condensed);
}

VoltageSweep VoltageSweep::With(JointSetup setup) const {
  VoltageSweep other = *this;
  other.setup_ = std::move(setup);
  return other;
}

VoltageSweep VoltageSweep::With(OpenCircuitVoltage curve) const {
  JointSetup setup = setup_;
  setup.open_circuit_voltage = std::move(curve);
  return With(std::move(setup));
}

std::size_t VoltageSweep::rows() const {
  std::size_t sum = 0;
  for (const SweepLog& log : logs_) sum += log.record->size();
  return sum;
}

std::size_t VoltageSweep::points() const {
  std::size_t sum = 0;
  for (const CondensedLog& log : *condensed_) sum += log.points();
  return sum;
}

template <class Visitor>
void VoltageSweep::Sweep(std::size_t log,
                         const JointStructure& structure,
                         const JointRates& rates,
                         const Eigen::VectorXd* x,
                         Visitor& visitor) const {
  LogSweep sweep(
      setup_, (*condensed_)[log], logs_[log].initial_soc, structure, rates, x, !how_.coarse);
  sweep.Run(visitor);
}

template <class Sum, class Add>
Sum VoltageSweep::SumOverLogs(const JointStructure& structure,
                              const JointRates& rates,
                              const Eigen::VectorXd* x,
                              const Sum& zero,
                              Add add) const {
  std::vector<Sum> sums(logs_.size(), zero);
  StopIfAsked();
  ParallelFor(logs_.size(), [&](std::size_t k) {
    SumVisitor<Sum, Add> visitor(logs_[k].weight, zero, add);
    Sweep(k, structure, rates, x, visitor);
    sums[k] = std::move(visitor.sum());
  });
  // In the order of the logs, whatever the threads did.
  for (std::size_t k = 1; k < sums.size(); ++k) sums[0].Add(sums[k]);
  return sums.empty() ? zero : std::move(sums[0]);
}

Eigen::MatrixXd VoltageSweep::Factor(const SweepParameters& parameters, bool jacobian) const {
  const auto branches = static_cast<int>(parameters.time_constant_s.size());
  const int columns = Columns(branches) + 1;
  std::vector<Eigen::MatrixXd> factors(logs_.size());
  const JointSolution at = SolutionOf(parameters);
  StopIfAsked();
  ParallelFor(logs_.size(), [&](std::size_t k) {
    const auto add = [](FactorSum& sum, double w, const CellRow& row) { sum.Add(w, row); };
    const FactorSum zero(at.x.data(), branches, jacobian);
    SumVisitor visitor(logs_[k].weight, zero, add);
    Sweep(k, at.structure, at.rates, jacobian ? &at.x : nullptr, visitor);
    factors[k] = visitor.sum().Result();
  });
  if (factors.size() == 1) return factors[0];
  // Joined in the order of the logs, whatever the threads did.
  RowFactor all(columns);
  for (const auto& factor : factors) {
    for (Eigen::Index row = 0; row < factor.rows(); ++row) {
      double* next = all.NextRow();
      for (Eigen::Index j = 0; j < columns; ++j) next[j * all.stride()] = factor(row, j);
      all.Push();
    }
  }
  Eigen::MatrixXd factor = all.Factor();
  if (!jacobian)
    factor(columns - 1, columns - 1) = std::abs(factor(columns - 1, columns - 1));  // a norm
  return factor;
}

SweepErrors VoltageSweep::Errors(const SweepParameters& parameters) const {
  Require(!how_.coarse, "a sweep that is not coarse");
  SweepErrors result;
  ErrorAccumulator errors;
  const JointSolution at = SolutionOf(parameters);
  for (std::size_t k = 0; k < logs_.size(); ++k) {
    ErrorVisitor visitor(at.x.data(), setup_.open_circuit_voltage, (*condensed_)[k], errors);
    Sweep(k, at.structure, at.rates, nullptr, visitor);
    result.rows_outside_curve += visitor.outside();
  }
  result.metrics = errors.Result();
  return result;
}

std::vector<FittedRows> VoltageSweep::Means(const JointStructure& structure,
                                            const JointRates& rates,
                                            const Eigen::VectorXd& x,
                                            std::size_t most) const {
  Require(!how_.coarse, "a sweep that is not coarse");
  std::vector<FittedRows> means(logs_.size());
  const std::size_t all = rows();
  StopIfAsked();
  ParallelFor(logs_.size(), [&](std::size_t k) {
    const CondensedLog& log = (*condensed_)[k];
    MeansVisitor visitor(x, RateSlots(structure).size(), log, all <= most);
    Sweep(k, structure, rates, &x, visitor);
    const double share = static_cast<double>(log.record().size()) / static_cast<double>(all);
    means[k] = visitor.Result(logs_[k].weight,
                              static_cast<std::size_t>(share * static_cast<double>(most)));
  });
  return means;
}

class VoltageSweep::RowsAtBeta : public Observations::AtBeta {
 public:
  explicit RowsAtBeta(const VoltageSweep& sweep) : sweep_(sweep) {}

  [[nodiscard]] NormalEquations Sum(const JointStructure& structure,
                                    const JointRates& rates) const override {
    const NormalEquations zero(JointLayout(structure).size());
    return sweep_.SumOverLogs(
        structure, rates, nullptr, zero, [](auto& sum, double w, const CellRow& row) {
          sum.Add(w, row);
        });
  }
  [[nodiscard]] SlopeSums Slopes(const JointStructure& structure,
                                 const JointRates& rates,
                                 const Eigen::VectorXd& x) const override {
    const SlopeSums zero(RateSlots(structure).size(), x.size());
    return sweep_.SumOverLogs(
        structure, rates, &x, zero, [&x](auto& sum, double w, const CellRow& row) {
          sum.Add(w, row, x.data());
        });
  }

 private:
  const VoltageSweep& sweep_;
};

std::unique_ptr<Observations::AtBeta> VoltageSweep::At(const JointRates&, bool) const {
  return std::make_unique<RowsAtBeta>(*this);
}

}  // namespace lipoid
