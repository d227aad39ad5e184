#pragma once

/// @file
/// Long work that somebody may want to stop: a person with Ctrl-C, a program that waits no longer.
///
///   Stoppable work;
///   std::thread thread([&] { work.Run([&] { found = Identify(campaign, logs, options); }); });
///   work.Stop();  // from any thread: Run() ends soon, by throwing Stopped
///
/// Work asks StopIfAsked() where a part of it begins; that costs a few nanoseconds, and nothing else
/// about it changes where nobody stops it. What is nested in parallel loops is asked with it. Tests:
/// tests/model/core/stop_test.cc.

#include <exception>
#include <functional>
#include <memory>

namespace lipoid {

/// Work was stopped from outside. No std::runtime_error: nobody takes it for a failure of the work.
class Stopped : public std::exception {
 public:
  [[nodiscard]] const char* what() const noexcept override { return "stopped"; }
};

/// Throws Stopped where the Stoppable that this is a part of was stopped.
void StopIfAsked();

class Stoppable {
 public:
  Stoppable();
  ~Stoppable();
  Stoppable(const Stoppable&) = delete;
  Stoppable& operator=(const Stoppable&) = delete;

  /// Does the work in this thread; once. Throws what it throws, or Stopped.
  void Run(const std::function<void()>& work);
  /// From any thread, any number of times, before, during or after Run().
  void Stop();

 private:
  struct Group;
  std::unique_ptr<Group> group_;
};

}  // namespace lipoid
