// hapton_watchdog beside a node that hangs or ends with a force on its motors: what happens to the device, and what is reported.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/support/patience.h"
#include "tests/support/scratch_folder.h"
#include "watchdog/watchdog_supervisor.h"

namespace hapton {
namespace {

constexpr std::array<std::uint8_t, 4> kOffReport = {2, 0, 5, 7};

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

struct WatchedNode : testing::Test {
  void SetUp() override {
    ASSERT_TRUE(memory.make());
    folder.write("hidraw", "");
    folder.write("said", "");
  }
  void TearDown() override {
    if (node <= 0) return;
    ::kill(node, SIGKILL);
    ::waitpid(node, nullptr, 0);
  }
  // Forks a process that starts a watchdog as io_node does, and then has a force on the motors. It ends at once, or hangs.
  void run_node(bool ends) {
    node = ::fork();
    ASSERT_GE(node, 0);
    if (node > 0) return;
    ::alarm(120);  // ends this process if the test was ended
    ::dup2(::open(log_path.c_str(), O_WRONLY | O_TRUNC), STDERR_FILENO);
    WatchdogSupervisor watchdog;
    const bool is_started = watchdog.start(memory, std::filesystem::path(HAPTON_BIN_DIR) / "hapton_watchdog", 0).has_value();
    if (!is_started || !wait_until([&] { return memory.page().watchdog_beat_ns.load() != 0; })) ::_exit(1);
    const std::int64_t now_ns = SteadyClock().now_ns();
    memory.page().heartbeat_ns = now_ns;
    memory.page().force_sample_ns = now_ns;
    if (ends) ::_exit(0);
    for (;;) ::pause();
  }
  // Number of reports in the file. The watchdog's two threads both write from its beginning on, over each other's reports.
  std::size_t count_reports() const { return std::filesystem::file_size(hidraw) / kOffReport.size(); }
  std::size_t times_logged(const std::string& words) const {
    const std::string text = text_of(log_path);
    std::size_t times = 0;
    for (std::size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) ++times;
    return times;
  }

  ScratchFolder folder;
  const std::string hidraw = (folder.path() / "hidraw").string();
  const std::string log_path = (folder.path() / "said").string();
  HeartbeatMemory memory;
  pid_t node = 0;
};

TEST_F(WatchedNode, WhileItHangsItsDeviceIsTurnedOffAgainAndAgain) {
  memory.page().set_hid(hidraw, kOffReport);
  run_node(false);
  ASSERT_TRUE(wait_until([&] { return count_reports() >= 20 && times_logged("io_node is frozen") > 0; }))
      << count_reports() << text_of(log_path);
  EXPECT_EQ(text_of(hidraw).substr(0, 4), std::string({2, 0, 5, 7}));
  EXPECT_EQ(memory.page().cuts.load(), 1U);
  EXPECT_EQ(memory.page().is_cut.load(), 1U);
  EXPECT_EQ(times_logged("released the force (device off)"), 1U) << text_of(log_path);
}

// When io_node ended, one more force may have been on its way to the device.
TEST_F(WatchedNode, WhenItHasEndedItsDeviceIsTurnedOffThreeTimes) {
  memory.page().set_hid(hidraw, kOffReport);
  run_node(true);
  ASSERT_TRUE(wait_until([&] { return times_logged("io_node has ended") > 0; })) << count_reports() << text_of(log_path);
  EXPECT_GE(count_reports(), 3U);
  EXPECT_EQ(memory.page().cuts.load(), 1U);
}

// io_node has started this watchdog to replace another one, and has ended before this one begins.
TEST_F(WatchedNode, WhenItHasEndedBeforeItsWatchdogBeginsTheDeviceIsTurnedOff) {
  memory.page().set_hid(hidraw, kOffReport);
  const auto run_watchdog = [&] {
    const pid_t watchdog = ::fork();
    if (watchdog == 0) {
      ::dup2(::open(log_path.c_str(), O_WRONLY | O_TRUNC), STDERR_FILENO);
      ::dup2(memory.file(), kHeartbeatDescriptor);
      ::fcntl(kHeartbeatDescriptor, F_SETFD, 0);
      ::execl(HAPTON_BIN_DIR "/hapton_watchdog", "hapton_watchdog", "1", "0", nullptr);  // process 1 is not its parent
      ::_exit(1);
    }
    int status = 1;
    ::waitpid(watchdog, &status, 0);
    return status;
  };
  EXPECT_EQ(run_watchdog(), 0);
  EXPECT_EQ(count_reports(), 0U) << "no force";
  memory.page().force_sample_ns = 1;
  EXPECT_EQ(run_watchdog(), 0);
  EXPECT_EQ(count_reports(), 3U);
  EXPECT_EQ(memory.page().cuts.load(), 1U);
  EXPECT_EQ(times_logged("io_node has ended before it was watched"), 1U) << text_of(log_path);
}

TEST_F(WatchedNode, ThatHoldsAVendorsLibraryIsKilledWhenItHangs) {
  memory.page().set_means(CutMeans::kill);
  run_node(false);
  int status = 0;
  ASSERT_TRUE(wait_until([&] { return ::waitpid(node, &status, WNOHANG) == node; }));
  node = 0;
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << status;
}

// A script in place of the watchdog, which writes the arguments that it was started with.
TEST(WatchdogArguments, AreTheNodesProcessAndThePriorityAtEachStart) {
  const ScratchFolder folder;
  const std::filesystem::path words = folder.path() / "words";
  const std::filesystem::path script = folder.write("watchdog", "#!/bin/sh\necho \"$@\" > " + words.string() + ".new\nmv " +
                                                                    words.string() + ".new " + words.string() + "\nexec sleep 60\n");
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  HeartbeatMemory memory;
  ASSERT_TRUE(memory.make());
  WatchdogSupervisor watchdog;
  ASSERT_TRUE(watchdog.start(memory, script, 7));
  EXPECT_TRUE(wait_until([&] { return std::filesystem::exists(words); }));
  EXPECT_EQ(text_of(words), fmt::format("{} 7\n", ::getpid()));
  std::filesystem::remove(words);
  // The script has no heartbeat, so it counts as a watchdog that hangs.
  EXPECT_TRUE(wait_until([&] { return watchdog.restart_if_dead(SteadyClock().now_ns()).has_value(); }));
  EXPECT_TRUE(wait_until([&] { return std::filesystem::exists(words); }));
  EXPECT_EQ(text_of(words), fmt::format("{} 7\n", ::getpid()));
  ::kill(watchdog.id(), SIGKILL);
  ::waitpid(watchdog.id(), nullptr, 0);
}

}  // namespace
}  // namespace hapton
