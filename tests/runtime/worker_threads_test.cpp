#include "runtime/worker_threads.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <numeric>
#include <thread>
#include <vector>

namespace hapton {
namespace {

TEST(WorkerThreads, EachCallIsMadeByAllAndHasEndedWhenRunReturns) {
  for (const int size : {1, 2, 4, 9}) {
    WorkerThreads team(size);
    ASSERT_EQ(team.size(), size);
    std::array<int, 16> calls = {};  // one element for each worker: a sanitizer would see two threads in one element
    for (int call = 1; call <= 2000; ++call) {
      team.run([&](int worker) { ++calls[static_cast<std::size_t>(worker)]; });
      for (int worker = 0; worker < size; ++worker) ASSERT_EQ(calls[static_cast<std::size_t>(worker)], call) << worker << " of " << size;
    }
  }
}

TEST(WorkerThreads, ATeamThatSleepsIsWoken) {
  WorkerThreads team(3);
  std::atomic<int> calls = 0;
  for (int call = 1; call <= 5; ++call) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    team.run([&](int) { ++calls; });
    EXPECT_EQ(calls, 3 * call);
  }
}

TEST(WorkerThreads, RunWaitsForTheSlowest) {
  WorkerThreads team(3);
  std::atomic<int> ended = 0;
  team.run([&](int worker) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10 * worker));
    ++ended;
  });
  EXPECT_EQ(ended, 3);
}

TEST(WorkerThreads, WorkIsSharedOut) {
  WorkerThreads team(2);
  std::vector<int> done(100'000);
  std::atomic<std::size_t> next = 0;
  team.run([&](int) {
    for (std::size_t i = next++; i < done.size(); i = next++) ++done[i];
  });
  EXPECT_EQ(std::accumulate(done.begin(), done.end(), 0), 100'000);
  EXPECT_EQ(done, std::vector<int>(done.size(), 1));
}

}  // namespace
}  // namespace hapton
