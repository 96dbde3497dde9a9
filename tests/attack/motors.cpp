// Observes the motors of a running io_node with a simulated device from outside, while it is left alone, frozen or killed. For
// deploy/unit-test.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>

#include "runtime/deadline_thread.h"
#include "runtime/realtime.h"
#include "tests/attack/fault_means.h"
#include "tests/support/motor_observer.h"

int main(int argc, char** argv) {
  using namespace hapton;
  int process = 0;
  std::string action = "watch";
  double seconds = 1.0;
  CLI::App app{"Measures how long a force stays on the simulated motors of an io_node; one JSON object is printed.", "hapton_motors"};
  app.add_option("process", process, "Process ID of io_node")->required();
  app.add_option("what", action, "watch it, also while a real-time program runs wild (hog), or send it a signal and measure the release")
      ->check(CLI::IsMember({"watch", "hog", "freeze", "kill"}))
      ->capture_default_str();
  app.add_option("--seconds", seconds, "watch: how long; else: how long to wait for a force, and how long it stays frozen")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  MotorObserver observer;
  if (!observer.attach(process)) {
    std::fprintf(stderr, "hapton_motors: process %d is not an io_node with a simulated device and a watchdog, or another user's\n",
                 process);
    return 2;
  }
  // The observation begins once a force is on the motors.
  if (!observer.await_force(0.5, 30.0)) {
    std::fprintf(stderr, "hapton_motors: no force came within 30 s\n");
    return 3;
  }
  // Started now, because this thread later takes a scheduling policy that its children must not inherit.
  const auto hog = action == "hog" ? std::make_unique<attack::RealtimeHog>() : nullptr;
  if (hog != nullptr && !hog->is_running()) {
    std::fprintf(stderr, "hapton_motors: this user may not have real time\n");
    return 2;
  }
  // This thread must be punctual too; if that is denied, the report contains its own gaps.
  if (!enter_deadline(100'000, 200'000)) (void)enter_realtime({.mode = RealtimeMode::attempt, .priority = 90, .low_dma_latency = false});
  if (action == "watch" || action == "hog") {
    const auto observed = observer.watch(seconds);
    std::printf(
        "{\"oldest_force_ms\": %.2f, \"longest_same_ms\": %.2f, \"strongest_n\": %.2f, \"force_share\": %.3f, \"blind_ms\": %.2f}\n",
        observed.oldest_force_ms, observed.longest_same_ms, observed.strongest_n, observed.force_share, observed.blind_ms);
    return 0;
  }
  const auto observed = observer.release_after([&] { ::kill(process, action == "freeze" ? SIGSTOP : SIGKILL); });
  double after_n = 0.0;
  if (action == "freeze") {
    SteadyClock clock;
    clock.sleep_until_ns(clock.now_ns() + static_cast<std::int64_t>(1e9 * seconds));
    ::kill(process, SIGCONT);
    // The earlier force must not come back: the first 10 ms bring at most the beginning of a ramp.
    after_n = observer.watch(0.01).strongest_n;
  }
  std::printf("{\"was_out\": %s, \"after_event_ms\": %.2f, \"after_sample_ms\": %.2f, \"blind_ms\": %.2f, \"thawed_n\": %.3f}\n",
              observed.was_out ? "true" : "false", observed.after_event_ms, observed.after_sample_ms, observed.blind_ms, after_n);
  return observed.after_event_ms >= 0.0 ? 0 : 1;
}
