#include "python/src/work.h"

#include <pthread.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "model/core/stop.h"

namespace lipoid::python {
namespace {

using namespace std::chrono_literals;

// A person who presses Ctrl-C waits no longer than this until Python sees it.
constexpr auto kLook = 50ms;

// What threads of Python do here.
struct Present {
  std::mutex mutex;
  std::set<Stoppable*> running;
  std::set<const WithoutLock*> unlocked;
  std::condition_variable left;
  std::optional<std::thread::id> ending;  // the thread that ends Python

  static Present& Now() {
    static auto& now = *new Present;  // threads may look when the process ends
    return now;
  }

  [[nodiscard]] bool EndsForThisThread() const {
    return ending && *ending != std::this_thread::get_id();
  }

 private:
  // No thread but the one that forks is there after it, and none of them holds the mutex.
  Present() {
    pthread_atfork([] { Now().mutex.lock(); },
                   [] { Now().mutex.unlock(); },
                   [] {
                     Now().running.clear();
                     Now().unlocked.clear();
                     Now().mutex.unlock();
                   });
  }
};

[[noreturn]] void StayForGood() {
  while (true) pause();
}

// What is at work stands in the list, from its beginning to its end.
struct Listed {
  explicit Listed(Stoppable& work) : of(&work) {
    const std::lock_guard lock(Present::Now().mutex);
    Present::Now().running.insert(of);
  }
  ~Listed() {
    const std::lock_guard lock(Present::Now().mutex);
    Present::Now().running.erase(of);
  }
  Listed(const Listed&) = delete;
  Listed& operator=(const Listed&) = delete;
  Stoppable* of;
};

// Threads that wait for work, as many as ever worked at once. They stay: of every thread that has
// used its arena oneTBB keeps some kilobytes for good.
class Workers {
 public:
  static Workers& All() {
    static auto& all = *new Workers;  // threads may wait for it when the process ends
    return all;
  }

  void Run(std::function<void()> job, std::function<void()> ended) {
    Worker* worker = nullptr;
    {
      const std::lock_guard lock(mutex_);
      if (!idle_.empty()) {
        worker = idle_.back();
        idle_.pop_back();
      }
    }
    if (worker == nullptr) {
      auto made = std::make_unique<Worker>();
      worker = made.get();
      std::thread([this, own = std::move(made)] { Serve(*own); }).detach();
    }
    const std::lock_guard lock(worker->mutex);
    worker->job = std::move(job);
    worker->ended = std::move(ended);
    worker->wake.notify_one();
  }

 private:
  struct Worker {
    std::mutex mutex;
    std::condition_variable wake;
    std::function<void()> job;
    std::function<void()> ended;
  };

  // No thread but the one that forks is there after it.
  Workers() {
    pthread_atfork(nullptr, nullptr, [] { All().idle_.clear(); });
  }

  void Serve(Worker& worker) {
    while (true) {
      std::unique_lock lock(worker.mutex);
      worker.wake.wait(lock, [&] { return static_cast<bool>(worker.job); });
      const auto job = std::exchange(worker.job, nullptr);
      const auto ended = std::exchange(worker.ended, nullptr);
      lock.unlock();
      job();
      {
        const std::lock_guard own(mutex_);
        idle_.push_back(&worker);
      }
      ended();  // who waits may come with more work at once, and finds this one idle
    }
  }

  std::mutex mutex_;
  std::vector<Worker*> idle_;
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
  const auto kept = std::make_shared<Shared>();  // the worker leaves it last
  Shared& shared = *kept;
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
    const WithoutLock unlocked;
    std::optional<tbb::global_control> limit;
    if (threads > 0) {
      limit.emplace(tbb::global_control::max_allowed_parallelism,
                    static_cast<std::size_t>(threads));
    }
    Workers::All().Run(
        [&] {
          try {
            stoppable.Run([&] { work(tell); });
          } catch (...) {
            shared.error = std::current_exception();
          }
        },
        [kept] {
          const std::lock_guard lock(kept->mutex);
          kept->done = true;
          kept->ended.notify_one();
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
    if (interrupted) {
      stoppable.Stop();
      std::unique_lock lock(shared.mutex);
      shared.ended.wait(lock, [&] { return shared.done; });
    }
  }
  if (interrupted) std::rethrow_exception(interrupted);
  if (shared.error) std::rethrow_exception(shared.error);
  if (told) progress(1.0, "done");
}

void StopAllWork() {
  const std::lock_guard lock(Present::Now().mutex);
  for (Stoppable* work : Present::Now().running) work->Stop();
}

WithoutLock::WithoutLock() : state_(PyEval_SaveThread()) {
  Present& now = Present::Now();
  std::unique_lock lock(now.mutex);
  if (now.EndsForThisThread()) {
    lock.unlock();
    StayForGood();
  }
  now.unlocked.insert(this);
}

// EndWork() waits for this one, without the lock, until it has the lock or stays.
WithoutLock::~WithoutLock() {
  Present& now = Present::Now();
  const auto leave = [&] {
    now.unlocked.erase(this);
    now.left.notify_all();
  };
  std::unique_lock lock(now.mutex);
  if (now.EndsForThisThread()) {
    leave();
    lock.unlock();
    StayForGood();
  }
  lock.unlock();
  PyEval_RestoreThread(state_);
  lock.lock();
  leave();
}

void EndWork() {
  constexpr auto kLongest = 10s;  // for what cannot be stopped: a file that is read
  Present& now = Present::Now();
  PyThreadState* const state = PyEval_SaveThread();
  {
    const std::lock_guard lock(now.mutex);
    now.ending = std::this_thread::get_id();
  }
  StopAllWork();
  {
    std::unique_lock lock(now.mutex);
    now.left.wait_for(lock, kLongest, [&] { return now.unlocked.empty(); });
  }
  PyEval_RestoreThread(state);
}

bool HasEnded() {
  const std::lock_guard lock(Present::Now().mutex);
  return Present::Now().EndsForThisThread();
}

}  // namespace lipoid::python
