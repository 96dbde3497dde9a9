#include "tests/attack/attack_list.h"

#include <fmt/core.h>
#include <signal.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <thread>

#include "runtime/clock.h"
#include "runtime/deadline_thread.h"
#include "runtime/realtime.h"
#include "tests/attack/fault_means.h"
#include "tests/attack/test_bed.h"
#include "tests/timed/stall_watch.h"

namespace hapton::attack {
namespace {

using process::Program;

constexpr int kMaxStalls = 4;
constexpr double kStallMs = 1e-6 * StallWatch::kForceLifeNs;
constexpr const char* kBusyRealtime = "a real-time program uses every CPU fully";
constexpr double kFastest = 1e7;  // datagrams per second, more than any machine sends: as fast as it can

void sleep_s(double seconds) {
  SteadyClock clock;
  clock.sleep_until_ns(clock.now_ns() + static_cast<std::int64_t>(1e9 * seconds));
}

// Runs `what` in a thread, with real-time scheduling if requested and permitted. `what` must start no programs: they would inherit it.
void observe(const std::function<void()>& what, bool in_realtime = true) {
  std::thread thread([&] {
    // Its priority is above all that it observes, so that even a real-time program that uses every CPU fully cannot delay it.
    if (in_realtime && !enter_deadline(100'000, 200'000))
      (void)enter_realtime({.mode = RealtimeMode::attempt, .priority = 90, .lock_memory = false, .low_dma_latency = false});
    what();
  });
  thread.join();
}

// Whether the row may be broken or over its bound only because the machine stood still (the hypervisor ran no thread, observers included).
// watch_ms: the longest stall that StallWatch measured. It, or the gap of the observers, must be at least as long as the excess over the
// bound.
bool is_stalled(const Row& row, double watch_ms) {
  if (row.is_broken && watch_ms >= kStallMs) return true;
  return row.is_over && row.release_ms() - std::max(row.blind_ms, watch_ms) <= row.bound_ms;
}

// If the thread had another name, it would never be attacked, and the row would prove nothing.
void mark_missing_thread(Row& row, const std::string& thread) {
  row.is_broken = true;
  row.note = "io_node has no thread " + thread;
}

class List {
 public:
  List(const Settings& settings, const std::function<void(const Row&)>& on_row) : settings_(settings), on_row_(on_row) {}
  std::vector<Row> run();

 private:
  bool has_patches() const { return settings_.touch == "patch"; }
  bool is_selected(const std::string& name) const { return settings_.only.empty() || name.find(settings_.only) != std::string::npos; }
  // Starts a test bed and waits until a force is on the motors. Null if that fails; the row then says why.
  std::unique_ptr<TestBed> make_bed(Row& row);
  void finish(Row row);
  static void mark_alone(Row& row) {
    row.kind = Kind::alone;
    row.bound_ms = kAloneMs;
  }
  void note(Row& row, const MotorObserver::Release& release);
  void note(Row& row, const MotorObserver::Watched& watched);
  // Two threads watch the motors: one with real-time scheduling, and an ordinary one, which still runs when real time is throttled.
  MotorObserver::Watched watch(TestBed& bed, double seconds);

  void haptics_dies(const std::string& name, int signal);
  void thread_hangs(const std::string& name, const std::vector<std::string>& threads, Kind kind);
  void hung_thread_does_not_stop_touch(const std::string& name, const std::string& thread);
  void watchdog_dies(const std::string& name, int signal);
  void io_node_freezes();
  void io_node_dies(const std::string& name, int signal);
  void realtime_is_taken();
  void flood(const std::string& name, const std::string& kind, double rate_per_s, int sources, bool at_haptics = false);

  // Makes a row. Returns for how long the machine stood still meanwhile, ms. kBusyRealtime takes the CPUs from StallWatch too: for that
  // row only the stall while the bed was made counts, and only if the row is broken; the gaps of the observers show later stalls.
  double run_row(const std::string& name, const std::function<void(const std::string&)>& make);

  double seconds_since_begin() const { return 1e-9 * static_cast<double>(SteadyClock().now_ns() - begin_ns_); }

  const Settings& settings_;
  const std::int64_t begin_ns_ = SteadyClock().now_ns();
  bool has_stalled_ = false;
  double bed_stall_ms_ = 0.0;  // longest stall while the last bed was made
  const std::function<void(const Row&)>& on_row_;
  std::vector<Row> rows_;
};

std::unique_ptr<TestBed> List::make_bed(Row& row) {
  const StallWatch watch;
  auto bed = std::make_unique<TestBed>(settings_.touch);
  const std::string problem = bed->await_contact();
  bed_stall_ms_ = 1e-6 * static_cast<double>(watch.longest_ns());
  if (problem.empty()) return bed;
  row.is_broken = true;
  row.note = problem;
  return nullptr;
}

void List::finish(Row row) {
  const double release_ms = row.release_ms();
  // Each force from a patch replies to a new sample, however long the haptics node has been gone.
  if (row.kind == Kind::alone && row.after_sample_ms > kInsideMs + settings_.slack_ms) {
    row.is_broken = true;
    row.note = "a force stayed after its sample";
  }
  if (!row.is_skipped && release_ms > row.bound_ms) {
    row.is_over = true;
    if (release_ms > row.bound_ms + settings_.slack_ms) row.is_broken = true;
  }
  rows_.push_back(std::move(row));
}

void List::note(Row& row, const MotorObserver::Release& release) {
  if (release.after_event_ms < 0.0) {
    row.is_broken = true;
    row.note = "the force stayed";
    return;
  }
  row.after_event_ms = std::max(row.after_event_ms, release.after_event_ms);
  row.after_sample_ms = std::max(row.after_sample_ms, release.after_sample_ms);
  row.blind_ms = std::max(row.blind_ms, release.blind_ms);
}

void List::note(Row& row, const MotorObserver::Watched& watched) {
  row.after_sample_ms = std::max(row.after_sample_ms, watched.oldest_force_ms);
  row.blind_ms = std::max(row.blind_ms, watched.blind_ms);
}

MotorObserver::Watched List::watch(TestBed& bed, double seconds) {
  MotorObserver::Watched ordinary;
  MotorObserver::Watched realtime;
  std::thread ordinary_thread([&] { observe([&] { ordinary = bed.observer().watch(seconds); }, false); });
  observe([&] { realtime = bed.observer().watch(seconds); });
  ordinary_thread.join();
  realtime.oldest_force_ms = std::max(realtime.oldest_force_ms, ordinary.oldest_force_ms);
  realtime.blind_ms = std::min(realtime.blind_ms, ordinary.blind_ms);
  return realtime;
}

void List::haptics_dies(const std::string& name, int signal) {
  Row row{.name = name};
  if (has_patches()) mark_alone(row);
  std::unique_ptr<TestBed> bed;
  for (int n = 0; n < settings_.repeat && !row.is_broken; ++n) {
    if (!bed && !(bed = make_bed(row))) break;
    MotorObserver::Release release;
    const double at_most_s = 1e-3 * row.bound_ms + 0.5;
    observe([&] { release = bed->observer().release_after([&] { bed->haptics().send_signal(signal); }, at_most_s); });
    note(row, release);
    bed->haptics().send_signal(SIGCONT);
    if (signal == SIGKILL || n + 1 == settings_.repeat) {
      bed.reset();
    } else if (!bed->observer().await_force(TestBed::kForceN, 30.0)) {
      row.is_broken = true;
      row.note = "no force came again";
    }
  }
  finish(row);
}

// Stops all these threads at the same time.
void List::thread_hangs(const std::string& name, const std::vector<std::string>& threads, Kind kind) {
  Row row{.name = name, .kind = kind, .bound_ms = kind == Kind::inside ? kInsideMs : kOutsideMs};
  // With patches the device side continues until the last message of the haptics node is too old.
  if (has_patches() && threads.front() == "hapton-network") mark_alone(row);
  auto bed = make_bed(row);
  for (int n = 0; bed && n < settings_.repeat && !row.is_broken && !row.is_skipped; ++n) {
    if (!bed->observer().await_force(TestBed::kForceN, 30.0)) {
      row.is_broken = true;
      row.note = "no force came again";
      break;
    }
    for (const std::string& thread : threads) {
      if (!find_thread(bed->io().pid(), thread)) mark_missing_thread(row, thread);
    }
    if (row.is_broken) break;
    observe([&] {
      std::vector<std::unique_ptr<StoppedThread>> stopped;
      const auto stop = [&] {
        for (const std::string& thread : threads) {
          stopped.push_back(std::make_unique<StoppedThread>(find_thread(bed->io().pid(), thread).value_or(0)));
        }
      };
      const auto release = bed->observer().release_after(stop, 1e-3 * row.bound_ms + 0.5);
      row.is_skipped = !std::all_of(stopped.begin(), stopped.end(), [](const auto& thread) { return thread->is_stopped(); });
      if (row.is_skipped) {
        row.note = "a thread cannot be stopped here (ptrace)";
        return;
      }
      note(row, release);
      sleep_s(0.05);
    });
  }
  finish(row);
}

void List::hung_thread_does_not_stop_touch(const std::string& name, const std::string& thread) {
  Row row{.name = name};
  auto bed = make_bed(row);
  if (bed && !thread.empty() && !find_thread(bed->io().pid(), thread)) mark_missing_thread(row, thread);
  if (bed && !row.is_broken) {
    observe([&] {
      const StoppedThread stopped(thread.empty() ? bed->io().pid() : find_thread(bed->io().pid(), thread).value_or(0));
      row.is_skipped = !stopped.is_stopped();
      if (row.is_skipped) return;
      const auto watched = bed->observer().watch(1.0);
      note(row, watched);
      row.is_broken = watched.force_share == 0.0 && !bed->observer().await_force(TestBed::kForceN, 30.0);
      row.note = row.is_broken ? "no force afterwards" : "touch goes on";
    });
  }
  finish(row);
}

void List::watchdog_dies(const std::string& name, int signal) {
  Row row{.name = name};
  if (auto bed = make_bed(row)) {
    const auto before = find_children(bed->io().pid());
    for (const pid_t child : before) ::kill(child, signal);
    note(row, watch(*bed, 1.0));
    const bool is_back = wait_until([&] {
      const auto now = find_children(bed->io().pid());
      return !now.empty() && now != before;
    });
    row.is_broken = before.empty() || !is_back;
    row.note = is_back ? "touch goes on, it is started again" : "it is not started again";
  }
  finish(row);
}

void List::io_node_freezes() {
  Row row{.name = "io_node frozen (SIGSTOP), then continued", .kind = Kind::outside, .bound_ms = kOutsideMs};
  auto bed = make_bed(row);
  double after_continue_n = 0.0;
  for (int n = 0; bed && n < settings_.repeat && !row.is_broken; ++n) {
    if (!bed->observer().await_force(TestBed::kForceN, 30.0)) {
      row.is_broken = true;
      row.note = "no force came again";
      break;
    }
    observe([&] {
      note(row, bed->observer().release_after([&] { ::kill(bed->io().pid(), SIGSTOP); }));
      sleep_s(0.2);
      ::kill(bed->io().pid(), SIGCONT);
      // The earlier force must not come back: the first 10 ms bring at most the beginning of a ramp.
      after_continue_n = std::max(after_continue_n, bed->observer().watch(0.01).strongest_n);
    });
  }
  if (!row.is_broken) {
    row.note = fmt::format("continued: at most {:.2f} N in the first 10 ms", after_continue_n);
    row.is_broken = after_continue_n > 1.0;
  }
  finish(row);
}

void List::io_node_dies(const std::string& name, int signal) {
  Row row{.name = name, .kind = Kind::outside, .bound_ms = kOutsideMs};
  for (int n = 0; n < settings_.repeat && !row.is_broken; ++n) {
    const auto bed = make_bed(row);
    if (!bed) break;
    observe([&] { note(row, bed->observer().release_after([&] { ::kill(bed->io().pid(), signal); })); });
  }
  finish(row);
}

void List::realtime_is_taken() {
  Row row{.name = fmt::format("a real-time program uses every CPU fully (FIFO {})", RealtimeHog::kPriority)};
  if (auto bed = make_bed(row)) {
    const RealtimeHog hog;
    row.is_skipped = !hog.is_running();
    if (!row.is_skipped) {
      const auto watched = watch(*bed, 3.5);
      note(row, watched);
      row.is_broken = !bed->io().is_running();
      row.note = row.is_broken ? "io_node died" : fmt::format("a force in {:.0f} % of the observations", 100.0 * watched.force_share);
    } else {
      row.note = "this user may not have real time";
    }
  }
  finish(row);
}

// A counter of a report; 0 if missing.
double counter(const nlohmann::json& report, const char* name) {
  const auto counters = report.find("counters");
  return report.is_object() && counters != report.end() ? counters->value(name, 0.0) : 0.0;
}

void List::flood(const std::string& name, const std::string& kind, double rate_per_s, int sources, bool at_haptics) {
  Row row{.name = name};
  auto bed = make_bed(row);
  if (!bed) return finish(row);
  std::vector<std::string> words = {
      "--kind",    kind == "spoofed" ? "data" : kind, "--rate",    fmt::format("{:.0f}", rate_per_s),
      "--sources", std::to_string(sources),           "--seconds", fmt::format("{}", settings_.flood_s + 1.0)};
  words.insert(words.end(), {"--to", at_haptics ? bed->haptics_address() : bed->hub()});
  if (kind != "junk" && kind != "oversized") words.insert(words.end(), {"--capture", bed->capture()});
  if (kind == "spoofed") words.insert(words.end(), {"--spoof", bed->haptics_address()});
  const auto before = bed->request_report();
  Program flood_program("hapton_flood", words, bed->folder());
  sleep_s(0.3);
  const auto watched = watch(*bed, settings_.flood_s);
  const auto after = bed->request_report();
  const auto ended = flood_program.wait(process::kPatience);
  note(row, watched);
  if (!ended || ended->exit_code != 0) {
    row.is_skipped = ended && ended->exit_code == 77;
    row.is_broken = !row.is_skipped;
    row.note = ended ? ended->err.substr(0, ended->err.find('\n')) : "the flood does not end";
    return finish(row);
  }
  const auto counted_since = [&](const char* counted) { return counter(after, counted) - counter(before, counted); };
  const double sent_per_s = nlohmann::json::parse(ended->out, nullptr, false).value("sent_per_s", 0.0);
  const double requested = counted_since("forces_in_time") + counted_since("late") + counted_since("lost") + counted_since("superseded");
  const double late_share = requested > 0.0 ? (requested - counted_since("forces_in_time")) / requested : 1.0;
  row.note =
      fmt::format("{:.0f} k/s; {:.2f} % of forces late or lost; a force in {:.0f} % of the observations; {:.0f} k rejected or dropped",
                  1e-3 * sent_per_s, 100.0 * late_share, 100.0 * watched.force_share,
                  1e-3 * (counted_since("unknown_peers") + counted_since("dropped_by_kernel")));
  if (!bed->io().is_running()) {
    row.is_broken = true;
    row.note = "io_node died; " + row.note;
  }
  // With patches the few replies of the haptics node are not judged, because no force waits for them.
  if (!has_patches() && sent_per_s <= 1.1 * kBearablePerS && late_share > kMaxLateShare) {
    row.is_over = true;
    row.is_broken = row.is_broken || settings_.slack_ms == 0.0;
  }
  finish(row);
}

double List::run_row(const std::string& name, const std::function<void(const std::string&)>& make) {
  if (name == kBusyRealtime) {
    make(name);
    return rows_.back().is_broken ? bed_stall_ms_ : 0.0;
  }
  const StallWatch watch;
  make(name);
  return 1e-6 * static_cast<double>(watch.longest_ns());
}

std::vector<Row> List::run() {
  const auto row = [&](const std::string& name, const std::function<void(const std::string&)>& make) {
    if (!is_selected(name)) return;
    if (has_stalled_ && seconds_since_begin() > settings_.give_up_s) {
      rows_.push_back({.name = name, .is_skipped = true, .note = "not begun: this machine stands still too often"});
      return on_row_(rows_.back());
    }
    int repetitions = 0;
    double shortest_stall_ms = run_row(name, make);
    for (double stall_ms = shortest_stall_ms; is_stalled(rows_.back(), stall_ms); stall_ms = run_row(name, make)) {
      has_stalled_ = true;
      shortest_stall_ms = std::min(shortest_stall_ms, stall_ms);
      if (repetitions == kMaxStalls || seconds_since_begin() > settings_.give_up_s) break;
      rows_.pop_back();
      ++repetitions;
    }
    Row& last = rows_.back();
    if (repetitions > 0) last.note += fmt::format(" (repeated {} times because the machine stalled)", repetitions);
    if (last.is_broken && is_stalled(last, shortest_stall_ms)) {
      last.is_broken = false;
      last.is_skipped = true;
      last.note += fmt::format("; not judged: in each run the machine stood still for {:.0f} ms or more", shortest_stall_ms);
    }
    on_row_(last);
  };
  row("haptics_node killed", [&](const auto& name) { haptics_dies(name, SIGKILL); });
  row("haptics_node frozen (SIGSTOP)", [&](const auto& name) { haptics_dies(name, SIGSTOP); });
  row("io_node's network thread hangs", [&](const auto& name) { thread_hangs(name, {"hapton-network"}, Kind::inside); });
  row("io_node's device loop hangs", [&](const auto& name) { thread_hangs(name, {"hapton-device"}, Kind::inside); });
  row("io_node's stale-force watchdog hangs", [&](const auto& name) { hung_thread_does_not_stop_touch(name, "hapton-release"); });
  row("io_node's main thread hangs", [&](const auto& name) { hung_thread_does_not_stop_touch(name, ""); });
  row("device loop and stale-force watchdog both hang (double fault)", [&](const auto& name) {
    thread_hangs(name, {"hapton-device", "hapton-release"}, Kind::outside);
  });
  row("the watchdog process killed", [&](const auto& name) { watchdog_dies(name, SIGKILL); });
  row("the watchdog process frozen (SIGSTOP)", [&](const auto& name) { watchdog_dies(name, SIGSTOP); });
  row("io_node frozen (SIGSTOP), then continued", [&](const auto&) { io_node_freezes(); });
  row("io_node killed (SIGKILL)", [&](const auto& name) { io_node_dies(name, SIGKILL); });
  row("io_node crashes (SIGSEGV)", [&](const auto& name) { io_node_dies(name, SIGSEGV); });
  row(kBusyRealtime, [&](const auto&) { realtime_is_taken(); });
  row("flood: junk, 100 k/s from one port", [&](const auto& name) { flood(name, "junk", 100'000, 1); });
  row("flood: junk, as fast as can be from one port", [&](const auto& name) { flood(name, "junk", kFastest, 1); });
  row("flood: junk, as fast as can be from 256 ports", [&](const auto& name) { flood(name, "junk", kFastest, 256); });
  row("flood: oversized, as fast as can be from 16 ports", [&](const auto& name) { flood(name, "oversized", kFastest, 16); });
  row("flood: one handshake replayed, 200 k/s from one port", [&](const auto& name) { flood(name, "handshake", 200'000, 1); });
  row("flood: one handshake replayed, as fast as can be, 256 ports", [&](const auto& name) { flood(name, "handshake", kFastest, 256); });
  row("flood: data replayed, as fast as can be from 16 ports", [&](const auto& name) { flood(name, "data", kFastest, 16); });
  row("flood: data as from the haptics node, as fast as can be", [&](const auto& name) { flood(name, "spoofed", kFastest, 1); });
  row("flood: junk at the haptics node, as fast as can be", [&](const auto& name) { flood(name, "junk", kFastest, 16, true); });
  return std::move(rows_);
}

}  // namespace

std::vector<Row> run_list(const Settings& settings, const std::function<void(const Row&)>& on_row) { return List(settings, on_row).run(); }

}  // namespace hapton::attack
