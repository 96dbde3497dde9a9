#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

#include "core/base/worker_team.h"

namespace hapton {

// A team of the calling thread and worker threads. Between two calls of run the workers spin for a short time, then sleep. RT: run
// allocates nothing; waking a sleeping worker takes a system call.
class WorkerThreads final : public WorkerTeam {
 public:
  // size: including the calling thread. Pre: 1 <= size <= kMaxWorkers.
  explicit WorkerThreads(int size);
  ~WorkerThreads() override;
  WorkerThreads(const WorkerThreads&) = delete;
  WorkerThreads& operator=(const WorkerThreads&) = delete;

  int size() const noexcept override { return static_cast<int>(threads_.size()) + 1; }

 private:
  void run_each(Function function, const void* context) noexcept override;
  void serve(int worker) noexcept;

  Function function_ = nullptr;  // the function of the call whose number is calls_
  const void* context_ = nullptr;
  std::atomic<std::uint32_t> calls_ = 0;
  std::atomic<int> busy_workers_ = 0;  // workers that have not finished
  std::atomic<bool> must_stop_ = false;
  std::vector<std::thread> threads_;
};

// A team of `size` threads; null if it would be only the calling thread. Pre: as WorkerThreads.
std::unique_ptr<WorkerTeam> make_worker_team(int size);

}  // namespace hapton
