#include "model/core/stop.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <stdexcept>
#include <thread>

namespace lipoid {
namespace {

TEST(Stop, WorkThatNobodyStopsIsDone) {
  int done = 0;
  Stoppable work;
  work.Run([&] {
    StopIfAsked();
    ++done;
  });
  work.Stop();  // too late, and harmless
  EXPECT_EQ(done, 1);
  StopIfAsked();  // outside of any
}

TEST(Stop, EndsWorkFromAnotherThread) {
  Stoppable work;
  std::atomic<bool> begun = false;
  std::thread stopper([&] {
    while (!begun) std::this_thread::yield();
    work.Stop();
  });
  EXPECT_THROW(work.Run([&] {
    begun = true;
    while (true) StopIfAsked();
  }),
               Stopped);
  stopper.join();
}

TEST(Stop, ReachesNestedLoops) {
  Stoppable work;
  std::atomic<int> begun = 0;
  std::thread stopper([&] {
    while (begun == 0) std::this_thread::yield();
    work.Stop();
  });
  EXPECT_THROW(work.Run([&] {
    tbb::parallel_for(0, 4, [&](int) {
      tbb::parallel_for(0, 4, [&](int) {
        ++begun;
        while (true) StopIfAsked();
      });
    });
  }),
               Stopped);
  stopper.join();
}

TEST(Stop, StoppedBeforeItBeginsDoesNothing) {
  Stoppable work;
  work.Stop();
  bool ran = false;
  EXPECT_THROW(work.Run([&] { ran = true; }), Stopped);
  EXPECT_FALSE(ran);
}

TEST(Stop, OtherExceptionsPass) {
  Stoppable work;
  EXPECT_THROW(work.Run([] { throw std::invalid_argument("of the work"); }), std::invalid_argument);
}

TEST(Stop, OneOfTwoIsStopped) {
  Stoppable one;
  Stoppable other;
  one.Stop();
  bool ran = false;
  other.Run([&] {
    StopIfAsked();
    ran = true;
  });
  EXPECT_TRUE(ran);
}

}  // namespace
}  // namespace lipoid
