#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "runtime/clock.h"
#include "runtime/start_thread.h"
#include "tools/commands.h"
#include "tools/governor/governor_stress.h"

namespace hapton {
namespace {

struct GovernorOptions {
  double steps = 1e7;
  std::uint64_t seed = 1;
  unsigned threads = std::max(1U, std::thread::hardware_concurrency());
  std::optional<std::uint64_t> program;
};

// Runs hostile programs in several threads. Each thread takes the next program, until enough steps have been run.
class GovernorRun {
 public:
  explicit GovernorRun(const GovernorOptions& options) : options_(options), stress_(options.seed) {}

  GovernorStressCount run() {
    std::vector<std::thread> threads;
    for (unsigned n = 0; n < options_.threads; ++n) threads.push_back(start_thread([this] { work(); }));
    const SteadyClock clock;
    std::int64_t next_ns = clock.now_ns() + kNanosecondsPerSecond;
    while (remaining_steps_.load() > 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      if (clock.now_ns() < next_ns) continue;
      next_ns += kNanosecondsPerSecond;
      fmt::print(stderr, "\rgovernor: {:.3g} of {:g} steps, {} breaches ", static_cast<double>(done_steps_.load()), options_.steps,
                 breaches_.load());
    }
    for (std::thread& thread : threads) thread.join();
    fmt::print(stderr, "\n");
    return total_;
  }

 private:
  void work() {
    GovernorStressCount thread_count;
    while (remaining_steps_.load() > 0) {
      const std::uint64_t turns_before = thread_count.turns;
      const std::uint64_t breaches = thread_count.total_breaches();
      GovernorStress::run(stress_.program_seed(next_program_.fetch_add(1)), thread_count);
      breaches_ += thread_count.total_breaches() - breaches;
      done_steps_ += thread_count.turns - turns_before;
      remaining_steps_ -= static_cast<std::int64_t>(thread_count.turns - turns_before);
    }
    const std::lock_guard lock(mutex_);
    total_.add(thread_count);
  }

  const GovernorOptions& options_;
  GovernorStress stress_;
  std::atomic<std::uint64_t> next_program_{0};
  std::atomic<std::uint64_t> done_steps_{0};
  std::atomic<std::uint64_t> breaches_{0};
  std::atomic<std::int64_t> remaining_steps_{static_cast<std::int64_t>(options_.steps)};
  std::mutex mutex_;
  GovernorStressCount total_;
};

void print_stages(const GovernorCounters& g) {
  fmt::print("commands: {} accepted, {} not finite, {} old, {} with a time in the future, {} command timeouts\n", g.accepted, g.not_finite,
             g.rejected_old, g.rejected_future, g.command_timeouts);
  fmt::print(
      "stages: {} clamped, {} rate-limited, {} limited by the workspace, {} by speed, {} by energy, {} by heat; switch released {} times\n",
      g.clamped, g.rate_limited, g.workspace_limited, g.speed_limited, g.damped, g.thermal_limited, g.releases);
  fmt::print("device: {} invalid poses; faults: {} latched", g.bad_samples, g.latched);
  for (int fault = 1; fault < kSafetyFaults; ++fault) {
    fmt::print(", {} {}", g.faults[static_cast<std::size_t>(fault)], to_string(static_cast<SafetyFault>(fault)));
  }
  fmt::print("; {} reset, {} resets rejected\n", g.resets, g.resets_rejected);
}

void print_worst(const GovernorWorst& worst) {
  fmt::print("worst, 1 is the limit: force {:.9f}, torque {:.9f}, force slew {:.9f}, torque slew {:.9f}, heat {:.6f}, energy {:.4f}\n",
             worst.force, worst.torque, worst.force_slew, worst.torque_slew, worst.heat, worst.energy);
  fmt::print("slowest release after a gate closed, with the cycle before: {:.2f} ms\n", worst.release_ms);
}

void print_breaches(const GovernorStressCount& count) {
  for (std::size_t n = 0; n < count.breaches.size(); ++n) {
    if (count.breaches[n] == 0) continue;
    fmt::print("BREACH {}: {} times, first at turn {} of: hapton governor --program {}\n", to_string(static_cast<GovernorBreach>(n)),
               count.breaches[n], count.findings[n].turn, count.findings[n].program);
  }
}

int run(const GovernorOptions& options) {
  const SteadyClock clock;
  const std::int64_t begin_ns = clock.now_ns();
  GovernorStressCount count;
  if (options.program) {
    GovernorStress::run(*options.program, count);
  } else {
    fmt::print("governor: {:g} steps, seed {}, {} threads\n", options.steps, options.seed, options.threads);
    std::fflush(stdout);
    count = GovernorRun(options).run();
  }
  const double seconds = 1e-9 * static_cast<double>(clock.now_ns() - begin_ns);
  print_stages(count.governors);
  print_worst(count.worst);
  print_breaches(count);
  fmt::print("governor: {} breaches in {} steps of {} programs, {:.1f} % with force, {:.0f} s\n", count.total_breaches(), count.turns,
             count.programs, 100.0 * static_cast<double>(count.turns_with_force) / static_cast<double>(count.turns), seconds);
  return count.total_breaches() == 0 ? 0 : 1;
}

}  // namespace

void add_governor_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<GovernorOptions>();
  const CommandLine command = app.add_subcommand("governor", "Run hostile force programs against io_node's safety governor");
  command.add_option("--steps", options->steps, "Steps of all programs together").between(1.0, 1e15).shows_default();
  command.add_option("--seed", options->seed, "Seed of every program").shows_default();
  command.add_option("--threads", options->threads, "Programs that run in parallel").between(1, 1024).shows_default();
  command.add_option("--program", options->program, "Only the program with this number, which a breach prints");
  command.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
