#pragma once

#include <thread>
#include <vector>

#include "core/base/worker_team.h"

namespace hapton::made {

// Starts new threads in each call: one for each worker except worker 0, which is the calling thread.
class ThreadTeam final : public WorkerTeam {
 public:
  explicit ThreadTeam(int size) : size_(size) {}
  int size() const noexcept override { return size_; }

 private:
  void run_each(Function function, const void* context) noexcept override {
    std::vector<std::thread> threads;
    for (int worker = 1; worker < size_; ++worker) threads.emplace_back([=] { function(context, worker); });
    function(context, 0);
    for (std::thread& thread : threads) thread.join();
  }

  int size_;
};

}  // namespace hapton::made
