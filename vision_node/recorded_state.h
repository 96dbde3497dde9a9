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
  ProbeState state;              // of the newest sample with a reply, if it is not older than 20 ms, otherwise of the newest sample
  Pose X_WS = Pose::Identity();  // pose of the static scene with which its force was computed
  bool has_reply = false;        // there is such a sample
};

// The state at a time of RecordingIndex. None: the file has changed since the index was made. RT: no.
std::optional<RecordedState> find_recorded_state(const RecordingIndex& index, RecordingRows& rows, double t_s);

// The rate of the device's samples over the second before; 0: not known.
double find_recorded_rate_hz(const RecordingIndex& index, double t_s);

// Plots of the last five seconds: the force on the motors and the round trip, the largest of each span, with the newest value in the title.
std::vector<PlotContent> make_recorded_plots(const RecordingIndex& index, double t_s);

// The line of the HUD: "recording monday.hapton   0:12.345 of 1:00.000   sample 12345   1x, paused".
std::string describe_recording(const std::string& name, const SessionPlayer& player, std::uint64_t sample);
// The newest marker or faults that are not older than 2 s: "marker: trial 7", "FAULT: speed". Empty: there are none.
std::string describe_mark(const RecordingIndex& index, double t_s);

}  // namespace hapton
