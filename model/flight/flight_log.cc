#include "model/flight/flight_log.h"

namespace lipoid {
namespace {

std::string Header(std::size_t rotors) {
  std::string header;
  FlightSample::OfRotors(rotors).Visit([&](const char* name, double) {
    if (!header.empty()) header += ',';
    header += name;
  });
  return header;
}

}  // namespace

FlightLogWriter::FlightLogWriter(const std::string& file, std::size_t rotors)
    : csv_(file, Header(rotors)) {}

void FlightLogWriter::Row(const FlightSample& sample) {
  row_.clear();
  sample.Visit([&](const char*, double value) { row_.push_back(value); });
  csv_.RowOf(row_);
}

}  // namespace lipoid
