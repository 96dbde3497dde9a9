#include "watchdog/watchdog_supervisor.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <malloc.h>
#include <signal.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "runtime/clock.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

// The program that was built beside the nodes.
std::filesystem::path program() { return std::filesystem::path(HAPTON_BIN_DIR) / "hapton_watchdog"; }

struct WatchdogProcessTest : testing::Test {
  void SetUp() override { ASSERT_TRUE(memory.make()); }
  bool wait_until(const std::function<bool()>& holds) {
    const std::int64_t end_ns = clock.now_ns() + 30'000 * kMs;
    for (; clock.now_ns() < end_ns; clock.sleep_until_ns(clock.now_ns() + 5 * kMs)) {
      if (holds()) return true;
    }
    return false;
  }
  SteadyClock clock;
  HeartbeatMemory memory;
  WatchdogSupervisor watchdog;
};

TEST_F(WatchdogProcessTest, BeatsAndIsStartedAgainWhenItDied) {
  ASSERT_TRUE(watchdog.start(memory, program(), 0));
  ASSERT_TRUE(wait_until([&] { return memory.page().watchdog_beat_ns.load() > 0; }));
  EXPECT_FALSE(watchdog.restart_if_dead(clock.now_ns()));
  const pid_t first = watchdog.id();
  ::kill(first, SIGKILL);
  ASSERT_TRUE(wait_until([&] { return watchdog.restart_if_dead(clock.now_ns()).has_value(); }));
  EXPECT_NE(watchdog.id(), first);
  EXPECT_EQ(watchdog.restarts(), 1U);
  ::kill(watchdog.id(), SIGKILL);
}

TEST_F(WatchdogProcessTest, AStalledOneIsReplaced) {
  ASSERT_TRUE(watchdog.start(memory, program(), 0));
  ASSERT_TRUE(wait_until([&] { return memory.page().watchdog_beat_ns.load() > 0; }));
  const pid_t stalled = watchdog.id();
  ::kill(stalled, SIGSTOP);
  ASSERT_TRUE(wait_until([&] { return watchdog.restart_if_dead(clock.now_ns()).has_value(); }));
  EXPECT_NE(watchdog.id(), stalled);
  EXPECT_EQ(::kill(stalled, 0), -1) << "it is gone, and no zombie";
  const std::int64_t replaced_ns = clock.now_ns();
  EXPECT_TRUE(wait_until([&] { return memory.page().watchdog_beat_ns.load() > replaced_ns; }));
  ::kill(watchdog.id(), SIGKILL);
}

// Hides the end of a process from its parent, like an uninterruptible sleep: a tracer learns of the end first, and does not wait for it.
class KeptProcess {
 public:
  explicit KeptProcess(pid_t process) {
    std::array<int, 2> pipe = {};
    if (::pipe(pipe.data()) != 0) return;
    tracer_ = ::fork();
    if (tracer_ == 0) {
      ::alarm(30);  // ends the tracer if the test ends without release()
      const char is_kept = ::ptrace(PTRACE_SEIZE, process, nullptr, nullptr) == 0 ? 1 : 0;
      if (::write(pipe[1], &is_kept, 1) != 1) ::_exit(1);
      while (true) ::pause();
    }
    char is_kept = 0;
    is_kept_ = tracer_ > 0 && ::read(pipe[0], &is_kept, 1) == 1 && is_kept != 0;
    for (const int end : pipe) ::close(end);
  }
  ~KeptProcess() { release(); }
  KeptProcess(const KeptProcess&) = delete;
  KeptProcess& operator=(const KeptProcess&) = delete;

  bool is_kept() const { return is_kept_; }
  void release() {
    if (tracer_ <= 0) return;
    ::kill(tracer_, SIGKILL);
    ::waitpid(tracer_, nullptr, 0);
    tracer_ = 0;
  }

 private:
  pid_t tracer_ = 0;
  bool is_kept_ = false;
};

TEST_F(WatchdogProcessTest, OneThatTheKernelKeepsDoesNotHoldTheNodeUp) {
  ASSERT_TRUE(watchdog.start(memory, program(), 0));
  std::optional<Result<void>> restarted;
  const auto try_restart = [&] {
    restarted = watchdog.restart_if_dead(clock.now_ns());
    return restarted.has_value();
  };
  const auto stall = [&] {
    const std::int64_t since_ns = clock.now_ns();
    EXPECT_TRUE(wait_until([&] { return memory.page().watchdog_beat_ns.load() > since_ns; }));
    ::kill(watchdog.id(), SIGSTOP);
    EXPECT_EQ(::waitpid(watchdog.id(), nullptr, WUNTRACED), watchdog.id());  // before it is traced: a tracer would learn of it first
    return watchdog.id();
  };
  const pid_t first = stall();
  KeptProcess kept_first(first);
  if (!kept_first.is_kept()) {
    ::kill(first, SIGKILL);
    GTEST_SKIP() << "here a process may not trace another one";
  }
  ASSERT_TRUE(wait_until(try_restart));
  EXPECT_TRUE(restarted->has_value());
  EXPECT_EQ(::kill(first, 0), 0) << "it is there still, and nobody waited for it";
  const pid_t second = stall();
  EXPECT_NE(second, first);
  KeptProcess kept_second(second);
  ASSERT_TRUE(wait_until(try_restart));
  ASSERT_FALSE(restarted->has_value()) << "otherwise more and more processes would remain";
  EXPECT_NE(restarted->error().what.find("does not let"), std::string::npos) << restarted->error().what;
  EXPECT_EQ(watchdog.id(), second);
  kept_first.release();
  kept_second.release();
  ASSERT_TRUE(wait_until([&] { return try_restart() && restarted->has_value(); }));
  EXPECT_EQ(watchdog.restarts(), 2U);
  for (const pid_t before : {first, second}) EXPECT_EQ(::kill(before, 0), -1) << "it is gone, and no zombie";
  ::kill(watchdog.id(), SIGKILL);
}

// The watchdog is stopped, and the test writes its heartbeats: a second without one is permitted, a nanosecond more is not. A watchdog that
// has ended is replaced however new its heartbeat is.
TEST_F(WatchdogProcessTest, OneThatBeatsIsLeftAlone) {
  constexpr std::int64_t kWatchdogTimeoutNs = WatchdogSupervisor::kWatchdogTimeoutNs;
  ASSERT_TRUE(watchdog.start(memory, program(), 0));
  const pid_t first = watchdog.id();
  ::kill(first, SIGSTOP);
  ASSERT_EQ(::waitpid(first, nullptr, WUNTRACED), first);
  const std::int64_t later_ns = clock.now_ns() + 2 * kWatchdogTimeoutNs;
  memory.page().watchdog_beat_ns = later_ns - kWatchdogTimeoutNs;
  EXPECT_FALSE(watchdog.restart_if_dead(later_ns));
  EXPECT_EQ(watchdog.id(), first);
  EXPECT_EQ(watchdog.restarts(), 0U);
  EXPECT_EQ(::kill(first, 0), 0);
  memory.page().watchdog_beat_ns = later_ns - kWatchdogTimeoutNs - 1;
  EXPECT_TRUE(watchdog.restart_if_dead(later_ns));
  const pid_t second = watchdog.id();
  EXPECT_NE(second, first);
  EXPECT_EQ(watchdog.restarts(), 1U);
  EXPECT_EQ(::kill(first, 0), -1) << "it is gone, and no zombie";
  ::kill(second, SIGKILL);
  siginfo_t ended = {};
  ASSERT_EQ(::waitid(P_PID, static_cast<id_t>(second), &ended, WEXITED | WNOWAIT), 0);
  const std::int64_t last_ns = clock.now_ns() + 2 * kWatchdogTimeoutNs;
  memory.page().watchdog_beat_ns = last_ns;
  EXPECT_TRUE(watchdog.restart_if_dead(last_ns));
  EXPECT_NE(watchdog.id(), second);
  EXPECT_EQ(watchdog.restarts(), 2U);
  ::kill(watchdog.id(), SIGKILL);
}

// Leaves values other than zero on the stack, as earlier calls may: what start() puts there must not rely on zeros.
[[gnu::noinline]] void fill_the_stack() {
  std::array<volatile unsigned char, 16384> dirt;
  for (auto& byte : dirt) byte = 0xa5;
}

// Ctrl-C at the terminal must reach only the node; and what the node has open, such as its port, must be free once the node has ended.
TEST_F(WatchdogProcessTest, IsAGroupOfItsOwnAndHoldsNothingOfTheNode) {
  std::array<int, 2> pipe = {};
  ASSERT_EQ(::pipe(pipe.data()), 0);  // a child inherits these unless they are closed for it
  fill_the_stack();
  ASSERT_TRUE(watchdog.start(memory, program(), 0));
  ASSERT_TRUE(wait_until([&] { return memory.page().watchdog_beat_ns.load() > 0; }));
  EXPECT_EQ(::getpgid(watchdog.id()), watchdog.id());
  const auto target_of = [&](int file) {
    std::error_code error;
    return std::filesystem::read_symlink(fmt::format("/proc/{}/fd/{}", watchdog.id(), file), error).string();
  };
  for (const int file : pipe) EXPECT_EQ(target_of(file).find("pipe:"), std::string::npos) << file;
  for (const int file : pipe) ::close(file);
  ::kill(watchdog.id(), SIGKILL);
}

// A watchdog has kWatchdogTimeoutNs to begin: before that, restart_if_dead() does not even check whether it has ended.
TEST_F(WatchdogProcessTest, IsNotReplacedBeforeItHadTimeToBegin) {
  ASSERT_TRUE(watchdog.start(memory, program(), 0));
  const std::int64_t started_ns = clock.now_ns();
  ::kill(watchdog.id(), SIGKILL);
  EXPECT_FALSE(watchdog.restart_if_dead(started_ns));
  EXPECT_FALSE(WatchdogSupervisor().restart_if_dead(started_ns + 3'600'000 * kMs)) << "none was started";
  ASSERT_TRUE(wait_until([&] { return watchdog.restart_if_dead(clock.now_ns()).has_value(); }));
  EXPECT_EQ(watchdog.restarts(), 1U);
  ::kill(watchdog.id(), SIGKILL);
}

// The watchdog's program was removed: the node continues, and tries again only after kWatchdogTimeoutNs.
TEST_F(WatchdogProcessTest, WhatCannotBeStartedAgainIsNotTriedAllTheTime) {
  const std::filesystem::path copy = std::filesystem::path(testing::TempDir()) / fmt::format("watchdog_copy_{}", ::getpid());
  std::filesystem::copy_file(program(), copy, std::filesystem::copy_options::overwrite_existing);
  ASSERT_TRUE(watchdog.start(memory, copy, 0));
  ASSERT_TRUE(wait_until([&] { return memory.page().watchdog_beat_ns.load() > 0; }));
  std::filesystem::remove(copy);
  ::kill(watchdog.id(), SIGKILL);
  std::int64_t tried_ns = 0;
  ASSERT_TRUE(wait_until([&] { return watchdog.restart_if_dead(tried_ns = clock.now_ns()).has_value(); }));
  EXPECT_FALSE(watchdog.restart_if_dead(tried_ns + 1));
  // Its old process id may be another process's by now: no signal may be sent to it.
  EXPECT_EQ(watchdog.id(), 0);
  EXPECT_EQ(watchdog.restarts(), 0U);
  const auto again = watchdog.restart_if_dead(tried_ns + WatchdogSupervisor::kWatchdogTimeoutNs);
  ASSERT_TRUE(again.has_value());
  ASSERT_FALSE(*again) << "its program is not there any more";
  EXPECT_NE(again->error().what.find("cannot be started"), std::string::npos) << again->error().what;
}

TEST_F(WatchdogProcessTest, WhatEndsAUnitDoesNotEndIt) {
  ASSERT_TRUE(watchdog.start(memory, program(), 0));
  ASSERT_TRUE(wait_until([&] { return memory.page().watchdog_beat_ns.load() > 0; }));
  // systemd sends SIGABRT to a unit that hangs; SIGPIPE comes from a write to a stderr whose reader has ended.
  for (const int signal : {SIGTERM, SIGINT, SIGHUP, SIGABRT, SIGPIPE}) ::kill(watchdog.id(), signal);
  const std::int64_t requested_ns = clock.now_ns();
  EXPECT_TRUE(wait_until([&] { return memory.page().watchdog_beat_ns.load() > requested_ns + 20 * kMs; }));
  ::kill(watchdog.id(), SIGKILL);
}

TEST_F(WatchdogProcessTest, CutsWhatTheDeviceSideLeavesOut) {
  memory.page().set_means(CutMeans::simulated);
  ASSERT_TRUE(watchdog.start(memory, program(), 0));
  memory.page().heartbeat_ns = clock.now_ns();
  memory.page().force_sample_ns = clock.now_ns();
  ASSERT_TRUE(wait_until([&] { return memory.page().is_cut.load() != 0; }));
  EXPECT_EQ(watchdog.cuts(), 1U);
  EXPECT_GT(memory.page().longest_force_ns.load(), 20 * kMs);
  ::kill(watchdog.id(), SIGKILL);
}

TEST_F(WatchdogProcessTest, AProgramThatIsNotThereIsOneClearLine) {
  const auto started = watchdog.start(memory, "/nowhere/hapton_watchdog", 0);
  ASSERT_FALSE(started);
  EXPECT_NE(started.error().what.find("/nowhere/hapton_watchdog"), std::string::npos);
  EXPECT_NE(started.error().what.find("--watchdog off"), std::string::npos);
  EXPECT_FALSE(watchdog.is_started());
}

// A node tries to start it again for as long as it runs. Blocks that the thread keeps for later use count as used, so a few tries come
// first.
TEST_F(WatchdogProcessTest, TryingToStartItTakesNoMoreMemoryEachTime) {
  const auto used_after = [&](int tries) {
    for (int n = 0; n < tries; ++n) EXPECT_FALSE(watchdog.start(memory, "/nowhere/hapton_watchdog", 0));
    return ::mallinfo2().uordblks;
  };
  const std::size_t before = used_after(20);
  EXPECT_LT(used_after(200), before + 4096);
}

}  // namespace
}  // namespace hapton
