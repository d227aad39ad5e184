#include "identify/logs/log_writer.h"

#include <charconv>
#include <cstddef>
#include <vector>

#include "model/core/atomic_file.h"
#include "model/core/errors.h"

namespace lipoid {

void WriteLog(const Record& record, const std::string& file, LogFileFormat format) {
  const bool has_temperature = !record.temperature_degC.empty();
  Require(record.current_A.size() == record.size() && record.voltage_V.size() == record.size() &&
              (!has_temperature || record.temperature_degC.size() == record.size()),
          "columns of equal length");
  const bool bdf = format == LogFileFormat::kBdf;
  AtomicFile out(file);
  std::string header = bdf ? "Test Time / s,Current / A,Voltage / V" : "time_s,current_A,voltage_V";
  if (has_temperature) header += bdf ? ",Temperature T1 / degC" : ",temperature_degC";
  out.Write(header + "\n");

  constexpr std::size_t kBuffer = std::size_t{1} << 18;
  constexpr std::size_t kLongestRow = 4 * 32;  // a double takes 24 characters at most
  std::vector<char> buffer(kBuffer);
  char* const end = buffer.data() + kBuffer;
  char* at = buffer.data();
  const auto append = [&](double value, char after) {
    at = std::to_chars(at, end, value).ptr;
    *at++ = after;
  };
  for (std::size_t k = 0; k < record.size(); ++k) {
    append(record.time_s[k], ',');
    append(bdf ? 0.0 - record.current_A[k] : record.current_A[k], ',');
    append(record.voltage_V[k], has_temperature ? ',' : '\n');
    if (has_temperature) append(record.temperature_degC[k], '\n');
    if (end - at < static_cast<std::ptrdiff_t>(kLongestRow)) {
      out.Write({buffer.data(), static_cast<std::size_t>(at - buffer.data())});
      at = buffer.data();
    }
  }
  out.Write({buffer.data(), static_cast<std::size_t>(at - buffer.data())});
  out.Commit();
}

}  // namespace lipoid
