#include "identify/exchanged_temperatures.h"

#include <gtest/gtest.h>

namespace lipoid {
namespace {

// Steps at three states of charge each, with these resistances after 1 s.
LogErrors Shows(const std::string& file, double low_Ohm, double high_Ohm) {
  LogErrors errors;
  errors.file = file;
  for (const double soc : {0.2, 0.25, 0.3, 0.8, 0.85, 0.9}) {
    const double measured_Ohm = soc < 0.5 ? low_Ohm : high_Ohm;
    errors.edges.push_back({.soc = soc,
                            .after_s = 1.0,
                            .measured_Ohm = measured_Ohm,
                            .predicted_Ohm = measured_Ohm,
                            .step = errors.edges.size()});
  }
  return errors;
}

LoadedLog At(const std::string& file, double ambient_degC, double measured_degC = 0.0) {
  LoadedLog log;
  log.entry.kind = LogKind::kPulses;
  log.entry.file = file;
  log.entry.ambient_degC = ambient_degC;
  if (measured_degC != 0.0) log.log.record.temperature_degC = Column(3, measured_degC);
  return log;
}

TEST(ExchangedTemperatures, ACellHasMoreResistanceInTheCold) {
  const std::vector<LogErrors> errors{Shows("a.csv", 0.060, 0.045), Shows("b.csv", 0.120, 0.090)};
  EXPECT_EQ(DoubtAboutExchangedTemperatures(errors, {At("a.csv", 25.0), At("b.csv", 0.0)}), "");
  EXPECT_EQ(
      DoubtAboutExchangedTemperatures(errors, {At("a.csv", 0.0), At("b.csv", 25.0)}),
      "a.csv shows 60 mOhm after 1 s at 0 degC, and b.csv shows 120 mOhm at 25 degC: a cell has more "
      "resistance in the cold. Are the temperatures of the two exchanged, or is one of them another cell?");
  // Few kelvin, or a tenth of the resistance, say nothing; nor does a log without a temperature.
  EXPECT_EQ(DoubtAboutExchangedTemperatures(errors, {At("a.csv", 20.0), At("b.csv", 25.0)}), "");
  EXPECT_EQ(
      DoubtAboutExchangedTemperatures({Shows("a.csv", 0.055, 0.042), Shows("b.csv", 0.060, 0.045)},
                                      {At("a.csv", 0.0), At("b.csv", 25.0)}),
      "");
  LoadedLog untold = At("a.csv", 0.0);
  untold.entry.ambient_degC.reset();
  EXPECT_EQ(DoubtAboutExchangedTemperatures(errors, {untold, At("b.csv", 25.0)}), "");
  // Nor where only one of the two thirds of the charge does.
  EXPECT_EQ(DoubtAboutExchangedTemperatures({Shows("a.csv", 0.060, 0.090), errors[1]},
                                            {At("a.csv", 0.0), At("b.csv", 25.0)}),
            "");
}

TEST(ExchangedTemperatures, WhatWasMeasuredCounts) {
  const std::vector<LogErrors> errors{Shows("a.csv", 0.060, 0.045), Shows("b.csv", 0.120, 0.090)};
  EXPECT_EQ(
      DoubtAboutExchangedTemperatures(errors, {At("a.csv", 0.0, 25.0), At("b.csv", 25.0, 0.5)}),
      "");
}

}  // namespace
}  // namespace lipoid
