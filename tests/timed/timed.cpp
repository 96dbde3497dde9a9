// hapton_timed COMMAND [WORDS...]: runs a test that runs whole nodes against the clock. A node that stands still for longer than a force
// may live releases the force, disconnects or is killed by its watchdog, as it should; a test that waits for touch then fails through no
// fault of the nodes. So a command that failed while the machine itself stood still is run again; if it failed in every run, and the
// machine stood still in every run for longer than a force may live, it is skipped (77) with a line that says so. On a machine that never
// stands still, nothing is repeated.
#include <fmt/core.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <limits>

#include "runtime/clock.h"
#include "tests/timed/stall_watch.h"

namespace {

using hapton::StallWatch;

constexpr int kSkipped = 77;
constexpr int kMaxRuns = 5;
constexpr std::int64_t kMaxTotalNs = 60 * hapton::kNanosecondsPerSecond;  // of all runs together: no further run begins after this time
constexpr std::int64_t kMinStallNs = StallWatch::kForceLifeNs / 2;

double ms(std::int64_t ns) { return 1e-6 * static_cast<double>(ns); }

// The command's exit code; 128 + N: signal N ended it.
int run(char** words) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::execvp(words[0], words);
    std::perror(words[0]);
    ::_exit(127);
  }
  int status = 0;
  if (child < 0 || ::waitpid(child, &status, 0) != child) return 1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "hapton_timed: give the command to run\n");
    return 2;
  }
  const std::int64_t begin_ns = hapton::SteadyClock().now_ns();
  std::int64_t shortest_stall_ns = std::numeric_limits<std::int64_t>::max();
  for (int n = 1;; ++n) {
    StallWatch watch;
    const int code = run(argv + 1);
    const std::int64_t stall_ns = watch.end();
    if (code == 0 || code == kSkipped || stall_ns < kMinStallNs) return code;
    fmt::print("\nrun {} failed (exit code {}), and this machine stood still for up to {:.1f} ms meanwhile\n", n, code, ms(stall_ns));
    std::fflush(stdout);
    shortest_stall_ns = std::min(shortest_stall_ns, stall_ns);
    if (n == kMaxRuns || hapton::SteadyClock().now_ns() - begin_ns > kMaxTotalNs) {
      if (shortest_stall_ns < StallWatch::kForceLifeNs) return code;
      fmt::print("skipped: in each of {} runs this machine stood still for {:.1f} ms or more, longer than a force may live: not judged\n",
                 n, ms(shortest_stall_ns));
      return kSkipped;
    }
    ::sleep(1);
  }
}
