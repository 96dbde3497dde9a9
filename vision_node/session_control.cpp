#include "vision_node/session_control.h"

#include <string_view>
#include <utility>

#include "vision_node/time_line.h"

namespace hapton {

bool SessionControl::take_changed() { return std::exchange(has_changed_, false); }

void SessionControl::step(std::optional<double> to_s) {
  player_.pause();
  if (to_s) player_.seek(*to_s);
}

bool SessionControl::press_key(char key) {
  const double moment_s = player_.moment_s();
  switch (key) {
    case ' ':
      player_.toggle_pause();
      return true;
    case '.':
      step(rows_.next_s(moment_s));
      return true;
    case ',': {
      // Step back from the shown sample, which may be earlier than the moment.
      const CycleRow* shown = rows_.at(moment_s);
      step(shown != nullptr ? rows_.previous_s(shown->sample_t_s) : std::nullopt);
      return true;
    }
    case 'n':
      if (const RecordingMark* mark = find_next_mark(index_, moment_s)) player_.seek(mark->t_s);
      return true;
    case 'N':
      if (const RecordingMark* mark = find_previous_mark(index_, moment_s)) player_.seek(mark->t_s);
      return true;
    case '[':
      player_.slow_down();
      return true;
    case ']':
      player_.speed_up();
      return true;
    case 'a':
      player_.seek(player_.begin_s());
      return true;
    default:
      // These keys control dials, hand and pen of a live session; they have no effect on a recording.
      return key != 0 && std::string_view("xXyYzZ0hpdluUwt").find(key) != std::string_view::npos;
  }
}

bool SessionControl::drag(const WindowEvent& event, PictureSize size) {
  if (!drag_left_edge_px_) return false;
  player_.seek(find_time_line_moment(index_, place_time_line(size).share_at(event.x_px - *drag_left_edge_px_)));
  return true;
}

bool SessionControl::handle(const WindowEvent& event, const std::optional<std::array<int, 2>>& pixel, PictureSize size) {
  using Kind = WindowEvent::Kind;
  bool is_used = false;
  if (event.kind == Kind::key && event.navigation_key == WindowEvent::NavigationKey::none) {
    is_used = press_key(event.key);
  } else if (event.kind == Kind::press && event.button == WindowEvent::Button::left) {
    if (pixel && (*pixel)[1] < place_time_line(size).strip_height_px) {
      drag_left_edge_px_ = event.x_px - (*pixel)[0];
      player_.hold(true);
      drag(event, size);
    }
    is_used = true;  // a recording has no hand to lead
  } else if (event.kind == Kind::release && event.button == WindowEvent::Button::left) {
    drag_left_edge_px_.reset();
    player_.hold(false);
    is_used = true;
  } else if (event.kind == Kind::move) {
    is_used = drag(event, size);
  }
  has_changed_ = has_changed_ || is_used;
  return is_used;
}

}  // namespace hapton
