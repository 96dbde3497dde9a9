// What the motors of a running io_node do while it is flooded, frozen or killed; seen from outside, in the memory that it shares with its
// watchdog. Times are the machine's: the bounds asserted here are wide, deploy/attack measures.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <cstdio>
#include <memory>

#include "tests/process/system.h"
#include "tests/support/motor_observer.h"

namespace hapton::process {
namespace {

// What is promised, and what a busy machine may make of it.
constexpr double kOutsideMs = 50.0;
constexpr double kBusyMs = 500.0;

struct DeviceSide : testing::Test {
  void start(const std::vector<std::string>& more = {}) {
    const std::string folder = system.folder().string();
    std::vector<std::string> arguments = {"--bind", system.hub(), "--device", "simulated", "--out", folder + "/out", "--flight", "off"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    io = std::make_unique<Program>("io_node", arguments, system.folder());
    haptics = std::make_unique<Program>(
        "haptics_node", std::vector<std::string>{"--hub", system.hub(), "--scene", std::string(HAPTON_SOURCE_DIR) + "/scenes/car_front.toml"},
        system.folder());
    ASSERT_TRUE(System::wait_until([&] { return observer.attach(io->pid()) || !io->is_running(); }));
    ASSERT_TRUE(io->is_running()) << io->err();
  }
  // Only who has a watchdog has memory that it shares.
  bool feels(double at_least_n = 0.3) { return observer.await_force(at_least_n, kPatience.count()); }

  System system;
  MotorObserver observer;
  std::unique_ptr<Program> io;
  std::unique_ptr<Program> haptics;
};

TEST_F(DeviceSide, AFrozenIoNodeHoldsNoForceAndThawsWithARamp) {
  start();
  ASSERT_TRUE(feels());
  const auto release = observer.release_after(SIGSTOP);
  std::printf("frozen: nothing on the motors after %.1f ms (promised: %.0f)\n", release.after_event_ms, kOutsideMs);
  EXPECT_TRUE(release.was_out);
  EXPECT_GE(release.after_event_ms, 0.0) << "the force stayed";
  EXPECT_LE(release.after_event_ms, kOutsideMs + kBusyMs);
  // However long: nothing comes back.
  EXPECT_EQ(observer.watch(0.5).strongest_n, 0.0);
  io->send_signal(SIGCONT);
  EXPECT_TRUE(feels()) << "it goes on afterwards";
  EXPECT_TRUE(System::wait_until([&] { return io->err().find("watchdog process took the force away") != std::string::npos ||
                                              io->out().find("watchdog process took the force away") != std::string::npos; }));
}

TEST_F(DeviceSide, AKilledIoNodeHoldsNoForce) {
  start();
  ASSERT_TRUE(feels());
  const auto release = observer.release_after(SIGKILL);
  std::printf("killed: nothing on the motors after %.1f ms (promised: %.0f)\n", release.after_event_ms, kOutsideMs);
  EXPECT_GE(release.after_event_ms, 0.0) << "the force stayed";
  EXPECT_LE(release.after_event_ms, kOutsideMs + kBusyMs);
}

TEST_F(DeviceSide, WithoutItsWatchdogItStartsAnother) {
  start();
  ASSERT_TRUE(feels());
  const std::string children = read_text("/proc/" + std::to_string(io->pid()) + "/task/" + std::to_string(io->pid()) + "/children");
  ASSERT_FALSE(children.empty());
  ::kill(std::stoi(children), SIGKILL);
  EXPECT_TRUE(System::wait_until([&] {
    const std::string now = read_text("/proc/" + std::to_string(io->pid()) + "/task/" + std::to_string(io->pid()) + "/children");
    return !now.empty() && now != children;
  }));
  EXPECT_TRUE(feels());
}

// One captured handshake, again and again: under the limits of the unit this killed io_node within a second.
TEST_F(DeviceSide, AFloodOfReplayedHandshakesUnderTheUnitsLimitsIsNotFelt) {
  rlimit before = {};
  ASSERT_EQ(::getrlimit(RLIMIT_RTTIME, &before), 0);
  const rlimit units = {.rlim_cur = std::min<rlim_t>(500'000, before.rlim_max), .rlim_max = before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_RTTIME, &units), 0);
  start();
  ::setrlimit(RLIMIT_RTTIME, &before);
  ASSERT_TRUE(feels());
  const std::string captured = (system.folder() / "captured").string();
  const std::string between = "127.0.0.1:" + find_free_port();
  Program listening("hapton_flood", {"--to", system.hub(), "--listen", between, "--capture", captured, "--seconds", "3"}, system.folder());
  ASSERT_TRUE(run("hapton", {"set", "--hub", between, "--rate", "1000"}, system.folder()));
  ASSERT_TRUE(listening.wait(kPatience));
  Program flood("hapton_flood", {"--to", system.hub(), "--kind", "handshake", "--capture", captured, "--rate", "200000", "--sources", "4", "--seconds", "3"},
                system.folder());
  const auto watched = observer.watch(2.5);
  const auto ended = flood.wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 0) << ended->err;
  std::printf("flood %s: the oldest force was %.1f ms old, a force in %.0f %% of the looks\n", ended->out.c_str(), watched.oldest_force_ms,
              100.0 * watched.force_share);
  EXPECT_TRUE(io->is_running()) << "killed by its limit of real time";
  EXPECT_GT(watched.force_share, 0.0) << "the session goes on in the flood";
  EXPECT_LE(watched.oldest_force_ms, 21.0 + kBusyMs);
  io->send_signal(SIGTERM);
  const auto io_ended = io->wait(kPatience);
  ASSERT_TRUE(io_ended);
  EXPECT_EQ(io_ended->exit_code, 0);
  const Json report = system.read_report();
  EXPECT_GT(count(report, "dropped_by_kernel") + count(report, "strangers"), 10'000) << "everything is counted";
}

}  // namespace
}  // namespace hapton::process
