#include "identify/logs/read_logs.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "model/core/parallel.h"

namespace lipoid {
namespace {

namespace fs = std::filesystem;

// What reading one log said about its sign.
struct Voice {
  std::string format;
  std::string current_column;
  CurrentSign sign = CurrentSign::kUnclear;
  bool open = false;  // it said too little; an unclear sign may also be that of a log of states

  [[nodiscard]] bool OneFormatWith(const Voice& other) const {
    return format == other.format && current_column == other.current_column;
  }
};

// Without a voltage the sign was taken, not found.
CurrentSign SignOf(const Log& log) {
  const std::string& sign = log.report.current_sign;
  if (log.record.voltage_V.empty() || sign == "unsigned") return CurrentSign::kUnclear;
  return sign == "discharge-positive" ? CurrentSign::kDischargePositive
                                      : CurrentSign::kDischargeNegative;
}

// The largest first, so that none of them ends alone.
std::vector<std::size_t> OrderBySize(const std::vector<LogToRead>& logs) {
  std::vector<std::uintmax_t> size(logs.size());
  std::vector<std::size_t> order(logs.size());
  for (std::size_t k = 0; k < logs.size(); ++k) {
    std::error_code unreadable;  // said when it is read
    size[k] = fs::file_size(logs[k].file, unreadable);
    if (unreadable) size[k] = 0;
    order[k] = k;
  }
  std::stable_sort(
      order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return size[a] > size[b]; });
  return order;
}

// What the settled logs of one format with log `open` say.
SignOfOthers AskOthers(const std::vector<LogToRead>& logs,
                       const std::vector<std::optional<Voice>>& voices,
                       std::size_t open) {
  std::optional<std::size_t> first;
  std::size_t more = 0;
  const auto name = [&](std::size_t k) { return fs::path(logs[k].file).filename().string(); };
  const auto says = [&](std::size_t k) {
    return fmt::format(
        "{} says that discharge is {}",
        name(k),
        voices[k]->sign == CurrentSign::kDischargePositive ? "positive" : "negative");
  };
  for (std::size_t k = 0; k < logs.size(); ++k) {
    if (!voices[k] || voices[k]->sign == CurrentSign::kUnclear) continue;
    if (!voices[k]->OneFormatWith(*voices[open])) continue;
    if (!first) {
      first = k;
    } else if (voices[k]->sign == voices[*first]->sign) {
      ++more;
    } else {
      return {CurrentSign::kUnclear,
              fmt::format("the other logs of its format disagree ({}, {})", says(*first), says(k))};
    }
  }
  if (!first) return {};
  return {voices[*first]->sign,
          fmt::format("{}{}, of the same format",
                      name(*first),
                      more > 0 ? fmt::format(" and {} more", more) : "")};
}

}  // namespace

std::vector<std::vector<Diagnostic>> ReadLogs(const std::vector<LogToRead>& logs,
                                              const std::function<void(std::size_t, Log)>& take) {
  std::vector<std::vector<Diagnostic>> problems(logs.size());
  std::vector<std::optional<Voice>> voices(logs.size());
  const std::vector<std::size_t> order = OrderBySize(logs);
  std::atomic<std::size_t> next = 0;
  ParallelFor(logs.size(), [&](std::size_t) {
    const std::size_t k = order[next++];
    try {
      Log log = ReadLog(logs[k].file, logs[k].options);
      voices[k] = Voice{log.report.format, log.report.current_column, SignOf(log), false};
      take(k, std::move(log));
    } catch (const OpenSignError& error) {
      voices[k] = Voice{error.format(), error.current_column(), CurrentSign::kUnclear, true};
      problems[k] = error.diagnostics();
    } catch (const LoadError& error) {
      problems[k] = error.diagnostics();
    }
  });
  // Those that stayed open are read again, with what the others say. The others are not changed by
  // that, so the order in which it happens does not matter.
  std::vector<std::size_t> open;
  std::vector<SignOfOthers> others;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    if (!voices[k] || !voices[k]->open) continue;
    if (auto asked = AskOthers(logs, voices, k); !asked.source.empty()) {
      open.push_back(k);
      others.push_back(std::move(asked));
    }
  }
  ParallelFor(open.size(), [&](std::size_t j) {
    const std::size_t k = open[j];
    problems[k] =
        DiagnosticsOf([&] { take(k, ReadLog(logs[k].file, logs[k].options, others[j])); });
  });
  return problems;
}

}  // namespace lipoid
