#include "identify/logs/flight/autopilot_log.h"

#include "identify/logs/flight/dataflash.h"
#include "identify/logs/flight/ulog.h"

namespace lipoid {
namespace {

// The only list of the formats of autopilots.
constexpr AutopilotFormat kFormats[] = {
    {"ardupilot-dataflash",
     "ArduPilot's DataFlash log (.bin): messages BAT, or CURR in old ones",
     "BAT or CURR",
     &IsDataFlash,
     &ReadDataFlash},
    {"px4-ulog", "PX4's ULog (.ulg): topic battery_status", "battery_status", &IsULog, &ReadULog}};

}  // namespace

std::span<const AutopilotFormat> AutopilotFormats() { return kFormats; }

const AutopilotFormat* FindAutopilotFormat(std::string_view bytes) {
  for (const AutopilotFormat& format : kFormats) {
    if (format.recognises(bytes)) return &format;
  }
  return nullptr;
}

}  // namespace lipoid
