#include "identify/logs/log_writer.h"

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "model/core/errors.h"

namespace lipoid {
namespace {

std::string_view StateOf(double current_A) {
  if (current_A > 0.0) return "discharge";
  return current_A < 0.0 ? "charge" : "rest";
}

}  // namespace

void LogWriter::Add(const Record& rows) {
  if (!csv_) {
    has_temperature_ = !rows.temperature_degC.empty();
    std::string header = format_ == LogFileFormat::kBdf ? "Test Time / s,Current / A,Voltage / V"
                                                        : "time_s,current_A,voltage_V";
    const std::string_view temperature =
        format_ == LogFileFormat::kBdf ? ",Temperature T1 / degC" : ",temperature_degC";
    if (has_temperature_) header += temperature;
    if (states_) header += format_ == LogFileFormat::kBdf ? ",Step Type" : ",state";
    csv_.emplace(file_, header);
  }
  Require(rows.current_A.size() == rows.size() && rows.voltage_V.size() == rows.size() &&
              rows.temperature_degC.size() == (has_temperature_ ? rows.size() : 0),
          "columns of equal length");
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double i_A = rows.current_A[k];
    const std::array numbers{rows.time_s[k],
                             format_ == LogFileFormat::kBdf ? 0.0 - i_A : i_A,
                             rows.voltage_V[k],
                             has_temperature_ ? rows.temperature_degC[k] : 0.0};
    csv_->RowOf(std::span(numbers).first(has_temperature_ ? 4 : 3), states_ ? StateOf(i_A) : "");
  }
}

void LogWriter::Commit() {
  Require(csv_.has_value(), "rows were added");
  csv_->Commit();
}

void WriteLog(const Record& record, const std::string& file, LogFileFormat format) {
  LogWriter writer(file, format);
  writer.Add(record);
  writer.Commit();
}

}  // namespace lipoid
