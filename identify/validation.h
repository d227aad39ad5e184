#pragma once

/// @file
/// A cell against a measured log: how far the predicted voltage is off, over all rows and over
/// those above 10 % state of charge (below, the steep end of v_oc(A) makes any error of charge
/// large). Tests: tests/identify/validation_test.cc.

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "identify/logs/load_campaign.h"
#include "identify/logs/record.h"
#include "identify/trust/edges.h"
#include "model/battery/cell.h"
#include "model/battery/error_metrics.h"
#include "model/battery/prediction.h"

namespace lipoid {

/// How the cell predicts a log.
struct LogErrors {
  std::string file;
  ErrorMetrics all;
  ErrorMetrics above_10_soc;  ///< rows with A > 0.1 only
  std::size_t rows_outside_curve = 0;
  /// Of the cell's temperature, predicted where it was measured too; NaN where it was not both.
  double temperature_rmse_K = std::numeric_limits<double>::quiet_NaN();
  std::vector<Edge> edges = {};  ///< of the pack
};

/// Compares a cell with the rows of a log, which may come in blocks.
class Validation {
 public:
  /// The cell must outlive this; it starts relaxed at initial_soc.
  Validation(const Cell& cell, Hold hold, double initial_soc)
      : cell_(cell), predictor_(cell, hold, initial_soc) {}

  /// Rows of the pack that the cell's series and parallel make; what the surroundings measured is of
  /// these rows.
  void Add(const Record& rows, const Surroundings& surroundings);
  /// Over all rows; without the name of the log.
  [[nodiscard]] LogErrors Result() const;

 private:
  const Cell& cell_;
  RowPredictor predictor_;
  ErrorAccumulator all_;
  ErrorAccumulator above_;
  EdgeFinder edges_;
  std::size_t rows_ = 0;
  std::size_t outside_ = 0;
  bool warms_ = false;
  double squares_K2_ = 0.0;
};

/// The record is that of the pack the cell's series and parallel make; it starts relaxed at
/// initial_soc.
[[nodiscard]] LogErrors Validate(const Cell& cell,
                                 const Record& record,
                                 double initial_soc = 1.0,
                                 const Surroundings& surroundings = {});

/// What a record and what is told of it say of the temperature: the measured one where there is a
/// column, else the ambient.
[[nodiscard]] Surroundings SurroundingsOf(const Record& record, const CampaignLog& entry);

/// The same of a log of a campaign, which is that of one cell, with the name and the start that the
/// campaign gives it.
[[nodiscard]] LogErrors Validate(const Cell& cell, const LoadedLog& log);

/// A log whose start is doubted.
struct StartDoubt {
  std::string file;
  double rest_V = 0.0;
  double soc = 0.0;     ///< of the cell at that voltage; infinite: far above that of a full cell
  double given = 1.0;   ///< the initial_soc
  double full_V = 0.0;  ///< of the full cell
  std::string equal_file =
      {};  ///< a log that rests at the same voltage before its first load, of another start
  double equal_given = 0.0;  ///< its initial_soc
};

/// The voltage at which a record of one cell rests before its first load; none of one that begins under load.
[[nodiscard]] std::optional<double> RestBeforeLoad(const Record& record);

/// A log that begins with a rest shows where it starts. Doubted where the cell rests with that voltage at another
/// state of charge than `initial_soc`, as a prediction begins (rest_voltage.h): none where it agrees within 0.03 of
/// the charge or 20 mV, or cannot be seen. The record is that of one cell.
[[nodiscard]] std::optional<StartDoubt> DoubtOfStart(const Cell& one,
                                                     const Record& record,
                                                     double initial_soc,
                                                     const Surroundings& surroundings = {});

/// Of a log that begins under load, whose first voltage is not one that this cell has under it at
/// `initial_soc`, as a sentence; empty where there is nothing to say.
[[nodiscard]] std::string DoubtAboutLoadedStart(const Cell& one,
                                                const Record& record,
                                                double initial_soc);

/// Either of the two, of a pack and its own record, as a sentence; "" without a voltage.
[[nodiscard]] std::string DoubtAboutStart(const Cell& pack,
                                          const Record& record,
                                          double initial_soc);

/// One sentence of all: the log that is furthest off with what to do, then the others by name, and
/// `of_others`, what to do of them; "" of none.
[[nodiscard]] std::string DoubtsAboutStarts(std::vector<StartDoubt> doubts,
                                            std::string_view of_others);

}  // namespace lipoid
