#include "tools/soak/process_stats.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <unistd.h>

#include <mutex>
#include <thread>

namespace hapton {
namespace {

TEST(ProcessStats, SeeOneDescriptorAndOneThreadMore) {
  std::mutex mutex;
  mutex.lock();
  const auto wait = [&] { const std::lock_guard lock(mutex); };
  // A sanitizer starts its own thread together with `first`, which keeps running: a thread that was joined may still count for a moment.
  std::thread first(wait);
  const auto before = read_process_stats(::getpid());
  const int descriptor = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  std::thread second(wait);
  const auto after = read_process_stats(::getpid());
  mutex.unlock();
  first.join();
  second.join();
  ::close(descriptor);
  ASSERT_TRUE(before && after);
  EXPECT_GT(before->resident_kib, 100);
  EXPECT_EQ(after->descriptors, before->descriptors + 1);
  EXPECT_EQ(after->threads, before->threads + 1);
}

TEST(ProcessStats, AnUnknownProcessIsAnError) { EXPECT_FALSE(read_process_stats(-1)); }

}  // namespace
}  // namespace hapton
