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

}  // namespace lipoid::python
