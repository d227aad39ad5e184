#include <cstdio>

#include "identify/synthesis/protocols.h"
#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"

int main() {
  const auto cell = lipoid::LoadCell("gifi-600mAh-1");
  const auto prediction = lipoid::Predict(cell, std::vector{0.0, 10.0}, std::vector{0.0, 0.6});
  std::printf("%zu %.3f %.0f\n",
              prediction.soc.size(),
              prediction.soc[1],
              lipoid::HighestSuitableRate(cell));
}
