#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recording/recording_index.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// The line at the bottom of the picture that stands for a whole recording. Positions on it are shares of its length, 0 to 1.
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

// The largest number of bands, and of ticks of each kind, for any duration: with more, two would be less than a pixel apart.
constexpr int kTimeLineColumns = 2000;
TimeLineShown make_time_line(const RecordingIndex& index);

// The share of the line at a time of the recording, 0 to 1 (0 if the recording has no duration), and the time at a share.
double find_time_line_share(const RecordingIndex& index, double t_s);
double find_time_line_moment(const RecordingIndex& index, double share);

// Where the line is in one eye's picture, pixels from the lower left corner.
struct TimeLinePlace {
  double left_px = 0.0;
  double width_px = 0.0;
  double bottom_px = 0.0;
  double height_px = 0.0;              // height of the line itself
  double strip_height_px = 0.0;        // height of the strip at the lower edge in which a press counts as a press on the line
  double share_at(double x_px) const;  // 0 to 1; beside the line 0 or 1
};
TimeLinePlace place_time_line(PictureSize size);

// A time for people: "1:02:03.4", "2:03.456". decimals: of the seconds.
std::string describe_time(double t_s, int decimals = 1);

// The first mark after a time and the last one before it, without a mark within 1 us of that time. Null: there is none.
const RecordingMark* find_next_mark(const RecordingIndex& index, double t_s);
const RecordingMark* find_previous_mark(const RecordingIndex& index, double t_s);

}  // namespace hapton
