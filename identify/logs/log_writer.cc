#include "identify/logs/log_writer.h"

#include <cstddef>
#include <string>
#include <string_view>

#include "model/core/csv_writer.h"
#include "model/core/errors.h"

namespace lipoid {

void WriteLog(const Record& record, const std::string& file, LogFileFormat format) {
  const bool has_temperature = !record.temperature_degC.empty();
  Require(record.current_A.size() == record.size() && record.voltage_V.size() == record.size() &&
              (!has_temperature || record.temperature_degC.size() == record.size()),
          "columns of equal length");
  std::string header = format == LogFileFormat::kBdf ? "Test Time / s,Current / A,Voltage / V"
                                                     : "time_s,current_A,voltage_V";
  const std::string_view temperature =
      format == LogFileFormat::kBdf ? ",Temperature T1 / degC" : ",temperature_degC";
  if (has_temperature) header += temperature;
  CsvWriter csv(file, header);
  for (std::size_t k = 0; k < record.size(); ++k) {
    const double i_A =
        format == LogFileFormat::kBdf ? 0.0 - record.current_A[k] : record.current_A[k];
    if (has_temperature) {
      csv.Row(record.time_s[k], i_A, record.voltage_V[k], record.temperature_degC[k]);
    } else {
      csv.Row(record.time_s[k], i_A, record.voltage_V[k]);
    }
  }
  csv.Commit();
}

}  // namespace lipoid
