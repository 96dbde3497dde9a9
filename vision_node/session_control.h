#pragma once

#include <array>
#include <optional>

#include "recording/recording_index.h"
#include "recording/recording_rows.h"
#include "vision_node/interaction.h"
#include "vision_node/session_player.h"

namespace hapton {

// Turns keys, and the mouse on the time line, into what the player of a recording does: space pauses, comma and period step by one sample,
// n and N go to the next and the previous marker or fault, [ and ] change the speed, a goes to the beginning, a left drag on the line to
// the moment under the pointer. Keys and drags that turn, move or draw in a live session have no effect. RT: no.
class SessionControl {
 public:
  // Pre: all outlive this.
  SessionControl(const RecordingIndex& index, RecordingRows& rows, SessionPlayer& player) : index_(index), rows_(rows), player_(player) {}

  // True: the event is handled here, or must have no effect. pixel: its place in an eye's picture of that size; none: beside the picture.
  bool handle(const WindowEvent& event, const std::optional<std::array<int, 2>>& pixel, PictureSize size);
  // True: handle() has used an event since the last call, so the picture has to show its effect at once.
  bool take_changed();

 private:
  bool press_key(char key);
  bool drag(const WindowEvent& event, PictureSize size);
  void step(std::optional<double> to_s);

  const RecordingIndex& index_;
  RecordingRows& rows_;
  SessionPlayer& player_;
  std::optional<int> drag_left_edge_px_;  // the picture's left edge in the window, from the drag's start; none: the line is not dragged
  bool has_changed_ = false;
};

}  // namespace hapton
