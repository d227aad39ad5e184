// What of a controller is exported; how the C flies: tests/tools/export_controller_test.cc.
#include "model/export/controller_export.h"

#include <gtest/gtest.h>

#include "model/control/gains.h"
#include "model/core/errors.h"
#include "model/vehicle/vehicle_file.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

ControllerExportRequest Request() {
  return {.vehicle = LoadVehicle("mambo-coupled"), .gains = LoadGains("aware"), .lowest_V = 3.0};
}

TEST(ControllerExport, EveryLawOfTheTableIsExportedOrRefused) {
  for (const ControlLaw& law : ControlLaws()) {
    auto request = Request();
    request.controller.law = law.name;
    if (law.in_c) {
      EXPECT_EQ(ExportController(request).size(), 4U) << law.name;
    } else {
      EXPECT_THROW((void)ExportController(request), OptionError) << law.name;
    }
  }
}

TEST(ControllerExport, ALawWithoutCIsRefusedWithASentence) {
  ControlLaw mine{};
  mine.name = "mine";
  EXPECT_EQ(test::MessageOf<OptionError>([&] { (void)LawInC(mine); }),
            "the controller mine cannot be exported: it has no C code. Those that have: inversion, "
            "pid, lqr");
}

TEST(ControllerExport, AVoltageOfZeroBoundsNothing) {
  auto request = Request();
  request.lowest_V = 0.0;
  EXPECT_THROW((void)ExportController(request), std::exception);
}

}  // namespace
}  // namespace lipoid
