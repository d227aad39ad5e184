#include "python/src/work.h"

#include <tbb/global_control.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "model/core/stop.h"

namespace lipoid::python {
namespace {

using namespace std::chrono_literals;

// A person who presses Ctrl-C waits no longer than this until Python sees it.
constexpr auto kLook = 50ms;

std::mutex running_mutex;
std::set<Stoppable*> running;

// What is at work stands in the list, from its beginning to its end.
struct Listed {
  explicit Listed(Stoppable& work) : of(&work) {
    const std::lock_guard lock(running_mutex);
    running.insert(of);
  }
  ~Listed() {
    const std::lock_guard lock(running_mutex);
    running.erase(of);
  }
  Listed(const Listed&) = delete;
  Listed& operator=(const Listed&) = delete;
  Stoppable* of;
};

struct Shared {
  std::mutex mutex;
  std::condition_variable ended;
  bool done = false;
  bool news = false;
  double share = 0.0;
  std::string what;
  std::exception_ptr error;
};

}  // namespace

void Work(const std::function<void(const Tell&)>& work, const nb::object& progress, int threads) {
  const bool told = !progress.is_none();
  Shared shared;
  Stoppable stoppable;
  const Listed listed(stoppable);
  const Tell tell = [&](std::string_view what, double share) {
    StopIfAsked();
    if (!told) return;
    const std::lock_guard lock(shared.mutex);
    shared.news = true;
    shared.share = share;
    shared.what = what;
  };
  std::exception_ptr interrupted;  // of Python
  {
    const nb::gil_scoped_release release;
    std::optional<tbb::global_control> limit;
    if (threads > 0) {
      limit.emplace(tbb::global_control::max_allowed_parallelism,
                    static_cast<std::size_t>(threads));
    }
    std::thread worker([&] {
      try {
        stoppable.Run([&] { work(tell); });
      } catch (...) {
        shared.error = std::current_exception();
      }
      const std::lock_guard lock(shared.mutex);
      shared.done = true;
      shared.ended.notify_one();
    });
    while (true) {
      bool news = false;
      double share = 0.0;
      std::string what;
      {
        std::unique_lock lock(shared.mutex);
        if (shared.ended.wait_for(lock, kLook, [&] { return shared.done; })) break;
        std::swap(news, shared.news);
        share = shared.share;
        what = shared.what;
      }
      const nb::gil_scoped_acquire acquire;
      try {
        if (PyErr_CheckSignals() != 0) throw nb::python_error();
        if (news) progress(share, nb::str(what.data(), what.size()));
      } catch (...) {
        interrupted = std::current_exception();
        break;
      }
    }
    if (interrupted) stoppable.Stop();
    worker.join();
  }
  if (interrupted) std::rethrow_exception(interrupted);
  if (shared.error) std::rethrow_exception(shared.error);
  if (told) progress(1.0, "done");
}

void StopAllWork() {
  const std::lock_guard lock(running_mutex);
  for (Stoppable* work : running) work->Stop();
}

}  // namespace lipoid::python
