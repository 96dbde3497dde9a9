#include "core/base/worker_team.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/thread_team.h"

namespace hapton {
namespace {

TEST(WorkerTeam, EachWorkerIsCalledOnce) {
  for (const int size : {1, 2, 5}) {
    made::ThreadTeam team(size);
    std::vector<int> calls(static_cast<std::size_t>(size));
    team.run([&](int worker) { ++calls[static_cast<std::size_t>(worker)]; });
    EXPECT_EQ(calls, std::vector<int>(static_cast<std::size_t>(size), 1));
  }
}

TEST(WorkerTeam, TheCallingThreadIsATeamOfOne) {
  std::vector<int> workers;
  const auto caller = std::this_thread::get_id();
  calling_thread().run([&](int worker) {
    EXPECT_EQ(std::this_thread::get_id(), caller);
    workers.push_back(worker);
  });
  EXPECT_EQ(calling_thread().size(), 1);
  EXPECT_EQ(workers, std::vector<int>{0});
}

}  // namespace
}  // namespace hapton
