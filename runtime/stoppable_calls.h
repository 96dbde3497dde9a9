#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <type_traits>
#include <utility>

#include "runtime/start_thread.h"

namespace hapton {

// For a thread that calls what takes seconds and cannot be interrupted, as the readers of meshes, and yet has to end at once when it is
// stopped: the call runs in a thread of its own, which nobody waits for then. RT: no. Threads: call() and sleep() from one, stop() from
// any.
class StoppableCalls {
 public:
  // What the function returns; none: stop() came first, and the result is dropped when it is there. Pre: the function owns, or shares, all
  // that it uses, since it may outlive this, and runs on while the program ends: it uses no static object that has a destructor. It throws
  // nothing.
  template <class Function, class Value = std::invoke_result_t<Function>>
  std::optional<Value> call(Function function) {
    const auto result = std::make_shared<std::optional<Value>>();
    if (is_stopped()) return std::nullopt;
    start_thread([state = state_, result, function = std::move(function)] {
      Value value = function();
      const std::lock_guard lock(state->mutex);
      *result = std::move(value);
      state->changed.notify_all();
    }).detach();
    std::unique_lock lock(state_->mutex);
    state_->changed.wait(lock, [&] { return state_->is_stopped || result->has_value(); });
    if (state_->is_stopped) return std::nullopt;
    return std::move(*result);
  }

  // False: it was stopped.
  bool sleep(std::chrono::milliseconds time) {
    std::unique_lock lock(state_->mutex);
    return !state_->changed.wait_for(lock, time, [&] { return state_->is_stopped; });
  }

  // Ends the calls and the sleep of now, and all later ones.
  void stop() {
    const std::lock_guard lock(state_->mutex);
    state_->is_stopped = true;
    state_->changed.notify_all();
  }
  bool is_stopped() const {
    const std::lock_guard lock(state_->mutex);
    return state_->is_stopped;
  }

 private:
  // Shared with threads that may outlive this.
  struct State {
    std::mutex mutex;
    std::condition_variable changed;
    bool is_stopped = false;
  };
  std::shared_ptr<State> state_ = std::make_shared<State>();
};

}  // namespace hapton
