#include "runtime/realtime.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <thread>

#include "runtime/thread_usage.h"

namespace hapton {
namespace {

using testing::HasSubstr;

// The thread's state after entering, as reported by the system.
struct Outcome {
  std::optional<Result<RealtimeReport>> report;
  int policy = -1;
  int priority = -1;
  int slack_ns = -1;
  int cpu = -1;
};

Outcome enter_in_a_thread(const RealtimeSettings& settings) {
  Outcome outcome;
  std::thread([&] {
    outcome.report = enter_realtime(settings);
    sched_param parameters = {};
    pthread_getschedparam(pthread_self(), &outcome.policy, &parameters);
    outcome.priority = parameters.sched_priority;
    outcome.slack_ns = prctl(PR_GET_TIMERSLACK, 0, 0, 0, 0);
    outcome.cpu = sched_getcpu();
  }).join();
  munlockall();
  return outcome;
}

const RealtimeItem* find_item(const RealtimeReport& report, const std::string& name) {
  const auto found = std::find_if(report.items.begin(), report.items.end(), [&](const auto& item) { return item.name == name; });
  return found == report.items.end() ? nullptr : &*found;
}

TEST(RealtimeTest, OffRequestsFineTimersOnly) {
  const Outcome outcome = enter_in_a_thread({.mode = RealtimeMode::off});
  ASSERT_TRUE(*outcome.report);
  ASSERT_EQ((*outcome.report)->items.size(), 1U);
  EXPECT_EQ((*outcome.report)->items[0].name, "timer slack");
  EXPECT_EQ(outcome.policy, SCHED_OTHER);
}

TEST(RealtimeTest, TheReportIsTrue) {
  const Outcome outcome = enter_in_a_thread({.mode = RealtimeMode::attempt, .priority = 7, .cpu = 0});
  ASSERT_TRUE(*outcome.report);
  const RealtimeReport& report = **outcome.report;
  ASSERT_EQ(report.items.size(), 5U);
  EXPECT_EQ(find_item(report, "priority")->obtained, outcome.policy == SCHED_FIFO && outcome.priority == 7);
  if (find_item(report, "CPU")->obtained) {
    EXPECT_EQ(outcome.cpu, 0);
  }
  for (const RealtimeItem& item : report.items) {
    EXPECT_EQ(item.reason.empty(), item.obtained) << item.name;
    EXPECT_EQ(item.remedy.empty(), item.obtained) << item.name;
    EXPECT_THAT(report.to_text(), HasSubstr(item.name));
  }
  // With SCHED_FIFO the kernel reports no slack at all.
  EXPECT_LE(outcome.slack_ns, 1);
}

TEST(RealtimeTest, ADenialIsReportedWithItsRemedyAndOnlyRequireFails) {
  constexpr int kNoSuchCpu = 1000;
  const Outcome attempt_outcome =
      enter_in_a_thread({.mode = RealtimeMode::attempt, .priority = 0, .cpu = kNoSuchCpu, .lock_memory = false});
  ASSERT_TRUE(*attempt_outcome.report);
  const RealtimeItem* item = find_item(**attempt_outcome.report, "CPU");
  ASSERT_NE(item, nullptr);
  EXPECT_FALSE(item->obtained);
  EXPECT_THAT((*attempt_outcome.report)->to_text(), HasSubstr("CPU 1000: denied ("));
  EXPECT_FALSE((*attempt_outcome.report)->complete());
  const auto lines = (*attempt_outcome.report)->to_lines();
  ASSERT_GE(lines.size(), 2U);
  EXPECT_THAT(lines[0], HasSubstr("CPU 1000: denied"));
  EXPECT_THAT(lines[1], HasSubstr("not granted: CPU 1000 ("));
  EXPECT_THAT(lines[1], HasSubstr(item->remedy));

  const Outcome require_outcome =
      enter_in_a_thread({.mode = RealtimeMode::require, .priority = 0, .cpu = kNoSuchCpu, .lock_memory = false});
  ASSERT_FALSE(*require_outcome.report);
  EXPECT_THAT(require_outcome.report->error().what, HasSubstr("not granted: CPU 1000"));
  EXPECT_EQ(require_outcome.report->error().what.find('\n'), std::string::npos);
}

// The reason is the error of the call that failed, not of a later call.
TEST(RealtimeTest, ADeniedWakeUpLatencyIsReportedWithItsOwnReason) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // this process may have opened the file already
  const auto check_reason = [] {
    constexpr uid_t kNobody = 65534;
    if (geteuid() == 0 && setuid(kNobody) != 0) std::_Exit(2);
    const int file = open("/dev/cpu_dma_latency", O_RDWR | O_CLOEXEC);
    const std::string expected = std::strerror(errno);
    if (file >= 0) std::_Exit(0);
    const auto report = enter_realtime({.mode = RealtimeMode::attempt, .priority = 0, .lock_memory = false});
    const RealtimeItem* item = report ? find_item(*report, "wake-up latency") : nullptr;
    std::_Exit(item != nullptr && !item->obtained && item->reason.find(expected) != std::string::npos ? 0 : 1);
  };
  EXPECT_EXIT(check_reason(), testing::ExitedWithCode(0), "");
}

// Under a finite limit, memory that is taken later is not locked: taking it would fail.
TEST(RealtimeTest, WhoMayLockWithoutALimitLocksAllMemory) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto lock_under = [](rlim_t limit_bytes) {
    constexpr uid_t kNobody = 65534;
    const rlimit limit = {.rlim_cur = limit_bytes, .rlim_max = limit_bytes};
    // Only a privileged user may remove a limit.
    if (setrlimit(RLIMIT_MEMLOCK, &limit) != 0) std::_Exit(limit_bytes == RLIM_INFINITY ? 0 : 2);
    if (geteuid() == 0 && setuid(kNobody) != 0) std::_Exit(2);
    const auto report = enter_realtime({.mode = RealtimeMode::attempt, .priority = 0, .low_dma_latency = false});
    const RealtimeItem* item = report ? find_item(*report, "memory lock") : nullptr;
    std::_Exit(item != nullptr && item->requested == (limit_bytes == RLIM_INFINITY ? "all" : "present") ? 0 : 1);
  };
  EXPECT_EXIT(lock_under(1 << 16), testing::ExitedWithCode(0), "");
  EXPECT_EXIT(lock_under(RLIM_INFINITY), testing::ExitedWithCode(0), "");
}

// It says something about threads with a real-time priority only.
TEST(RealtimeTest, TheShareOfRealTimeThreadsIsReadIfThePriorityIsGranted) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto enter = [](bool may_have_priority) {
    constexpr uid_t kNobody = 65534;
    const rlimit limit = {.rlim_cur = may_have_priority ? 7U : 0U, .rlim_max = may_have_priority ? 7U : 0U};
    // Only a privileged user may raise a limit, and the system may grant no priority to anybody.
    if (setrlimit(RLIMIT_RTPRIO, &limit) != 0) std::_Exit(0);
    if (geteuid() == 0 && setuid(kNobody) != 0) std::_Exit(2);
    const auto report = enter_realtime({.mode = RealtimeMode::attempt, .priority = 7, .lock_memory = false, .low_dma_latency = false});
    const RealtimeItem* item = report ? find_item(*report, "priority") : nullptr;
    if (item == nullptr || !find_item(*report, "timer slack")->obtained) std::_Exit(3);
    if (item->obtained && !may_have_priority) std::_Exit(4);
    const std::optional<double> expected = item->obtained ? read_realtime_share() : std::nullopt;
    std::_Exit(report->allowed_share == expected ? 0 : 1);
  };
  EXPECT_EXIT(enter(false), testing::ExitedWithCode(0), "");
  EXPECT_EXIT(enter(true), testing::ExitedWithCode(0), "");
}

TEST(RealtimeTest, TheShareOfRealTimeThreadsIsReportedInPercent) {
  RealtimeReport report;
  report.items.push_back({.name = "priority", .requested = "SCHED_FIFO 80", .obtained = true, .reason = {}, .remedy = {}});
  EXPECT_EQ(report.to_text().find("the kernel allows"), std::string::npos);
  report.allowed_share = 0.95;
  EXPECT_NE(report.to_text().find("; the kernel allows real-time threads 95 % of each CPU"), std::string::npos) << report.to_text();
  ASSERT_EQ(report.to_lines().size(), 1U);
  EXPECT_NE(report.to_lines()[0].find("; the kernel allows real-time threads 95 % of each CPU"), std::string::npos);
}

TEST(RealtimeTest, InvalidSettingsAreAnErrorInEveryMode) {
  EXPECT_FALSE(enter_realtime({.mode = RealtimeMode::attempt, .priority = 100}));
  EXPECT_FALSE(enter_realtime({.mode = RealtimeMode::attempt, .priority = -1}));
}

TEST(RealtimeTest, TheSharedCpuIsOneThatThisProcessMayUse) {
  const int cpu = find_shared_cpu();
  cpu_set_t set;
  ASSERT_EQ(sched_getaffinity(0, sizeof set, &set), 0);
  if (CPU_COUNT(&set) < 2) {
    EXPECT_EQ(cpu, -1);
    return;
  }
  EXPECT_TRUE(CPU_ISSET(static_cast<std::size_t>(cpu), &set));
  CPU_CLR(static_cast<std::size_t>(cpu), &set);
  std::thread([&] {
    ASSERT_EQ(sched_setaffinity(0, sizeof set, &set), 0);
    EXPECT_LT(find_shared_cpu(), cpu) << "the last one";
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(static_cast<std::size_t>(cpu), &one);
    ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
    EXPECT_EQ(find_shared_cpu(), -1) << "there is only one";
  }).join();
}

TEST(RealtimeTest, ReadsTheModesOfTheCommandLine) {
  EXPECT_EQ(*parse_realtime_mode("off"), RealtimeMode::off);
  EXPECT_EQ(*parse_realtime_mode("try"), RealtimeMode::attempt);
  EXPECT_EQ(*parse_realtime_mode("require"), RealtimeMode::require);
  EXPECT_THAT(parse_realtime_mode("maybe").error().what, HasSubstr("'maybe'"));
}

}  // namespace
}  // namespace hapton
