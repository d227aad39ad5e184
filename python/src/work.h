#pragma once

/// @file
/// Long work of C++ called from Python: without the global interpreter lock, with progress, and such
/// that Ctrl-C ends it.

#include <nanobind/nanobind.h>

#include <functional>
#include <string_view>

namespace lipoid::python {

namespace nb = nanobind;

using Tell = std::function<void(std::string_view what, double share)>;

/// Runs the work in a thread of its own, with at most so many cores (0: all there are). `progress` is
/// None or a function of the share done and of what is being done, called by the thread of Python, a
/// few times a second. A signal that Python raises an exception for, and an exception of
/// `progress`, stop the work.
void Work(const std::function<void(const Tell&)>& work,
          const nb::object& progress = nb::none(),
          int threads = 0);

/// Stops what Work() does in any thread: its callers get a KeyboardInterrupt.
void StopAllWork();

/// Without the global interpreter lock as long as it lives. A thread that Python leaves behind when it
/// ends stays in here for good: Python would end it in the middle of C++, and with it the process.
class WithoutLock {
 public:
  WithoutLock();
  ~WithoutLock();
  WithoutLock(const WithoutLock&) = delete;
  WithoutLock& operator=(const WithoutLock&) = delete;

 private:
  PyThreadState* state_;
};

/// Of the module atexit: stops all work, and waits until no thread is without the lock. From then on
/// no thread but this one comes back to Python.
void EndWork();

/// Whether the calling thread can no longer come back to Python.
[[nodiscard]] bool HasEnded();

}  // namespace lipoid::python
