#include "runtime/worker_threads.h"

#include "runtime/spin_pause.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

// These spins take about 20 to 50 us. Calls within one step follow each other faster than that, and waking a thread takes 5 to 50 us.
constexpr int kSpins = 2000;

}  // namespace

WorkerThreads::WorkerThreads(int size) {
  for (int worker = 1; worker < size; ++worker) {
    threads_.push_back(start_thread([this, worker] { serve(worker); }));
  }
}

WorkerThreads::~WorkerThreads() {
  must_stop_.store(true, std::memory_order_relaxed);
  calls_.fetch_add(1, std::memory_order_release);
  calls_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void WorkerThreads::run_each(Function function, const void* context) noexcept {
  if (threads_.empty()) return function(context, 0);
  function_ = function;
  context_ = context;
  busy_workers_.store(static_cast<int>(threads_.size()), std::memory_order_relaxed);
  calls_.fetch_add(1, std::memory_order_release);
  calls_.notify_all();
  function(context, 0);
  for (int spins = 0; spins < kSpins && busy_workers_.load(std::memory_order_acquire) != 0; ++spins) spin_pause();
  for (int busy = busy_workers_.load(std::memory_order_acquire); busy != 0; busy = busy_workers_.load(std::memory_order_acquire)) {
    busy_workers_.wait(busy, std::memory_order_acquire);
  }
}

void WorkerThreads::serve(int worker) noexcept {
  std::uint32_t served_calls = 0;
  for (;;) {
    for (int spins = 0; spins < kSpins && calls_.load(std::memory_order_acquire) == served_calls; ++spins) spin_pause();
    calls_.wait(served_calls, std::memory_order_acquire);
    ++served_calls;  // a call begins only when the one before has ended, so none is missed
    if (must_stop_.load(std::memory_order_relaxed)) return;
    function_(context_, worker);
    if (busy_workers_.fetch_sub(1, std::memory_order_acq_rel) == 1) busy_workers_.notify_one();
  }
}

std::unique_ptr<WorkerTeam> make_worker_team(int size) { return size > 1 ? std::make_unique<WorkerThreads>(size) : nullptr; }

}  // namespace hapton
