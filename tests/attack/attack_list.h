#pragma once

#include <functional>
#include <string>
#include <vector>

namespace hapton::attack {

// The promise (docs/safety-case.md): while io_node runs, a force ends at most 20 ms and a cycle of 1 kHz after its sample; if io_node is
// frozen or killed, it ends within kOutsideMs of that event.
constexpr double kInsideMs = 21.0;
constexpr double kOutsideMs = 50.0;
// Forces from patches of the scene end at most this long after the last message of the haptics node.
constexpr double kAloneMs = 1000.0 + kInsideMs;
// In a flood of up to kBearablePerS datagrams per second, at most the share kMaxLateShare of the forces may be late, lost or superseded.
constexpr double kBearablePerS = 200'000.0;
constexpr double kMaxLateShare = 0.01;

// Of a fault: within a running io_node; of io_node as a whole; or of the haptics node, while io_node computes forces from patches alone.
enum class Kind { inside, outside, alone };

struct Settings {
  int repeat = 3;
  double flood_s = 3.0;
  double slack_ms = 0.0;
  double give_up_s = 1e9;  // if the machine has stood still meanwhile, rows not begun by then are skipped
  std::string only;
  std::string touch = "auto";  // value of io_node --touch, and its default
};

// One attack or fault, and what became of the force. Times below 0: not measured.
struct Row {
  std::string name;
  Kind kind = Kind::inside;
  double bound_ms = kInsideMs;
  double after_sample_ms = -1.0;  // the largest age of a force on the motors, counted from its sample
  double after_event_ms = -1.0;   // from the fault until no force is on the motors
  double blind_ms = -1.0;         // the longest time between two observations: the true times may be longer by this
  bool is_skipped = false;
  bool is_over = false;    // the bound, or kMaxLateShare, was exceeded
  bool is_broken = false;  // it was exceeded by more than the slack, or another promise was broken: see the note
  std::string note = {};

  double release_ms() const { return kind == Kind::inside ? after_sample_ms : after_event_ms; }
};

// The whole list in order; calls on_row with each row when it is done.
std::vector<Row> run_list(const Settings& settings, const std::function<void(const Row&)>& on_row);

}  // namespace hapton::attack
