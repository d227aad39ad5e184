#pragma once

/// @file
/// What every export is asked and what it answers. A target is another program's battery: its law
/// may be the cell's own (exact), a poorer one whose free numbers were fitted so that it follows
/// the cell over a mission (projected), or a table (data). Each target has a file in model/export,
/// or in identify/export where its numbers are fitted; the registry of all of them is
/// identify/export/targets.h.

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/battery/cell.h"
#include "model/battery/record_stepper.h"
#include "model/core/option_kinds.h"
#include "model/core/options.h"

namespace lipoid {

/// The current that a target and the cell are compared under.
struct ExportMission {
  std::string name;               ///< "default", or the file
  std::vector<double> time_s;     ///< strictly increasing
  std::vector<double> current_A;  ///< of the whole pack, discharge positive
  Hold hold = Hold::kBackward;
  double initial_soc = 1.0;
  /// Of a cell that knows temperature, as it was measured in each row; empty: it starts at its reference
  /// temperature and warms by itself.
  std::vector<double> temperature_degC = {};

  /// The current over the interval that ends with row k > 0.
  [[nodiscard]] double FlowBefore_A(std::size_t k) const {
    return current_A[hold == Hold::kBackward ? k : k - 1];
  }
};

enum class ExportPrecision { kDouble, kSingle };

constexpr std::array<std::pair<ExportPrecision, std::string_view>, 2> OptionNames(ExportPrecision) {
  return {{{ExportPrecision::kDouble, "double"}, {ExportPrecision::kSingle, "single"}}};
}

struct ExportRequest {
  Cell cell;  ///< its series and parallel are those of the pack to export
  /// The cell with what no target holds (SetCell in identify/export/law_limits.h); none: the same.
  std::optional<Cell> whole = {};
  std::vector<std::string> left_out = {};  ///< sentences on that
  [[nodiscard]] const Cell& Whole() const { return whole ? *whole : cell; }
  std::string source;  ///< the cell file or the name of a shipped cell, as typed
  std::string sha256;  ///< of the cell file's bytes
  ExportMission mission;
  std::string target_version;  ///< one of the target's; empty: its default
  std::string name;            ///< identifier for the target's file, [A-Za-z_][A-Za-z0-9_]*
  std::string stem = {};       ///< of -o, for files that name one another; empty: the identifier's
  int branches = 2;            ///< pairs of resistor and capacitor, where the target has any
  ExportPrecision precision =
      ExportPrecision::kDouble;  ///< of numbers, where the target can be either
  std::string into_file;         ///< the file that is merged into, for messages; empty: none
  std::string into_text;         ///< its bytes

  /// The options of `lipoid export` and the keywords of lipoid.export().
  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("target_version",
      self.target_version,
      Word{"VERSION"},
      "version of the program that reads the file, where names differ: `lipoid list targets`");
    v("branches",
      self.branches,
      Range{1, 2},
      "number of pairs of resistor and capacitor, for targets that can have more than one");
    v("precision",
      self.precision,
      Names(),
      "precision of the numbers, for targets that can be either");
  }
};

struct ExportedParameter {
  std::string name;  ///< as the target calls it
  double value = 0.0;
  std::string unit;
};

/// How far the target's own law is from the cell over the mission, current imposed, in volts of the
/// whole pack.
struct ExportError {
  double rmse_V = 0.0;
  double max_error_V = 0.0;
  double worst_s = 0.0;            ///< the time of the largest error
  double worst_soc = 0.0;          ///< the cell's state of charge there
  std::vector<double> law_V = {};  ///< what the law gives in each row of the mission
};

/// How far the target's own state of charge, a fraction, is from the cell's over the mission.
struct ExportChargeError {
  double rms = 0.0;
  double max_error = 0.0;
  double worst_s = 0.0;  ///< the time of the largest error
  /// Where the target ends its life at an empty battery: how much longer it lasts than the cell,
  /// by state of charge, under the mission's mean current; negative: shorter.
  std::optional<double> lifetime_percent;
};

struct ExportFile {
  std::string
      suffix;  ///< ".parm": stands beside the first file, with its stem; the first is -o itself
  std::string content;  ///< bytes
};

struct Exported {
  std::vector<ExportedParameter> parameters;
  std::optional<ExportError> error;  ///< none where the target has no voltage
  std::optional<ExportError>
      naive;  ///< what a user's own numbers would give; none for exact targets
  std::vector<std::string> cannot_hold;  ///< sentences: what the target's law leaves out
  std::vector<std::string> notes;  ///< sentences: assumptions and traps for who loads the file
  std::vector<ExportFile> files;   ///< the first one is the one that -o names
  std::optional<ExportChargeError> charge_error;  ///< where the target's own count is shown or used
  std::optional<ExportChargeError> naive_charge_error;
};

}  // namespace lipoid
