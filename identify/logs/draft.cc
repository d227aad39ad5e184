#include "identify/logs/draft.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>
#include <map>
#include <sstream>
#include <system_error>
#include <utility>

#include "identify/logs/plausibility.h"
#include "identify/logs/unlike_discharges.h"
#include "model/battery/typical_temperature.h"
#include "model/core/foreign_text.h"
#include "model/core/run_record.h"
#include "model/core/significant_digits.h"
#include "model/core/special_values.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

namespace fs = std::filesystem;

// Cut-offs are round numbers.
constexpr double kCutoffStep_V = 0.05;
// Rates closer than this are the same test twice.
constexpr double kSameRate = 0.1;

// Below the highest voltage at rest before a load by more than this, a log does not start full.
constexpr double kSameStart_V = 0.04;
// A full lithium cell rests above the first, or, if it is of iron phosphate, below the second.
constexpr double kFullRest_V = 3.9;
constexpr double kIronPhosphateRest_V = 3.45;
// A draft takes no cut-off below the first, and writes the second in its place.
constexpr double kLowestCutoff_V = 1.5;
constexpr double kTypicalCutoff_V = 3.0;
// A discharge from full to empty that is faster is a piece of one.
constexpr double kFastestRate_per_h = 100.0;
// From full to empty every cell falls by more, iron phosphate down to 3 V included.
constexpr double kLeastFall_V = 0.2;

// What is no positive number is written as 0.
double PositiveToDigits(double value, int digits) {
  return value > 0.0 && std::isnormal(value) ? RoundToDigits(value, digits) : 0.0;
}

// Text that stays within its comment, whatever the name of a file is.
std::string Comment(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  }
  return "# " + text + "\n";
}

struct Candidate {
  const Inspection* inspection = nullptr;
  CampaignDraft::Entry* entry = nullptr;
};

// A cycler stops at the cut-off within one row: the roundest voltage that lies in the last fall of every discharge.
// 0 where none does: one was stopped before.
double CutoffWithinLastRows(const std::vector<Candidate>& discharges) {
  constexpr double kOfFewRows_V = 0.1;  // where the last fall is not measured
  constexpr double kMostFall_V = 0.2;   // that is one of a discharge
  double low_V = 0.0;
  double high_V = kInfinity;
  for (const Candidate& each : discharges) {
    const Discharge& d = *each.inspection->discharge;
    low_V = std::max(low_V, d.end_voltage_V - d.nearness_V());
    const double fall_V = d.last_fall_V > 0.0 ? std::min(d.last_fall_V, kMostFall_V) : kOfFewRows_V;
    high_V = std::min(high_V, d.end_voltage_V + fall_V + d.nearness_V());
  }
  for (const double step_V : {0.1, kCutoffStep_V, 0.01}) {
    const double round_V = PositiveToDigits(std::ceil(low_V / step_V) * step_V, 3);
    if (round_V <= high_V) return round_V;
  }
  return 0.0;
}

// The voltage at which the discharges end, or most of them: a round one where they allow it.
double FindCutoff(const std::vector<Candidate>& discharges) {
  if (const double within_V = CutoffWithinLastRows(discharges); within_V > 0.0) return within_V;
  std::vector<double> ends_V;
  ends_V.reserve(discharges.size());
  for (const Candidate& each : discharges)
    ends_V.push_back(each.inspection->discharge->end_voltage_V);
  const double middle_V = UpperMedian(std::move(ends_V));
  const double round_V = PositiveToDigits(std::round(middle_V / kCutoffStep_V) * kCutoffStep_V, 3);
  const double fine_V = PositiveToDigits(std::ceil(middle_V * 1000.0) / 1000.0, 4);
  return std::abs(round_V - middle_V) <= 2.0 * kCutoffTolerance_V ? round_V : fine_V;
}

constexpr double kSameCharge = 0.02;  // of two slow discharges of one cell
// A slow discharge gives more than a fast one, unless it is colder or did not start full.
constexpr double kLessThanFull = 0.1;
constexpr double kSameEdge = 0.01;  // what three digits show for certain

// Whether `a` tells more about the open-circuit voltage than `b`.
bool BetterLowRate(const Candidate& a, const Candidate& b) {
  const double slower = a.inspection->discharge->current_A / b.inspection->discharge->current_A;
  if (slower < 1.0 - kSameRate) return true;
  if (slower > 1.0 / (1.0 - kSameRate)) return false;
  // The one that shows more of the charge.
  const double more = a.inspection->discharge->charge_C / b.inspection->discharge->charge_C;
  if (more > 1.0 + kSameCharge || more < 1.0 - kSameCharge) return more > 1.0;
  const double resistance_a = a.inspection->edge_resistance_Ohm;
  const double resistance_b = b.inspection->edge_resistance_Ohm;
  return resistance_a < resistance_b || (std::isnan(resistance_b) && !std::isnan(resistance_a));
}

}  // namespace

std::vector<std::string> EndingsOfNoLogs() {
  return {".cff", ".json", ".md", ".pdf", ".png", ".py", ".tmp", ".toml", ".yaml"};
}

std::vector<std::string> FilesOfFolder(const std::string& folder) {
  const auto no_logs = EndingsOfNoLogs();
  std::vector<std::string> files;
  std::vector<std::string> folders;
  std::error_code trouble;
  for (fs::directory_iterator each(folder, trouble), end; !trouble && each != end;
       each.increment(trouble)) {
    const std::string name = each->path().filename().string();
    const std::string extension = each->path().extension().string();
    const bool no_log = std::find(no_logs.begin(), no_logs.end(), extension) != no_logs.end();
    std::error_code none;
    if (name[0] == '.') continue;
    if (each->is_directory(none)) folders.push_back(name);
    if (each->is_regular_file(none) && !no_log) files.push_back(each->path().string());
  }
  if (trouble)
    throw LoadError(NoFile(folder),
                    fmt::format("expected a folder of logs, found {}", trouble.message()));
  if (files.empty()) {
    std::sort(folders.begin(), folders.end());
    const std::string found =
        folders.empty() ? "none in it"
                        : fmt::format("none in it; there are folders within, name one of them: {}",
                                      ForeignText(fmt::format("{}", fmt::join(folders, ", "))));
    throw LoadError(NoFile(folder), "expected a folder of logs, found " + found);
  }
  std::sort(files.begin(), files.end());
  return files;
}

namespace {

// The inspected tests of all files, as those of one cell.
struct Test {
  const InspectedFile* file = nullptr;
  Inspection inspection;
  int series = 1;  // by its voltage
};

void MakeOneCell(Inspection& test, int series, int parallel) {
  test.start_voltage_V /= series;
  test.edge_resistance_Ohm *= static_cast<double>(parallel) / series;
  for (auto& [share, voltage_V] : test.discharge_curve) voltage_V /= series;
  if (test.voltage_V) test.voltage_V->largest /= series;
  if (!test.discharge) return;
  test.discharge->end_voltage_V /= series;
  test.discharge->voltage_noise_V /= series;
  test.discharge->last_fall_V /= series;
  test.discharge->current_A /= parallel;
  test.discharge->charge_C /= parallel;
}

class Drafting {
 public:
  Drafting(const std::string& campaign_file, const DraftOptions& options)
      : options_(options), base_(fs::absolute(campaign_file).parent_path()) {}

  CampaignDraft Draft(const std::vector<InspectedFile>& files, const std::string& name) {
    draft_.campaign.name = name;
    CollectTests(files);
    FindPack();
    draft_.entries.reserve(tests_.size());  // candidates point into it
    for (Test& test : tests_) AddEntry(test);
    FindCapacity();
    LeaveOutWhatIsNotFromFull();
    LeaveOutWhatDoesNotEndEmpty();
    FindCutoffAndEnds();
    ChooseLowRate();
    FindStarts();
    CompareDischarges();
    for (const auto& entry : draft_.entries) {
      if (entry.left_out.empty()) draft_.campaign.logs.push_back(entry.log);
    }
    return std::move(draft_);
  }

 private:
  [[nodiscard]] std::string Relative(const std::string& file) const {
    const fs::path path =
        fs::absolute(file).lexically_normal().lexically_relative(base_.lexically_normal());
    return path.empty() ? fs::absolute(file).string() : path.generic_string();
  }

  void CollectTests(const std::vector<InspectedFile>& files) {
    SameSize by_size;
    for (const InspectedFile& file : files) {
      if (const std::string copied = CopiedFrom(file.file, by_size); !copied.empty()) {
        draft_.unused.emplace_back(Relative(file.file),
                                   fmt::format("holds the same bytes as {}", Relative(copied)));
        continue;
      }
      if (!file.inspection) {
        draft_.unused.emplace_back(Relative(file.file), file.problems.front().message);
        continue;
      }
      const int series = CellsInSeries(*file.inspection);
      if (file.inspection->parts.empty()) tests_.push_back({&file, *file.inspection, series});
      for (const Inspection& part : file.inspection->parts) tests_.push_back({&file, part, series});
    }
  }

  // Files of one size by the SHA-256 of their bytes, which of a first one is not known yet.
  struct OfOneSize {
    std::string unread;
    std::map<std::string, std::string> by_sum;
  };
  using SameSize = std::map<std::uintmax_t, OfOneSize>;

  // The file before with the same bytes; "" where there is none. Only what has one size is read, once.
  static std::string CopiedFrom(const std::string& file, SameSize& by_size) {
    std::error_code none;
    if (!fs::is_regular_file(file, none)) return "";
    const std::uintmax_t size = fs::file_size(file, none);
    if (none) return "";
    OfOneSize& others = by_size[size];
    if (others.by_sum.empty() && others.unread.empty()) {
      others.unread = file;
      return "";
    }
    if (!others.unread.empty()) {
      const std::string first = std::exchange(others.unread, "");
      others.by_sum.emplace(Sha256OfFile(first), first);
    }
    const auto [same, fresh] = others.by_sum.emplace(Sha256OfFile(file), file);
    return fresh ? "" : same->second;
  }

  // The pack that most of the tests show.
  void FindPack() {
    int& series = draft_.campaign.series;
    draft_.campaign.parallel = options_.parallel;
    if (options_.series) {
      series = *options_.series;
    } else {
      std::map<int, std::size_t> votes;
      for (const Test& test : tests_) ++votes[test.series];
      for (const auto& [cells, count] : votes) {
        if (count > votes[series]) series = cells;
      }
      if (series > 1) {
        double highest_V = 0.0;
        for (const Test& test : tests_) {
          if (test.series == series && test.inspection.voltage_V)
            highest_V = std::max(highest_V, test.inspection.voltage_V->largest);
        }
        const bool told = CellsInSeries(highest_V) != series;
        draft_.remarks.push_back(fmt::format(
            "The voltages are those of {} cells in series; say `parallel` where several stand side "
            "by side.",
            told ? fmt::format("{}", series) : CellsInSeriesInWords(highest_V)));
      }
    }
    for (Test& test : tests_) MakeOneCell(test.inspection, series, options_.parallel);
  }

  void AddEntry(const Test& test) {
    const Inspection& inspection = test.inspection;
    std::string file = Relative(test.file->file);
    if (!inspection.suggestion.kind) {
      draft_.unused.emplace_back(std::move(file), inspection.suggestion.reason);
      return;
    }
    CampaignDraft::Entry entry;
    entry.log.kind = *inspection.suggestion.kind;
    entry.log.file = std::move(file);
    entry.log.path = test.file->file;
    entry.log.read = options_.read;
    // The log that settled this one may not be in the campaign.
    if (inspection.report.current_sign_is_of_others) {
      entry.log.read.current_sign = inspection.report.current_sign;
    }
    entry.reason = inspection.suggestion.reason;
    entry.remarks = inspection.report.warnings;
    if (inspection.part) {
      entry.log.read.start_s = inspection.part_start_s;
      entry.log.read.end_s = inspection.part_end_s;
      entry.remarks.push_back(
          "One of several tests of its file: the rows between two recharges or "
          "gaps.");
      if (inspection.part->after_gap && std::isnan(inspection.start_voltage_V)) {
        entry.left_out = "begins under load after a gap, so that its state of charge is not known";
      }
    }
    if (!options_.series && test.series != draft_.campaign.series) {
      entry.left_out = fmt::format("its voltage is that of {} in series", test.series);
    }
    if (inspection.discharge) {
      const Discharge& discharge = *inspection.discharge;
      const double own_rate_per_h = 3600.0 * discharge.current_A / discharge.charge_C;
      if (entry.left_out.empty() && own_rate_per_h > kFastestRate_per_h) {
        entry.left_out =
            fmt::format("lasts {:.2g} s, in which no cell is emptied: it is a piece of a log",
                        3600.0 / own_rate_per_h);
      }
    }
    const bool takes_part = entry.left_out.empty();
    draft_.entries.push_back(std::move(entry));
    if (!takes_part) return;
    const Candidate candidate{&inspection, &draft_.entries.back()};
    all_.push_back(candidate);
    if (draft_.entries.back().log.kind == LogKind::kConstantCurrent) fast_.push_back(candidate);
    if (draft_.entries.back().log.kind == LogKind::kLowRate) slow_.push_back(candidate);
  }

  // The charge of the slowest discharge that ends empty, of those that give as much as any: a slower one
  // that gives less did not start full.
  void FindCapacity() {
    const Candidate* slowest = nullptr;
    const double most_C = MostCharge(0.0);
    for (const Candidate& each : all_) {
      if (!EndsEmpty(each)) continue;
      const Discharge& discharge = *each.inspection->discharge;
      if (discharge.charge_C < (1.0 - kSameCharge) * most_C) continue;
      if (slowest == nullptr || discharge.current_A < slowest->inspection->discharge->current_A)
        slowest = &each;
    }
    if (slowest != nullptr) {
      draft_.campaign.capacity_Ah =
          PositiveToDigits(slowest->inspection->discharge->charge_C / 3600.0, 3);
    } else if (!draft_.entries.empty()) {
      draft_.remarks.emplace_back(
          "No log discharges the cell from full to empty: look its capacity and its cut-off up and "
          "give them as capacity_Ah and cutoff_V.");
    }
  }

  static bool EndsEmpty(const Candidate& each) {
    if (!each.inspection->discharge) return false;
    const Discharge& discharge = *each.inspection->discharge;
    return discharge.end_voltage_V <= kHighestCutoff_V + discharge.nearness_V() &&
           each.inspection->voltage_V->largest - discharge.end_voltage_V >= kLeastFall_V;
  }

  // Of the discharges that end empty at more than this current.
  [[nodiscard]] double MostCharge(double above_A) const {
    double most_C = 0.0;
    for (const Candidate& each : all_) {
      if (EndsEmpty(each) && each.inspection->discharge->current_A > above_A)
        most_C = std::max(most_C, each.inspection->discharge->charge_C);
    }
    return most_C;
  }

  // v_oc(A) is read from a slow discharge as one from full to empty.
  void LeaveOutWhatIsNotFromFull() {
    for (const Candidate& each : slow_) {
      const Discharge& discharge = *each.inspection->discharge;
      const double most_C = MostCharge((1.0 + kSameRate) * discharge.current_A);
      if (discharge.charge_C > (1.0 - kLessThanFull) * most_C) continue;
      each.entry->left_out = fmt::format(
          "gives {:.4g} Ah, where a faster discharge gives {:.4g} Ah: it does not go from full to "
          "empty, or is of another cell",
          discharge.charge_C / 3600.0,
          most_C / 3600.0);
    }
    std::erase_if(slow_, [](const Candidate& each) { return !each.entry->left_out.empty(); });
  }

  // Under any cut-off that it would take, the charge of the cell is too small.
  void LeaveOutWhatDoesNotEndEmpty() {
    for (const Candidate& each : fast_) {
      if (EndsEmpty(each)) continue;
      each.entry->left_out =
          fmt::format("ends at {:.4g} V: it was stopped before the cell was empty",
                      each.inspection->discharge->end_voltage_V);
    }
    std::erase_if(fast_, [](const Candidate& each) { return !each.entry->left_out.empty(); });
  }

  // A cycler stops all of them at one voltage. One alone may have been stopped by something else.
  void DoubtEndsApart(const std::vector<Candidate>& discharges, double cutoff_V) {
    constexpr double kUsualCutoff_V = 3.3;  // or less
    const double round_V =
        PositiveToDigits(std::round(cutoff_V / kCutoffStep_V) * kCutoffStep_V, 3);
    if (discharges.size() == 1 && (cutoff_V > kUsualCutoff_V || round_V != cutoff_V)) {
      draft_.remarks.push_back(fmt::format(
          "One discharge alone tells the cut-off, and {:.4g} V is no usual one: look it up, for it may have been stopped "
          "by time or by a person.",
          cutoff_V));
    }
    const auto ends_there = [&](const Candidate& each) {
      const Discharge& discharge = *each.inspection->discharge;
      return std::abs(discharge.end_voltage_V - cutoff_V) <= CutoffTolerance(discharge);
    };
    if (discharges.size() == 1 || CutoffWithinLastRows(discharges) > 0.0 ||
        std::count_if(discharges.begin(), discharges.end(), ends_there) > 1)
      return;
    draft_.remarks.push_back(fmt::format(
        "The discharges do not end at one voltage, and {:.4g} V is that of one of them: look the cut-off up.",
        cutoff_V));
  }

  // None: `remarks` say why.
  std::optional<double> DraftCutoff() {
    std::vector<Candidate> discharges = fast_.empty() ? slow_ : fast_;
    std::erase_if(discharges, [](const Candidate& each) { return !EndsEmpty(each); });
    if (discharges.empty()) return std::nullopt;
    const double cutoff_V = FindCutoff(discharges);
    DoubtEndsApart(discharges, cutoff_V);
    if (!(cutoff_V >= kLowestCutoff_V)) {
      double highest_V = 0.0;
      for (const Candidate& each : discharges)
        highest_V = std::max(highest_V, each.inspection->voltage_V->largest);
      if (!(highest_V > kTypicalCutoff_V)) {
        draft_.remarks.push_back(fmt::format(
            "The discharges go from {:.3g} V to {:.3g} V, where a lithium-ion cell is empty: this is "
            "another kind of cell, or half of one, and no cut-off is drafted.",
            highest_V,
            std::max(cutoff_V, 0.0)));
        return std::nullopt;
      }
      draft_.remarks.push_back(fmt::format(
          "The discharges end at {:.3g} V, below what any cell may be used to; {} V is typical, "
          "look it up.",
          std::max(cutoff_V, 0.0),
          kTypicalCutoff_V));
      return kTypicalCutoff_V;
    }
    return cutoff_V;
  }

  void FindCutoffAndEnds() {
    draft_.campaign.cutoff_V = options_.cutoff_V ? options_.cutoff_V : DraftCutoff();
    if (!draft_.campaign.cutoff_V) return;
    for (const Candidate& each : fast_) {
      const Discharge& discharge = *each.inspection->discharge;
      if (discharge.end_voltage_V <= *draft_.campaign.cutoff_V + CutoffTolerance(discharge))
        continue;
      each.entry->left_out =
          fmt::format("ends at {:.4g} V, above the cut-off", discharge.end_voltage_V);
    }
  }

  void CompareDischarges() {
    std::vector<FullDischarge> all;
    std::vector<Candidate> candidates = fast_;
    candidates.insert(candidates.end(), slow_.begin(), slow_.end());
    for (const Candidate& each : candidates) {
      if (!each.entry->left_out.empty() || each.entry->log.initial_soc != 1.0) continue;
      const auto& warmth = each.inspection->temperature_degC;
      all.push_back({.file = each.entry->log.file,
                     .current_A = each.inspection->discharge->current_A,
                     .charge_C = each.inspection->discharge->charge_C,
                     .start_degC = warmth ? warmth->least : kNaN});
    }
    if (std::string doubt = DoubtAboutDischarges(all); !doubt.empty()) {
      doubt.front() = 'A';
      draft_.remarks.push_back(std::move(doubt) + ".");
    }
  }

  void ChooseLowRate() {
    if (slow_.empty()) return;
    low_rate_ = *std::min_element(slow_.begin(), slow_.end(), &BetterLowRate);
    for (const Candidate& each : slow_) {
      if (each.entry == low_rate_.entry) continue;
      const bool slower = low_rate_.inspection->discharge->current_A <
                          (1.0 - kSameRate) * each.inspection->discharge->current_A;
      const double charge_C = low_rate_.inspection->discharge->charge_C;
      const double less_C = each.inspection->discharge->charge_C;
      const double edge_Ohm = low_rate_.inspection->edge_resistance_Ohm;
      const double more_Ohm = each.inspection->edge_resistance_Ohm;
      const bool same = !(more_Ohm > (1.0 + kSameEdge) * edge_Ohm);
      each.entry->left_out =
          slower ? fmt::format("{} is slower", low_rate_.entry->log.file)
          : less_C < (1.0 - kSameCharge) * charge_C
              ? fmt::format("as slow as {}, which moves {:.4g} Ah and not {:.4g}",
                            low_rate_.entry->log.file,
                            charge_C / 3600.0,
                            less_C / 3600.0)
          : same ? fmt::format("as slow as {}, which shows as much", low_rate_.entry->log.file)
                 : fmt::format(
                       "as slow as {}, whose first edge shows {:.3g} Ohm instead of {:.3g} Ohm",
                       low_rate_.entry->log.file,
                       edge_Ohm,
                       more_Ohm);
    }
  }

  // The state of charge of each log that rests before its first load at less than the others.
  void FindStarts() {
    const Candidate* fullest = nullptr;
    for (const Candidate& each : all_) {
      const double voltage_V = each.inspection->start_voltage_V;
      if (std::isnan(voltage_V)) continue;
      if (fullest == nullptr || voltage_V > fullest->inspection->start_voltage_V) fullest = &each;
    }
    if (fullest == nullptr) return;
    const double full_V = fullest->inspection->start_voltage_V;
    if (full_V < kFullRest_V && full_V > kIronPhosphateRest_V) {
      draft_.remarks.push_back(fmt::format(
          "No log rests above {:.4g} V before its first load: if the cell is not full there, say "
          "`initial_soc` of each log.",
          full_V));
    }
    const bool reference = low_rate_.inspection != nullptr &&
                           low_rate_.inspection->start_voltage_V >= full_V - kSameStart_V;
    for (const Candidate& each : all_) {
      const double voltage_V = each.inspection->start_voltage_V;
      if (!(voltage_V < full_V - kSameStart_V - OfTemperature_V(each, *fullest))) continue;
      if (!reference) {
        each.entry->remarks.push_back(
            fmt::format("Rests at {:.4g} V before its first load, {} at {:.4g} V: if it does not "
                        "start full, say its `initial_soc`.",
                        voltage_V,
                        fullest->entry->log.file,
                        full_V));
        continue;
      }
      constexpr int kDigits = 4;  // a hundredth of it would change alpha by as much and more
      const double soc = PositiveToDigits(
          SocAt(*low_rate_.inspection, SlowestFromFull(full_V), voltage_V), kDigits);
      each.entry->log.initial_soc = soc;
      each.entry->remarks.push_back(
          fmt::format("Does not start full: it rests at {:.4g} V before its first load, which {} "
                      "passes at {:.4g} of its charge.",
                      voltage_V,
                      low_rate_.entry->log.file,
                      soc));
    }
  }

  // By how much the rest of a full cell may be lower for the temperature alone.
  static double OfTemperature_V(const Candidate& one, const Candidate& other) {
    const auto& warmth = one.inspection->temperature_degC;
    const auto& other_warmth = other.inspection->temperature_degC;
    if (!warmth || !other_warmth) return 0.0;
    return kMostEntropy_V_per_K * std::abs(warmth->least - other_warmth->least);
  }

  // The slowest discharge from full that is faster than the slow one, at about its temperature, for in the cold all
  // drops are larger; nullptr where there is none.
  [[nodiscard]] const Inspection* SlowestFromFull(double full_V) const {
    constexpr double kAlike_K = 10.0;
    const Inspection& slow = *low_rate_.inspection;
    const Inspection* slowest = nullptr;
    for (const Candidate& each : fast_) {
      const Inspection& one = *each.inspection;
      if (!(one.start_voltage_V >= full_V - kSameStart_V) || one.discharge_curve.size() < 2)
        continue;
      if (!(one.discharge->current_A > slow.discharge->current_A)) continue;
      if (one.temperature_degC && slow.temperature_degC &&
          std::abs(one.temperature_degC->least - slow.temperature_degC->least) > kAlike_K)
        continue;
      if (slowest == nullptr || one.discharge->current_A < slowest->discharge->current_A)
        slowest = &one;
    }
    return slowest;
  }

  // Of a discharge, after this charge; NaN where it had ended.
  static double VoltageAfter(const Inspection& one, double charge_C) {
    const double share = 1.0 - charge_C / one.discharge->charge_C;
    const auto& curve = one.discharge_curve;  // from 1 to 0
    const auto behind = std::find_if(
        curve.begin(), curve.end(), [&](const auto& point) { return point.first <= share; });
    if (behind == curve.end() || behind == curve.begin()) return kNaN;
    const auto& [lower, lower_V] = *behind;
    const auto& [upper, upper_V] = *std::prev(behind);
    return lower_V + (share - lower) / (upper - lower) * (upper_V - lower_V);
  }

  // Where the slow discharge, corrected for its drop, has this voltage. By how much less a faster one has after the
  // same charge says what the whole resistance drops; without one the first edge has to do, which shows r_s alone.
  static double SocAt(const Inspection& slow, const Inspection* fast, double voltage_V) {
    const double slow_A = slow.discharge->current_A;
    double drop_V = std::isnan(slow.edge_resistance_Ohm) ? 0.0 : slow.edge_resistance_Ohm * slow_A;
    double above_soc = 1.0;
    double above_V = slow.start_voltage_V;
    for (const auto& [soc, under_load_V] : slow.discharge_curve) {
      if (fast != nullptr) {
        const double less_V =
            under_load_V - VoltageAfter(*fast, (1.0 - soc) * slow.discharge->charge_C);
        if (less_V > 0.0) drop_V = less_V * slow_A / (fast->discharge->current_A - slow_A);
      }
      const double rest_V = under_load_V + drop_V;
      if (rest_V <= voltage_V) {
        const double share = above_V > rest_V ? (voltage_V - rest_V) / (above_V - rest_V) : 0.0;
        return soc + share * (above_soc - soc);
      }
      above_soc = soc;
      above_V = rest_V;
    }
    return 0.0;
  }

  const DraftOptions& options_;
  fs::path base_;
  CampaignDraft draft_;
  std::deque<Test> tests_;
  std::vector<Candidate> all_;
  std::vector<Candidate> fast_;
  std::vector<Candidate> slow_;
  Candidate low_rate_;
};

}  // namespace

CampaignDraft DraftCampaign(const std::vector<InspectedFile>& files,
                            const std::string& name,
                            const std::string& campaign_file,
                            const DraftOptions& options) {
  return Drafting(campaign_file, options).Draft(files, name);
}

std::string DraftToToml(const CampaignDraft& draft) {
  Campaign head = draft.campaign;
  head.logs.clear();
  std::string text =
      "# Drafted by lipoid inspect: read it over, most of all capacity, cut-off and kinds.\n";
  for (const auto& remark : draft.remarks) text += Comment(remark);
  text += CampaignToToml(head);
  for (const auto& entry : draft.entries) {
    text += "\n" + Comment(entry.reason);
    for (const auto& remark : entry.remarks) text += Comment(remark);
    std::istringstream lines(CampaignLogToToml(entry.log));
    if (entry.left_out.empty()) {
      text += lines.str();
      continue;
    }
    text += Comment(fmt::format("Left out: {}.", entry.left_out));
    for (std::string line; std::getline(lines, line);) text += Comment(line);
  }
  if (!draft.unused.empty()) text += "\n# Not used:\n";
  for (const auto& [file, reason] : draft.unused) {
    text += Comment(fmt::format("  {}: {}", file, reason));
  }
  return text;
}

}  // namespace lipoid
