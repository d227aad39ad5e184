#pragma once

/// @file
/// Loops on all cores, within work that may be stopped (stop.h). A loop of TBB leaves out what it has
/// not begun when it is cancelled, and returns: what it was to compute is then not there. These throw
/// Stopped instead, so that nobody looks at it. Tests: tests/model/core/stop_test.cc.

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <cstddef>
#include <utility>

#include "model/core/stop.h"

namespace lipoid {

/// body(k) for each k below count, in no order.
template <class Body>
void ParallelFor(std::size_t count, Body&& body) {
  tbb::parallel_for(std::size_t{0}, count, std::forward<Body>(body));
  StopIfAsked();
}

/// All of these side by side.
template <class... Body>
void ParallelInvoke(Body&&... bodies) {
  tbb::parallel_invoke(std::forward<Body>(bodies)...);
  StopIfAsked();
}

}  // namespace lipoid
