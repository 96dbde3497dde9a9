#include "runtime/thread_usage.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace hapton {
namespace {

TEST(ThreadUsage, OfAThreadThatWorksGrows) {
  const auto before = read_thread_usage(current_thread_id());
  ASSERT_TRUE(before);
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  std::optional<ThreadUsage> after;
  do {
    std::atomic<int> work{0};
    while (work.fetch_add(1, std::memory_order_relaxed) < 5'000'000) {
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    after = read_thread_usage(current_thread_id());
    ASSERT_TRUE(after);
  } while (after->run_s <= before->run_s && std::chrono::steady_clock::now() < deadline);
  EXPECT_GT(after->run_s, before->run_s);
  EXPECT_GT(after->voluntary_switches, before->voluntary_switches);
  EXPECT_GE(after->waited_s, before->waited_s);
  EXPECT_GE(after->involuntary_switches, before->involuntary_switches);
  EXPECT_GE(after->stolen_s, 0.0);
}

TEST(ThreadUsage, AThreadThatHasEndedHasNoUsage) {
  pid_t ended = -1;
  std::thread([&] { ended = current_thread_id(); }).join();
  ASSERT_GT(ended, 0);
  EXPECT_FALSE(read_thread_usage(ended));
  EXPECT_FALSE(read_thread_usage(-1)) << "no thread at all";
}

TEST(RealtimeShare, IsAShareWhereTheSystemProvidesIt) {
  const auto share = read_realtime_share();
  if (!share) GTEST_SKIP() << "this kernel does not say how it throttles real-time threads";
  EXPECT_GE(*share, 0.0);
  EXPECT_LE(*share, 1.0);
}

}  // namespace
}  // namespace hapton
