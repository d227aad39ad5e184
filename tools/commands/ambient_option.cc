#include "tools/commands/ambient_option.h"

#include "model/battery/typical_temperature.h"

namespace lipoid {

Cell KnowingTemperature(cli::CommandLine& line,
                        const Cell& cell,
                        const std::string& cell_name,
                        double size_factor) {
  if (cell.temperature) return cell;
  line.Message("{} {}", cell_name, TypicalTemperatureText(cell, size_factor));
  return WithTypicalTemperature(cell, size_factor);
}

}  // namespace lipoid
