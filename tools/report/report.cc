#include "tools/report/report.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <map>
#include <nlohmann/json.hpp>

#include "model/core/errors.h"
#include "model/core/run_record.h"
#include "tools/report/shown_summary.h"
#include "tools/report/thinned_series.h"
#include "tools/report/web_asset.h"

namespace lipoid {
namespace {

// Of samples, in base64, beside the scripts of a page with flights and of one without.
constexpr std::size_t kBytesBesideFlights = 1'150'000;
constexpr std::size_t kBytesBesideCharts = 1'600'000;

std::string Base64(const unsigned char* bytes, std::size_t size) {
  std::string text((size + 2) / 3 * 4 + 1, '\0');
  const int length =
      EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), bytes, static_cast<int>(size));
  text.resize(static_cast<std::size_t>(length));
  return text;
}

// 'sha256-...' of a script or style, by which the Content-Security-Policy lets it pass.
std::string PolicyHash(std::string_view text) {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  EVP_Digest(text.data(), text.size(), digest, &size, EVP_sha256(), nullptr);
  return "sha256-" + Base64(digest, size);
}

// Times keep all their digits: a second of a log of weeks. Seven digits are more than a chart shows
// of anything else.
template <class Number>
std::string Packed(const std::vector<double>& values) {
  std::vector<Number> numbers(values.begin(), values.end());
  return Base64(reinterpret_cast<const unsigned char*>(numbers.data()),
                numbers.size() * sizeof(Number));
}

bool IsFlight(const Series& series) { return series.kind == "flight"; }

// A column that has one value throughout, or repeats one before it (four motors at one speed, an
// estimate that is the truth), is told in a word.
Json SeriesToJson(const Series& series) {
  Json columns = Json::array();
  std::map<std::string, std::string> packed;  // data to the first column that has them
  for (const auto& [name, values] : series.columns) {
    if (IsConstant(values)) {
      columns.push_back({{"name", name},
                         {"type", "constant"},
                         {"value", NumberOrNull(values[0])},
                         {"length", values.size()}});
      continue;
    }
    const bool time = name == "time_s";
    std::string data = time ? Packed<double>(values) : Packed<float>(values);
    if (const auto [same, first] = packed.emplace(std::move(data), name); first) {
      columns.push_back({{"name", name}, {"type", time ? "f64" : "f32"}, {"data", same->first}});
    } else {
      columns.push_back({{"name", name}, {"type", "copy"}, {"of", same->second}});
    }
  }
  return {{"kind", series.kind},
          {"name", series.name},
          {"rows", series.rows},
          {"of", series.of},
          {"columns", std::move(columns)}};
}

// Inside a script element only "</" and "<!" have a meaning, and JSON may write '<' in another way.
std::string Escaped(const std::string& json) {
  std::string text;
  text.reserve(json.size());
  for (const char c : json) {
    if (c == '<')
      text += "\\u003c";
    else
      text += c;
  }
  return text;
}

// The date, as a lab book has it: 2026-03-01.
std::string Today() {
  const std::time_t now = std::time(nullptr);
  std::tm day = {};
  gmtime_r(&now, &day);
  return fmt::format("{:04}-{:02}-{:02}", day.tm_year + 1900, day.tm_mon + 1, day.tm_mday);
}

}  // namespace

bool CanReport() { return FindWebAsset("page.html") != nullptr; }

void RequireReport() {
  if (CanReport()) return;
  throw OptionError(
      "this lipoid was built without reports, for which the build needs npm and the package "
      "registry; run tools/setup and build it again");
}

std::string ReportPage(std::span<const ReportResult> results) {
  RequireReport();
  Json page = {{"schema", "lipoid.report/1"},
               {"program", {{"version", Version()}, {"commit", GitCommit()}, {"written", Today()}}},
               {"results", Json::array()}};
  // What all samples of the page may take: with the scripts, of which those of a flight are large,
  // it stays below 2 MB.
  bool flights = false;
  std::vector<std::size_t> wanted;
  for (const ReportResult& result : results) {
    for (const Series& each : result.series) {
      flights = flights || IsFlight(each);
      wanted.push_back(BytesOf(each));
    }
  }
  const auto shares = Shares(wanted, flights ? kBytesBesideFlights : kBytesBesideCharts);
  auto share = shares.begin();
  for (const ReportResult& result : results) {
    Json series = Json::array();
    for (const Series& each : result.series)
      series.push_back(SeriesToJson(Thinned(each, *share++)));
    Json shown = Json::object();
    shown["summary"] = ShownSummary(result.summary);
    shown["series"] = std::move(series);
    shown["notes"] = result.notes;
    shown["file"] = result.file;
    page["results"].push_back(std::move(shown));
  }
  const std::string data = Escaped(page.dump(-1, ' ', false, Json::error_handler_t::replace));
  const std::string_view script = *FindWebAsset(flights ? "report-flight.js" : "report.js");
  const std::string_view style = *FindWebAsset("style.css");
  const auto value = [&](std::string_view name) -> std::string {
    if (name == "SCRIPT_HASH") return PolicyHash(script);
    if (name == "STYLE_HASH") return PolicyHash(style);
    if (name == "TITLE") return "lipoid report";
    if (name == "STYLE") return std::string(style);
    if (name == "SCRIPT") return std::string(script);
    return data;
  };
  std::string text;
  std::string_view rest = *FindWebAsset("page.html");
  for (auto at = rest.find('@'); at != rest.npos; at = rest.find('@')) {
    const auto end = rest.find('@', at + 1);
    text += rest.substr(0, at);
    text += value(rest.substr(at + 1, end - at - 1));
    rest.remove_prefix(end + 1);
  }
  return text += rest;
}

}  // namespace lipoid
