#pragma once

#include <optional>
#include <string>
#include <vector>

#include "link/messages.h"
#include "recording/recording_index.h"
#include "recording/recording_rows.h"
#include "vision_node/live_plots.h"
#include "vision_node/session_player.h"

namespace hapton {

// What the hub would have sent to a vision node at a moment of a recording.
struct RecordedState {
  ProbeState state;              // of the newest sample with a reply if not older than 20 ms, else of the newest; force: of the newest
  Pose X_WS = Pose::Identity();  // pose of the static scene with which the force was computed
  bool has_reply = false;        // the sample of `state` has a reply
};

// The state at a time of RecordingIndex; before the first sample, that of the first. None: the file has changed since the index was made.
std::optional<RecordedState> find_recorded_state(const RecordingIndex& index, RecordingRows& rows, double t_s);

// The rate of the device's samples over the second before; in the first second of a recording, over that second. 0: not known.
double find_recorded_rate_hz(const RecordingIndex& index, double t_s);

// Plots of the last five seconds: force on the motors and round trip, the largest value of each span, with the newest one in the title.
std::vector<PlotContent> make_recorded_plots(const RecordingIndex& index, double t_s);

// A line for the HUD: "recording monday.hapton   0:12.345 of 1:00.000   sample 12345   1x, paused".
std::string describe_recording(const std::string& name, const SessionPlayer& player, std::uint64_t sample);
// The newest marker or fault that is not older than 2 s: "marker: trial 7", "FAULT: speed". Empty: there is none.
std::string describe_mark(const RecordingIndex& index, double t_s);

}  // namespace hapton
