#include "tools/report/report.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <cstring>
#include <ctime>
#include <nlohmann/json.hpp>

#include "model/core/errors.h"
#include "model/core/run_record.h"
#include "tools/report/shown_summary.h"
#include "tools/report/web_asset.h"

namespace lipoid {
namespace {

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

Json SeriesToJson(const Series& series) {
  Json columns = Json::array();
  for (const auto& [name, values] : series.columns) {
    const bool time = name == "time_s";
    columns.push_back({{"name", name},
                       {"type", time ? "f64" : "f32"},
                       {"data", time ? Packed<double>(values) : Packed<float>(values)}});
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
  bool flight = false;
  for (const ReportResult& result : results) {
    Json series = Json::array();
    for (const Series& each : result.series) {
      flight = flight || each.kind == "flight";
      series.push_back(SeriesToJson(each));
    }
    Json shown = Json::object();
    shown["summary"] = ShownSummary(result.summary);
    shown["series"] = std::move(series);
    shown["notes"] = result.notes;
    shown["file"] = result.file;
    page["results"].push_back(std::move(shown));
  }
  const std::string data = Escaped(page.dump(-1, ' ', false, Json::error_handler_t::replace));
  const std::string_view script = *FindWebAsset(flight ? "report-flight.js" : "report.js");
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
