#pragma once

/// @file
/// Walks a cell along the rows of a log, whatever their sampling.
///
///   backward   the current of row k flowed over (t[k-1], t[k]], as cyclers log;
///              row 0 moves no charge
///   forward    the current of row k flows until row k+1, the thesis' (4.46)
///
/// The state after row k is that at t[k]; the voltage of row k is the one at t[k] with the current
/// of row k. Rows may come in any number of pieces: the stepper remembers the last one.
///
/// A step of the cell takes r_j at its beginning. Where r_j is a table and one row takes more than a twentieth of the
/// charge, as in a log that has rows where the current changes alone, it is walked in parts; not so that of a cell
/// that knows temperature, whose fit takes such rows in one step. That step is taken at the temperature half-way between
/// the rows, measured or predicted: from one to the next the cell may warm by a kelvin and more. Tests:
/// tests/model/battery/record_stepper_test.cc.

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "model/battery/cell_model.h"
#include "model/core/errors.h"

namespace lipoid {

enum class Hold { kBackward, kForward };

constexpr std::array<std::pair<Hold, std::string_view>, 2> OptionNames(Hold) {
  return {{{Hold::kBackward, "backward"}, {Hold::kForward, "forward"}}};
}

/// Remembers what was computed for an interval length. Time stamps are rounded, so that "every 10
/// ms" comes as many neighbouring doubles: lengths that agree within the rounding of the stamps
/// share one value.
template <class Value>
class IntervalCache {
 public:
  /// The value for dt_s at time_s; make(dt_s, value) fills it when it is new.
  template <class Make>
  Value& Get(double dt_s, double time_s, Make&& make) {
    const double tolerance = 4.0 * std::numeric_limits<double>::epsilon() * std::abs(time_s);
    if (std::abs(dt_s - last_->dt_s) <= tolerance) return last_->value;
    // Neighbouring lengths fall into one slot, or at worst into two.
    const auto key =
        static_cast<std::uint64_t>(static_cast<std::int64_t>(std::min(dt_s, 4e9) * 0x1p30));
    last_ = &slots_[((key + 1) * 0x9E3779B97F4A7C15ULL) >> (64 - kBits)];
    if (!(std::abs(dt_s - last_->dt_s) <= tolerance)) {
      make(dt_s, last_->value);
      last_->dt_s = dt_s;
    }
    return last_->value;
  }

  IntervalCache() : slots_(std::size_t{1} << kBits), last_(&slots_[0]) {}
  IntervalCache(const IntervalCache&) = delete;
  IntervalCache& operator=(const IntervalCache&) = delete;

 private:
  static constexpr int kBits = 8;
  struct Slot {
    double dt_s = std::numeric_limits<double>::quiet_NaN();
    Value value{};
  };
  std::vector<Slot> slots_;
  Slot* last_;
};

template <class T>
class RecordStepper {
 public:
  using State = typename CellModel<T>::State;

  RecordStepper(const CellModel<T>& model, Hold hold, State initial)
      : model_(model), hold_(hold), state_(std::move(initial)) {
    const CellParameters<T>& cell = model.parameters();
    bool changes = false;
    for (const auto& branch : cell.branches)
      changes = changes || (!cell.temperature && !branch.resistance_Ohm.constant());
    if (changes && ScalarPart(cell.alpha_C) > 0.0)
      longest_step_C_ = kLongestStep * ScalarPart(cell.alpha_C);
  }

  /// Moves to the next row; time_s must exceed that of the row before.
  void Row(double time_s, const T& current_A) {
    if (started_) {
      const double dt_s = time_s - time_s_;
      if (!(dt_s > 0.0)) {  // asked first: the row is a hot path
        Require(false, "time strictly increasing", {{"time_s", time_s}, {"before", time_s_}});
      }
      const T& flowed_A = hold_ == Hold::kBackward ? current_A : current_A_;
      if (std::abs(ScalarPart(flowed_A)) * dt_s > longest_step_C_) {
        WalkInParts(flowed_A, dt_s);
      } else if (model_.parameters().temperature) {  // hardly any two rows share it
        model_.AdvanceWarming(state_, flowed_A, dt_s, of_row_, scratch_);
      } else {
        auto& step = cache_.Get(dt_s, time_s, [this](double dt, typename CellModel<T>::Step& made) {
          model_.MakeStep(dt, made);
        });
        step.dt_s = dt_s;  // the charge is counted with the stamps themselves
        model_.Advance(state_, flowed_A, step);
      }
    }
    started_ = true;
    time_s_ = time_s;
    current_A_ = current_A;
  }
  /// The same where the temperature of the cell was measured at the row, and at the one before.
  void Row(double time_s, const T& current_A, const T& temperature_K) {
    if (started_) state_.temperature_K = 0.5 * (state_.temperature_K + temperature_K);
    Row(time_s, current_A);
    state_.temperature_K = temperature_K;
  }

  /// The current that flows from the row last moved to, where it is not that of the row (hold forward).
  void SetFlowing(const T& current_A) { current_A_ = current_A; }

  [[nodiscard]] const State& state() const { return state_; }
  [[nodiscard]] T Soc() const { return model_.Soc(state_, current_A_); }
  [[nodiscard]] T OpenCircuit() const { return model_.OpenCircuit(state_, current_A_); }
  [[nodiscard]] T Voltage() const { return model_.Voltage(state_, current_A_); }
  /// The same where Soc() is known already.
  [[nodiscard]] T Voltage(const T& soc) const { return model_.Voltage(state_, soc, current_A_); }

 private:
  static constexpr double kLongestStep = 0.05;  // of the charge
  // As many of any row: with fewer of a shorter one slopes would not be those of the voltage.
  static constexpr int kParts = 100;

  void WalkInParts(const T& flowed_A, double dt_s) {
    model_.Prepare(of_row_, dt_s / kParts, state_);
    for (int part = 0; part < kParts; ++part) model_.Advance(state_, flowed_A, of_row_);
  }

  const CellModel<T>& model_;
  Hold hold_;
  State state_;
  IntervalCache<typename CellModel<T>::Step> cache_;
  typename CellModel<T>::Step of_row_;
  State scratch_;
  bool started_ = false;
  double time_s_ = 0.0;
  T current_A_ = T(0.0);
  double longest_step_C_ = std::numeric_limits<double>::infinity();
};

}  // namespace lipoid
