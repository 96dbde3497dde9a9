#include "watchdog/outer_watchdog.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "tests/support/open_files.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

using Verdict = OuterWatchdog::Verdict;

struct OuterWatchdogTest : testing::Test {
  // io_node in normal operation: a cycle and a new force each millisecond; the watchdog checks every 2 ms.
  Verdict run_normally(int checks) {
    Verdict verdict = Verdict::fine;
    for (int n = 0; n < checks; ++n) {
      now_ns += OuterWatchdog::kCheckPeriodNs;
      page.heartbeat_ns = now_ns - kMs / 2;
      page.force_sample_ns = now_ns - kMs / 2;
      verdict = watchdog.check(page, false, now_ns);
    }
    return verdict;
  }
  // From now on the page stays as it is: time until the verdict is `expected`; below 0: not within 200 ms.
  double noticed_after_ms(Verdict expected) {
    const std::int64_t begin_ns = now_ns;
    while (now_ns - begin_ns < 200 * kMs) {
      now_ns += OuterWatchdog::kCheckPeriodNs;
      if (watchdog.check(page, false, now_ns) == expected) return 1e-6 * static_cast<double>(now_ns - begin_ns);
    }
    return -1.0;
  }
  HeartbeatPage page;
  OuterWatchdog watchdog;
  std::int64_t now_ns = 1000 * kMs;
};

TEST_F(OuterWatchdogTest, ALivingLoopIsLeftAlone) { EXPECT_EQ(run_normally(10'000), Verdict::fine); }

TEST_F(OuterWatchdogTest, AFrozenLoopWithAForceOutIsNoticedWithin30Ms) {
  run_normally(100);
  const double after_ms = noticed_after_ms(Verdict::frozen);
  EXPECT_GT(after_ms, 20.0);
  EXPECT_LE(after_ms, 30.0);
  EXPECT_GT(watchdog.force_age_ns(), 20 * kMs);
}

// 21 ms without a cycle, or 30 ms with the force of one sample; then 4 ms more, as the machine may have stood still. To the nanosecond.
TEST_F(OuterWatchdogTest, EachLimitIsReachedAtItsOwnTime) {
  const std::int64_t grace_ns = 4 * kMs;
  for (const bool is_frozen : {true, false}) {
    const std::int64_t limit_ns = (is_frozen ? 21 : 30) * kMs;
    for (const std::int64_t early_ns : {0, 1}) {
      run_normally(2);
      const std::int64_t begin_ns = now_ns;
      page.heartbeat_ns = page.force_sample_ns = begin_ns;
      const auto check_after = [&](std::int64_t after_ns) {
        now_ns = begin_ns + after_ns;
        if (!is_frozen) page.heartbeat_ns = now_ns;
        return watchdog.check(page, false, now_ns);
      };
      EXPECT_EQ(check_after(limit_ns - early_ns), Verdict::fine) << "it may be the whole machine";
      const Verdict expected = early_ns > 0 ? Verdict::fine : is_frozen ? Verdict::frozen : Verdict::stale;
      EXPECT_EQ(check_after(limit_ns - early_ns + grace_ns), expected) << is_frozen << early_ns;
    }
  }
}

TEST_F(OuterWatchdogTest, WithoutAForceThereIsNothingToTakeAway) {
  run_normally(100);
  page.force_sample_ns = 0;
  EXPECT_LT(noticed_after_ms(Verdict::frozen), 0.0);
  EXPECT_EQ(watchdog.check(page, true, now_ns), Verdict::fine);
}

// The barrier against a device side that is alive, but holds a force because of a fault in its governor.
TEST_F(OuterWatchdogTest, ALoopThatHoldsAForceIsNoticed) {
  run_normally(100);
  const std::int64_t begin_ns = now_ns;
  Verdict verdict = Verdict::fine;
  while (verdict == Verdict::fine && now_ns - begin_ns < 200 * kMs) {
    now_ns += OuterWatchdog::kCheckPeriodNs;
    page.heartbeat_ns = now_ns;
    verdict = watchdog.check(page, false, now_ns);
  }
  EXPECT_EQ(verdict, Verdict::stale);
  EXPECT_LE(now_ns - begin_ns, 40 * kMs);
}

TEST_F(OuterWatchdogTest, AProcessThatEndedWithAForceOutIsNoticedAtOnce) {
  run_normally(100);
  now_ns += 1;
  EXPECT_EQ(watchdog.check(page, true, now_ns), Verdict::gone);
}

// A suspended machine stops io_node and watchdog: io_node looks frozen at first, and gets the time to show that it is not.
TEST_F(OuterWatchdogTest, AMachineThatStoodStillIsNoFault) {
  run_normally(100);
  now_ns += 5000 * kMs;
  EXPECT_EQ(watchdog.check(page, false, now_ns), Verdict::fine);
  EXPECT_EQ(run_normally(10), Verdict::fine);
}

// A watchdog that gets little CPU time checks rarely, and must still detect the stall.
TEST_F(OuterWatchdogTest, HoweverRareTheChecksAreTheSecondFailedOneTrips) {
  run_normally(100);
  for (const std::int64_t every_ns : {5 * kMs, 9 * kMs, 40 * kMs, 400 * kMs}) {
    run_normally(100);
    Verdict verdict = Verdict::fine;
    now_ns += 25 * kMs;
    verdict = watchdog.check(page, false, now_ns);
    EXPECT_EQ(verdict, Verdict::fine);
    now_ns += every_ns;
    EXPECT_EQ(watchdog.check(page, false, now_ns), Verdict::frozen) << every_ns;
  }
}

TEST_F(OuterWatchdogTest, OneFailedCheckIsNotEnough) {
  run_normally(100);
  page.heartbeat_ns = now_ns - 25 * kMs;
  now_ns += OuterWatchdog::kCheckPeriodNs;
  EXPECT_EQ(watchdog.check(page, false, now_ns), Verdict::fine);
  EXPECT_EQ(run_normally(1), Verdict::fine);
}

WatchedProcess& no_process() {
  static WatchedProcess none;
  return none;
}

TEST(ForceCutterTest, SwitchesAHidDeviceOffByItsOwnHandle) {
  ScratchFolder folder;
  const std::string path = (folder.path() / "hidraw").string();
  std::ofstream(path).flush();
  const auto page = std::make_unique<HeartbeatPage>();
  ForceCutter cutter(*page, no_process());
  EXPECT_FALSE(cutter.cut()) << "nothing is known of the device yet";
  const std::uint8_t off_report[] = {2, 0, 0, 7};
  page->set_hid(path, off_report);
  cutter.prepare();
  // The device's file can no longer be opened by its name, but the handle was opened before.
  std::filesystem::rename(path, path + ".gone");
  EXPECT_TRUE(cutter.cut());
  std::stringstream written;
  written << std::ifstream(path + ".gone").rdbuf();
  EXPECT_EQ(written.str(), std::string({2, 0, 0, 7}));
}

// Opening may fail for a while: no permission yet, or no free file descriptor.
TEST(ForceCutterTest, OpensADeviceThatCouldNotBeOpenedAtFirst) {
  ScratchFolder folder;
  const std::string path = (folder.path() / "hidraw").string();
  const auto page = std::make_unique<HeartbeatPage>();
  ForceCutter cutter(*page, no_process());
  page->set_hid(path, std::vector<std::uint8_t>{1});
  cutter.prepare();
  EXPECT_FALSE(cutter.cut());
  std::ofstream(path).flush();
  cutter.prepare();
  EXPECT_TRUE(cutter.cut());
}

TEST(ForceCutterTest, FollowsADeviceThatWasPluggedInAgain) {
  ScratchFolder folder;
  const auto page = std::make_unique<HeartbeatPage>();
  ForceCutter cutter(*page, no_process());
  for (const char* name : {"hidraw0", "hidraw1"}) {
    const std::string path = (folder.path() / name).string();
    std::ofstream(path).flush();
    page->set_hid(path, std::vector<std::uint8_t>{1});
    EXPECT_TRUE(cutter.cut());
    EXPECT_EQ(std::filesystem::file_size(path), 1U);
  }
}

// While a process has an unplugged device open, the kernel gives its node to no device: the device would come back at another node. Once
// closed, the node may get a device that is not ours. A pipe whose reader has closed it hangs up like a device that was unplugged.
TEST(ForceCutterTest, ClosesADeviceThatWasUnpluggedUntilThePageNamesOneAgain) {
  ScratchFolder folder;
  const std::string path = (folder.path() / "hidraw").string();
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  int device = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  ASSERT_GE(device, 0);
  const auto is_open_elsewhere = [&] {
    std::uint8_t byte = 0;
    return ::read(device, &byte, 1) < 0 && errno == EAGAIN;
  };
  const auto page = std::make_unique<HeartbeatPage>();
  ForceCutter cutter(*page, no_process());
  page->set_hid(path, std::vector<std::uint8_t>{1});
  cutter.prepare();
  EXPECT_TRUE(is_open_elsewhere());
  ::close(device);
  cutter.prepare();
  device = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  EXPECT_FALSE(is_open_elsewhere());
  EXPECT_FALSE(cutter.cut());
  EXPECT_FALSE(is_open_elsewhere()) << "what has its node now may be another device";
  EXPECT_NE(cutter.describe().find("unplugged"), std::string::npos) << cutter.describe();
  page->set_hid(path, std::vector<std::uint8_t>{1});
  EXPECT_TRUE(cutter.cut());
  EXPECT_NE(cutter.describe().find("released the force"), std::string::npos) << cutter.describe();
  std::uint8_t written = 0;
  EXPECT_EQ(::read(device, &written, 1), 1);
  EXPECT_EQ(written, 1);
  ::close(device);
}

TEST(ForceCutterTest, ADeviceThatIsPluggedInOftenIsOpenOnce) {
  ScratchFolder folder;
  const std::string path = (folder.path() / "hidraw").string();
  std::ofstream(path).flush();
  const auto page = std::make_unique<HeartbeatPage>();
  EXPECT_FALSE(leaves_files_open([&] {
    ForceCutter cutter(*page, no_process());
    for (int n = 0; n < 2; ++n) {
      page->set_hid(path, std::vector<std::uint8_t>{1});
      cutter.prepare();
    }
  }));
}

TEST(ForceCutterTest, ClosesNoFileButItsOwn) {
  ScratchFolder folder;
  const auto page = std::make_unique<HeartbeatPage>();
  {
    ForceCutter cutter(*page, no_process());
    const std::string path = (folder.path() / "hidraw").string();
    std::ofstream(path).flush();
    page->set_hid(path, std::vector<std::uint8_t>{1});
    cutter.prepare();
    page->set_hid("", std::vector<std::uint8_t>{1});
    cutter.prepare();
  }
  EXPECT_NE(::fcntl(STDOUT_FILENO, F_GETFD), -1);
}

TEST(ForceCutterTest, AReportThatIsTooLongMakesItADeviceWithoutMeans) {
  const auto page = std::make_unique<HeartbeatPage>();
  page->set_hid("/dev/hidraw0", std::vector<std::uint8_t>(HeartbeatPage::kMaxReport + 1));
  EXPECT_EQ(page->means.load(), CutMeans::none);
  ForceCutter cutter(*page, no_process());
  EXPECT_FALSE(cutter.cut());
}

TEST(ForceCutterTest, KillsWhatHoldsAVendorsLibrary) {
  const pid_t child = ::fork();
  if (child == 0) {
    for (;;) ::pause();
  }
  ::kill(child, SIGSTOP);  // stopped, as a frozen io_node is
  const auto page = std::make_unique<HeartbeatPage>();
  page->set_means(CutMeans::kill);
  WatchedProcess process{.file = static_cast<int>(::syscall(SYS_pidfd_open, child, 0))};
  ASSERT_GE(process.file, 0);
  ForceCutter cutter(*page, process);
  ForceCutter other(*page, process);
  EXPECT_TRUE(cutter.cut());
  EXPECT_NE(cutter.describe().find("killed io_node"), std::string::npos) << cutter.describe();
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
  // Its process id is free now: the next process with that id must not be killed. All threads of the watchdog know that it was killed.
  for (ForceCutter* each : {&cutter, &other}) {
    EXPECT_TRUE(each->cut());
    EXPECT_NE(each->describe().find("killed io_node"), std::string::npos) << each->describe();
  }
  WatchedProcess ended{.file = process.file};
  ForceCutter late(*page, ended);
  EXPECT_TRUE(late.cut());
  EXPECT_NE(late.describe().find("its end closed the vendor's library"), std::string::npos) << late.describe();
  EXPECT_FALSE(ended.is_killed);
  ::close(process.file);
}

TEST(ForceCutterTest, AnInvalidProcessFileIsNoEnd) {
  const auto page = std::make_unique<HeartbeatPage>();
  page->set_means(CutMeans::kill);
  WatchedProcess closed{.file = 1 << 20};
  ForceCutter cutter(*page, closed);
  EXPECT_FALSE(cutter.cut());
  EXPECT_FALSE(closed.is_killed);
  EXPECT_FALSE(ForceCutter(*page, no_process()).cut());
}

// The device is unplugged when the page gets its means.
TEST(ForceCutterTest, ADeviceWithoutANodeIsUnplugged) {
  const auto page = std::make_unique<HeartbeatPage>();
  page->set_means(CutMeans::hid);
  ForceCutter cutter(*page, no_process());
  for (int n = 0; n < 2; ++n) {
    EXPECT_FALSE(cutter.cut());
    EXPECT_NE(cutter.describe().find("unplugged"), std::string::npos) << cutter.describe();
    page->set_hid("", std::vector<std::uint8_t>{1});
  }
}

TEST(ForceCutterTest, APageThatIsBeingWrittenIsNotRead) {
  ScratchFolder folder;
  const std::string path = (folder.path() / "hidraw").string();
  std::ofstream(path).flush();
  const auto page = std::make_unique<HeartbeatPage>();
  ForceCutter cutter(*page, no_process());
  page->set_hid(path, std::vector<std::uint8_t>{1});
  page->generation.fetch_add(1);  // odd: another device is being named
  EXPECT_FALSE(cutter.cut());
  EXPECT_EQ(std::filesystem::file_size(path), 0U);
  page->generation.fetch_add(1);
  EXPECT_TRUE(cutter.cut());
}

// The write fails, as for a device that was unplugged: nothing was turned off, and a person must know.
TEST(ForceCutterTest, ReportsNoReleaseThatFailed) {
  const auto page = std::make_unique<HeartbeatPage>();
  ForceCutter cutter(*page, no_process());
  page->set_hid("/dev/full", std::vector<std::uint8_t>{1});
  ASSERT_FALSE(cutter.cut());
  EXPECT_EQ(cutter.describe().find("released"), std::string::npos) << cutter.describe();
  EXPECT_NE(cutter.describe().find("could not turn the device off"), std::string::npos) << cutter.describe();
  // The failed write does not count for another device.
  page->set_hid("/dev/null", std::vector<std::uint8_t>{1});
  EXPECT_TRUE(cutter.cut());
  EXPECT_NE(cutter.describe().find("released the force"), std::string::npos) << cutter.describe();
}

TEST(ForceCutterTest, SaysWhatItDidByItsMeans) {
  ScratchFolder folder;
  const std::string path = (folder.path() / "hidraw").string();
  std::ofstream(path).flush();
  const auto page = std::make_unique<HeartbeatPage>();
  ForceCutter cutter(*page, no_process());
  const auto says = [&](const char* words) { return cutter.describe().find(words) != std::string::npos; };
  EXPECT_TRUE(says("no means")) << cutter.describe();
  page->set_hid(path, std::vector<std::uint8_t>{1});
  cutter.prepare();
  EXPECT_TRUE(says("device off")) << cutter.describe();
  page->set_hid(path + ".gone", std::vector<std::uint8_t>{1});
  EXPECT_FALSE(cutter.cut());
  EXPECT_TRUE(says("could not open the device")) << cutter.describe();
  page->set_means(CutMeans::kill);
  EXPECT_TRUE(says("its end closed the vendor's library")) << cutter.describe() << ": there is no process to kill";
  page->set_means(CutMeans::simulated);
  EXPECT_TRUE(cutter.cut());
  EXPECT_TRUE(says("simulated motors")) << cutter.describe();
  page->set_means(CutMeans::no_motors);
  EXPECT_TRUE(cutter.cut());
  EXPECT_TRUE(says("no motors")) << cutter.describe();
}

}  // namespace
}  // namespace hapton
