#include "model/core/stop.h"

#include <tbb/task_group.h>

#include <atomic>

namespace lipoid {

// A context that is cancelled tells those of the parallel loops within. They then leave out what
// they have not begun, so that what Run() computed is of no use, whatever it looks like.
struct Stoppable::Group {
  tbb::task_group_context context{tbb::task_group_context::isolated};
  tbb::task_group tasks{context};
  std::atomic<bool> stopped = false;
};

Stoppable::Stoppable() : group_(std::make_unique<Group>()) {}
Stoppable::~Stoppable() = default;

void Stoppable::Run(const std::function<void()>& work) {
  if (group_->stopped) throw Stopped();
  try {
    group_->tasks.run_and_wait(work);
  } catch (...) {
    if (group_->stopped) throw Stopped();
    throw;
  }
  if (group_->stopped) throw Stopped();
}

void Stoppable::Stop() {
  group_->stopped = true;
  group_->context.cancel_group_execution();
}

void StopIfAsked() {
  if (tbb::is_current_task_group_canceling()) throw Stopped();
}

}  // namespace lipoid
