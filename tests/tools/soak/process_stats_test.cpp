#include "tools/soak/process_stats.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <unistd.h>

#include <mutex>
#include <thread>

namespace hapton {
namespace {

TEST(ProcessStats, SeeOneDescriptorAndOneThreadMore) {
  std::mutex gate;
  gate.lock();
  const auto wait = [&] { const std::lock_guard pass(gate); };
  // A sanitizer starts its own thread together with `first`, which keeps running: a thread that was joined may still count for a moment.
  std::thread first(wait);
  const auto before = read_process_stats(::getpid());
  const int opened = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  std::thread second(wait);
  const auto with = read_process_stats(::getpid());
  gate.unlock();
  first.join();
  second.join();
  ::close(opened);
  ASSERT_TRUE(before && with);
  EXPECT_GT(before->resident_kib, 100);
  EXPECT_EQ(with->descriptors, before->descriptors + 1);
  EXPECT_EQ(with->threads, before->threads + 1);
}

TEST(ProcessStats, AnUnknownProcessIsAnError) { EXPECT_FALSE(read_process_stats(-1)); }

}  // namespace
}  // namespace hapton
