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

// For a thread that calls functions which take seconds and cannot be interrupted, such as the readers of meshes, and that has to end at
// once when it is stopped: each call runs in a thread of its own, for which nobody waits after stop(). RT: no. Threads: call() and sleep()
// from one, stop() from any.
class StoppableCalls {
 public:
  // The value that the function returns; none: stop() came first, and the value will be dropped. Pre: the function owns, or shares,
  // all that it uses, since it may outlive this object, and run on while the program ends: it uses no static object that has a destructor.
  // It throws nothing.
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

  // Sleeps for `time`. False: stop() ended the sleep, or came before it.
  bool sleep(std::chrono::milliseconds time) {
    std::unique_lock lock(state_->mutex);
    return !state_->changed.wait_for(lock, time, [&] { return state_->is_stopped; });
  }

  // Ends the present call or sleep at once, and all later ones.
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
  // Shared with threads that may outlive this object.
  struct State {
    std::mutex mutex;
    std::condition_variable changed;
    bool is_stopped = false;
  };
  std::shared_ptr<State> state_ = std::make_shared<State>();
};

}  // namespace hapton
