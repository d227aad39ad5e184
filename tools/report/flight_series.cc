#include "tools/report/flight_series.h"

#include <nlohmann/json.hpp>

#include "tools/report/thinned_series.h"

namespace lipoid {
namespace {

constexpr const char* kTime = "time_s";  // has a type of its own

// Rows in memory: 7 MB.
constexpr std::size_t kMostRows = std::size_t{1} << 16;

std::vector<std::string> LogColumns(std::size_t rotors, bool warms) {
  std::vector<std::string> names;
  FlightSample::OfRotors(rotors, warms).Visit([&](const char* name, double) {
    names.emplace_back(name);
  });
  return names;
}

template <class Value>
void Keep(const std::vector<std::size_t>& rows, std::vector<Value>& column) {
  for (std::size_t to = 0; to < rows.size(); ++to) column[to] = column[rows[to]];
  column.resize(rows.size());
}

}  // namespace

bool IsShownOfFlight(const std::string& column) {
  return !column.starts_with("velocity_") && !column.starts_with("climb_") &&
         !column.ends_with("_rate_rad_per_s") && !column.starts_with("current_");
}

FlightSeries::FlightSeries(std::size_t rotors, bool warms) : names_(LogColumns(rotors, warms)) {
  for (std::size_t k = 0; k < names_.size(); ++k) {
    if (names_[k] != kTime && IsShownOfFlight(names_[k])) shown_.push_back(k);
  }
  values_.resize(shown_.size());
}

void FlightSeries::Row(const FlightSample& sample) {
  if (index_.size() == kMostRows) {
    while (index_.size() > kMostRows / 2) KeepExtremes(stretch_ *= 2);
  }
  index_.push_back(seen_++);
  time_s_.push_back(sample.time_s);
  std::size_t column = 0;
  std::size_t next = 0;
  sample.Visit([&](const char*, double value) {
    if (next == shown_.size() || shown_[next] != column++) return;
    values_[next++].push_back(static_cast<float>(value));
  });
}

void FlightSeries::KeepExtremes(std::size_t stretch) {
  const auto rows = ExtremeRows(index_, values_, stretch);
  Keep(rows, index_);
  Keep(rows, time_s_);
  for (auto& column : values_) Keep(rows, column);
}

Series FlightSeries::Take(const std::string& name) {
  // The rows that came last are as thin as those before them.
  if (stretch_ > 1) KeepExtremes(stretch_);
  Series series{"flight", name, seen_, {}};
  series.columns.push_back({"time_s", std::move(time_s_)});
  for (std::size_t k = 0; k < shown_.size(); ++k) {
    const auto& values = values_[k];
    series.columns.push_back({names_[shown_[k]], {values.begin(), values.end()}});
  }
  return series;
}

}  // namespace lipoid
