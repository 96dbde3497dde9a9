#include "tools/soak/process_stats.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <unistd.h>

#include <mutex>
#include <thread>

namespace hapton {
namespace {

TEST(ProcessStats, SeeOneDescriptorAndOneThreadMore) {
  std::thread([] {}).join();  // a sanitizer's own thread begins with the first
  const auto before = read_process_figures(::getpid());
  ASSERT_TRUE(before) << before.error().what;
  EXPECT_GT(before->resident_kib, 100);
  const int opened = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  std::mutex gate;
  gate.lock();
  std::thread waits([&] { const std::lock_guard pass(gate); });
  const auto with = read_process_figures(::getpid());
  gate.unlock();
  waits.join();
  ::close(opened);
  ASSERT_TRUE(with);
  EXPECT_EQ(with->descriptors, before->descriptors + 1);
  EXPECT_EQ(with->threads, before->threads + 1);
}

TEST(ProcessStats, OfNoProcessAreAnError) { EXPECT_FALSE(read_process_figures(-1)); }

}  // namespace
}  // namespace hapton
