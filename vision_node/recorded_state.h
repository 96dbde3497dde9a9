#pragma once

#include <optional>
#include <string>
#include <vector>

#include "link/messages.h"
#include "session/session_index.h"
#include "session/session_rows.h"
#include "vision_node/live_plots.h"
#include "vision_node/session_player.h"

namespace hapton {

// A moment of a recording as the hub would have shown it to a vision node.
struct RecordedState {
  ProbeState state;              // of the newest sample with a reply, if it is not older than 20 ms, otherwise of the newest sample
  Pose X_WS = Pose::Identity();  // that its force was computed with
  bool has_reply = false;
};

// None: the file has changed since the index was made.
std::optional<RecordedState> find_recorded_state(const SessionIndex& index, SessionRows& rows, double t_s);

// Samples a second of the device, over the second before; 0: not known.
double find_recorded_rate_hz(const SessionIndex& index, double t_s);

// The written force and the round trip, each span's largest, in the five seconds before, with the newest value in the title.
std::vector<PlotShown> make_recorded_plots(const SessionIndex& index, double t_s);

// "recording monday.hapton   0:12.345 of 1:00.000   sample 12345   1x, paused".
std::string describe_recording(const std::string& name, const SessionPlayer& player, std::uint64_t sample);
// The last marker or faults, while they are not older than 2 s: "marker: trial 7", "FAULT: speed". Empty: none.
std::string describe_mark(const SessionIndex& index, double t_s);

}  // namespace hapton
