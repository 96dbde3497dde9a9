// A cycle of the network loop makes no system call: only the endpoint waits, sends and receives.
#include <gtest/gtest.h>

#include <sys/syscall.h>
#include <unistd.h>

#include <memory>
#include <string>

#include "devices/simulated_phantom.h"
#include "io_node/network_loop.h"
#include "io_node/session_recorder.h"
#include "tests/io_node/fixed_endpoint.h"
#include "tests/support/system_call_guard.h"

namespace hapton {
namespace {

// A session in this process; everything in it is made before the first cycle.
struct Session {
  SimulatedClock clock;
  FixedEndpoint endpoint{clock};
  SimulatedPhantom device{{}};
  SessionRecorder recorder{{}, {}, clock};
  HubPeers peers{endpoint, clock, 5, 1000.0};
  NetworkLoop network{device, peers, clock, {.spin_share = 0.1}, nullptr, &recorder};

  void run() {
    for (int n = 0; n < 3000; ++n) {
      const std::int64_t now = clock.now_ns();
      if (n % 50 == 0) endpoint.say(1, Hello{NodeRole::haptics}, now);
      if (n % 50 == 10) endpoint.say(2, Hello{NodeRole::vision}, now);
      if (n % 50 == 20) endpoint.say(2, ViewTransform{}, now);
      if (n % 500 == 0) network.request_snapshot();
      network.step();
    }
    network.finish();
  }
};

TEST(NetworkLoopSystemCalls, ARecordedSessionMakesNone) {
  if (!SystemCallGuard::is_available()) GTEST_SKIP() << "system calls cannot be forbidden in this build or on this kernel";
  std::unique_ptr<Session> session;
  EXPECT_EQ(SystemCallGuard::run([&] { session = std::make_unique<Session>(); },
                                 [&] {
                                   session->run();
                                   if (session->network.collect_stats().forces < 2000) _exit(9);
                                 }),
            "");
}

TEST(NetworkLoopSystemCalls, TheGuardSeesOne) {
  if (!SystemCallGuard::is_available()) GTEST_SKIP() << "system calls cannot be forbidden in this build or on this kernel";
  EXPECT_EQ(SystemCallGuard::run([] {}, [] { (void)getppid(); }), "system call " + std::to_string(SYS_getppid));
}

}  // namespace
}  // namespace hapton
