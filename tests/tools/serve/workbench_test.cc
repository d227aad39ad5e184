#include "tools/serve/workbench.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <thread>

#include "tests/support/run_lipoid.h"

namespace lipoid {
namespace {

using Clock = std::chrono::steady_clock;

// A workbench for which a shell stands for lipoid; each of its runs adds a byte to a file.
class WorkbenchOfShells {
 public:
  explicit WorkbenchOfShells(const std::string& script) {
    std::ofstream(program_) << "#!/bin/sh\nprintf x >> '" << runs_ << "'\n" << script << "\n";
    std::filesystem::permissions(program_, std::filesystem::perms::owner_all);
    std::filesystem::create_directory(folder_ + "/bench");
    bench_ = std::make_unique<Workbench>(
        folder_ + "/bench",
        program_,
        WorkbenchLimits{.files = 4, .file_bytes = 1000, .total_bytes = 2000},
        options_);
  }

  [[nodiscard]] std::unique_ptr<BodySink> Take(std::string_view name) {
    auto sink = bench_->Upload(name, std::nullopt);
    sink->Write("time_s,current_A,voltage_V\n");
    EXPECT_EQ(sink->Finish().status, 201);
    return sink;
  }
  [[nodiscard]] std::uintmax_t Runs() const {
    return std::filesystem::exists(runs_) ? std::filesystem::file_size(runs_) : 0;
  }
  void WaitForRuns(std::uintmax_t runs) const {
    while (Runs() < runs) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  void EndsAtOnce() {
    const auto asked = Clock::now();
    bench_.reset();
    EXPECT_LT(Clock::now() - asked, std::chrono::seconds(4));
  }

 private:
  std::string folder_ = test::TestFolder();
  std::string program_ = folder_ + "/lipoid";
  std::string runs_ = folder_ + "/runs";
  JobOptions options_{{}};
  std::unique_ptr<Workbench> bench_;
};

TEST(Workbench, EndsThoughAFileWaitsForTheNextInspection) {
  WorkbenchOfShells bench("exec sleep 8");
  (void)bench.Take("one.csv");
  bench.WaitForRuns(1);
  (void)bench.Take("two.csv");
  bench.EndsAtOnce();
  EXPECT_EQ(bench.Runs(), 1U);
}

TEST(Workbench, EndsThoughFilesAreLookedAtOneByOne) {
  WorkbenchOfShells bench("case \"$*\" in *one*two*) exit 9 ;; esac\nexec sleep 8");
  {
    const auto one = bench.Take("one.csv");  // both before the first inspection
    const auto two = bench.Take("two.csv");
  }
  bench.WaitForRuns(2);
  bench.EndsAtOnce();
  EXPECT_EQ(bench.Runs(), 2U);
}

}  // namespace
}  // namespace lipoid
