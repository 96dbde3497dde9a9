#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "link/messages.h"
#include "vision_node/recent_curve.h"

namespace hapton {

// A curve to draw, on a scale from zero to top.
struct PlotContent {
  std::string title;  // with the unit, the newest value and the scale
  std::vector<CurvePoint> points;
  double top = 1.0;
  double limit = 0.0;  // value at which a horizontal line is drawn; 0: none
  friend bool operator==(const PlotContent&, const PlotContent&) = default;
};

// Plots of the force on the hand and of the age of the drawn state, over the last seconds. Times: any one monotonic clock, ns. RT: no.
class LivePlots {
 public:
  // Least time between two frames that are drawn only because a curve has changed: ten a second are enough.
  static constexpr std::int64_t kPeriodNs = 100'000'000;

  explicit LivePlots(bool is_shown) : is_shown_(is_shown) {}

  void toggle() { is_shown_ = !is_shown_; }
  bool is_shown() const { return is_shown_; }

  void receive(const ProbeState& state, std::int64_t now_ns);
  // Call it when the hub no longer replies: then no force is known.
  void forget_force() { newest_force_n_.reset(); }
  // age_ns: from the arrival of the newest drawn state until the frame was in the window.
  void record_motion_to_photon(std::int64_t age_ns, std::int64_t now_ns);

  // True: the plots are shown, the hub has sent a force, and the drawn curves are at least kPeriodNs old.
  bool wants_picture(std::int64_t now_ns) const;
  // The plots of force and age, in this order; empty if they are not shown. They change at most once in kPeriodNs, because a plot that does
  // not change costs little to draw.
  const std::vector<PlotContent>& update(std::int64_t now_ns);

 private:
  bool is_shown_;
  RecentCurve force_n_;
  RecentCurve age_ms_;
  double limit_n_ = 0.0;                  // 0: not known
  std::optional<double> newest_force_n_;  // the newest force, which holds until the next state; none: not known
  std::vector<PlotContent> plots_;
  std::int64_t plots_made_ns_ = 0;
};

// Makes a plot. Its title has the newest value, the limit (0: none) and the scale, whose top is at least min_top.
PlotContent make_plot(std::vector<CurvePoint> points, std::string_view name, std::string_view unit, double limit, double min_top);

// The smallest tops of the scales of a force (N) and of a time (ms).
constexpr double kMinTopN = 1.0;
constexpr double kMinTopMs = 20.0;

// The smallest of the numbers 1, 2 and 5 times a power of ten that is at least the value and at least min_top. Pre: min_top > 0.
double choose_top(double value, double min_top);

}  // namespace hapton
