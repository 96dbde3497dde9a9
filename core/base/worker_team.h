#pragma once

#include <memory>

namespace hapton {

// Workers that run one function at the same time. Code in core divides its work through this interface and uses no threads itself;
// WorkerThreads (runtime/worker_threads.h) implements it with threads.
// Threads: run is called by one thread at a time. RT: no force step may call run: it waits for other threads.
class WorkerTeam {
 public:
  // The largest number of workers, including the calling thread. Chosen freely.
  static constexpr int kMaxWorkers = 64;

  virtual ~WorkerTeam() = default;

  virtual int size() const noexcept = 0;  // including the calling thread: 1 to kMaxWorkers

  // Calls work(worker) for each worker, 0 to size() - 1, at the same time, and returns when all have returned.
  template <class Work>
  void run(const Work& work) noexcept {
    run_each([](const void* context, int worker) noexcept { (*static_cast<const Work*>(context))(worker); }, std::addressof(work));
  }

 protected:
  using Function = void (*)(const void* context, int worker) noexcept;
  virtual void run_each(Function function, const void* context) noexcept = 0;
};

// The team whose only worker is the calling thread; any number of threads may use it at the same time.
inline WorkerTeam& calling_thread() noexcept {
  class CallingThreadTeam final : public WorkerTeam {
   public:
    int size() const noexcept override { return 1; }

   private:
    void run_each(Function function, const void* context) noexcept override { function(context, 0); }
  };
  static CallingThreadTeam team;
  return team;
}

}  // namespace hapton
