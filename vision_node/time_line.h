#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recording/recording_index.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// The line at the bottom of the picture that stands for a whole recording. Places on it are shares of its length, 0 to 1.
struct TimeLineShown {
  struct Band {
    double from = 0.0;
    double to = 0.0;
    friend bool operator==(const Band&, const Band&) = default;
  };
  struct Tick {
    double at = 0.0;
    bool is_fault = false;
    friend bool operator==(const Tick&, const Tick&) = default;
  };
  std::vector<Band> contact;
  std::vector<Tick> ticks;
  std::string begin;
  std::string end;
  friend bool operator==(const TimeLineShown&, const TimeLineShown&) = default;
};

// The largest number of bands, and of ticks of each kind, for any duration: more would be nearer to each other than a pixel.
constexpr int kTimeLineColumns = 2000;
TimeLineShown make_time_line(const RecordingIndex& index);

// Share of the line at a moment, 0 to 1; 0 where the recording has no duration.
double find_time_line_share(const RecordingIndex& index, double t_s);
double find_time_line_moment(const RecordingIndex& index, double share);

// Where the line is in one eye's picture, pixels from the lower left corner.
struct TimeLinePlace {
  double left_px = 0.0;
  double width_px = 0.0;
  double bottom_px = 0.0;
  double height_px = 0.0;              // of the line itself
  double reserve_px = 0.0;             // of the picture's lower edge: a press in there is on the line
  double share_at(double x_px) const;  // 0 to 1, also beside the line
};
TimeLinePlace place_time_line(PictureSize size);

// "1:02:03.4", "2:03.456": as many decimals as given.
std::string describe_time(double t_s, int decimals = 1);

// The marks after and before a moment. Null: none. A mark within 1 us of the moment is at it.
const RecordingMark* find_next_mark(const RecordingIndex& index, double t_s);
const RecordingMark* find_previous_mark(const RecordingIndex& index, double t_s);

}  // namespace hapton
