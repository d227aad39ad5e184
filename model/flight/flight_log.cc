#include "model/flight/flight_log.h"

#include "model/core/csv_writer.h"

namespace lipoid {

void WriteFlightLog(const std::vector<FlightSample>& samples, const std::string& file) {
  std::string header;
  FlightSample{}.Visit([&](const char* name, double) {
    if (!header.empty()) header += ',';
    header += name;
  });
  CsvWriter csv(file, header);
  std::vector<double> row;
  for (const FlightSample& sample : samples) {
    row.clear();
    sample.Visit([&](const char*, double value) { row.push_back(value); });
    csv.RowOf(row);
  }
  csv.Commit();
}

}  // namespace lipoid
