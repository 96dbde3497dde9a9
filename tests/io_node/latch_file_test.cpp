#include "io_node/latch_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

namespace hapton {
namespace {

struct Latch : testing::Test {
  Latch() { std::filesystem::create_directories(folder); }
  ~Latch() override { std::filesystem::remove_all(folder); }
  std::filesystem::path folder = std::filesystem::temp_directory_path() / fmt::format("hapton_latch_{}", getpid());
  LatchFile file{folder / "hapton" / "latched"};
};

TEST_F(Latch, KeepsEachFaultUntilItIsForgotten) {
  EXPECT_EQ(file.read(), SafetyFault::none);
  for (int n = 1; n < kSafetyFaults; ++n) {
    ASSERT_TRUE(file.keep(static_cast<SafetyFault>(n)));
    EXPECT_EQ(LatchFile(file.path()).read(), static_cast<SafetyFault>(n));
  }
  struct stat status = {};
  ASSERT_EQ(::stat(file.path().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
  file.forget();
  EXPECT_FALSE(std::filesystem::exists(file.path()));
  EXPECT_EQ(file.read(), SafetyFault::none);
  file.forget();
}

TEST_F(Latch, WhatIsNotUnderstoodCountsAsAFault) {
  for (const char* text : {"", "none\n", "speed", "SPEED\n", "speed\nspeed\n", "no such fault\n"}) {
    std::filesystem::create_directories(file.path().parent_path());
    std::ofstream(file.path()) << text;
    EXPECT_EQ(file.read(), SafetyFault::position) << text;
  }
  file.forget();
  ASSERT_EQ(::mkfifo(file.path().c_str(), 0600), 0);
  EXPECT_EQ(file.read(), SafetyFault::position);
  file.forget();
  EXPECT_EQ(file.read(), SafetyFault::none);
}

TEST_F(Latch, WithoutAFileKeepsNothingAndSaysWhenItCannotWrite) {
  const LatchFile nowhere{std::filesystem::path()};
  EXPECT_TRUE(nowhere.keep(SafetyFault::speed));
  EXPECT_EQ(nowhere.read(), SafetyFault::none);
  EXPECT_FALSE(LatchFile("/proc/hapton/latched").keep(SafetyFault::speed));
}

TEST_F(Latch, HasAFileForEachDeviceAndHub) {
  ::setenv("RUNTIME_DIRECTORY", folder.c_str(), 1);
  EXPECT_EQ(find_latch_file("haply", "127.0.0.1:4950"), folder / "latched-haply-127.0.0.1_4950");
  EXPECT_EQ(find_latch_file("../x", "[::]:1/2"), folder / "latched-.._x-_____1_2");
  EXPECT_NE(find_latch_file("haply", "127.0.0.1:4950"), find_latch_file("haply", "127.0.0.1:4951"));
  ::unsetenv("RUNTIME_DIRECTORY");
}

}  // namespace
}  // namespace hapton
