#pragma once

#include <functional>
#include <string>
#include <vector>

namespace hapton::attack {

// The promise (docs/safety-case.md): 20 ms after its sample, plus a cycle of 1 kHz, while the process runs; if it is frozen or killed, as
// long after that.
constexpr double kInsideMs = 21.0;
constexpr double kOutsideMs = 50.0;
// Where patches of the scene are felt, they are for a second after haptics was heard last.
constexpr double kAloneMs = 1000.0 + kInsideMs;
// A flood that a hub must bear without more late forces than this share.
constexpr double kBearablePerS = 200'000.0;
constexpr double kMaxLateShare = 0.01;

enum class Kind { inside, outside, alone };

struct Settings {
  int repeat = 3;
  double flood_s = 3.0;
  double slack_ms = 0.0;
  double give_up_s = 1e9;  // on a machine that stood still meanwhile, what is not begun by then is skipped
  std::string only;
  std::string touch = "auto";  // of io_node --touch, whose default this is
};

// One attack or fault, and what became of the force. Times below 0: not measured.
struct Row {
  std::string name;
  Kind kind = Kind::inside;
  double bound_ms = kInsideMs;
  double after_sample_ms = -1.0;  // the oldest force seen on the motors, counted from its sample
  double after_event_ms = -1.0;   // the fault -> nothing on the motors
  double blind_ms = -1.0;         // the longest time between two samples: the true time may be longer by that
  bool is_skipped = false;
  bool is_over = false;    // the bound, by less than the slack
  bool is_broken = false;  // the bound, or what else is promised: see the note
  std::string note = {};

  double release_ms() const { return kind == Kind::inside ? after_sample_ms : after_event_ms; }
};

// The whole list in order; calls on_row with each row when it is done.
std::vector<Row> run_list(const Settings& settings, const std::function<void(const Row&)>& on_row);

}  // namespace hapton::attack
