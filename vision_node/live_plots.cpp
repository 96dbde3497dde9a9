#include "vision_node/live_plots.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace hapton {
double choose_top(double value, double min_top) {
  const double needed = std::isfinite(value) ? std::max(value, min_top) : min_top;
  double power = std::pow(10.0, std::floor(std::log10(needed)));
  for (;; power *= 10.0) {
    for (const double step : {1.0, 2.0, 5.0}) {
      if (step * power >= needed) return step * power;
    }
  }
}

PlotContent make_plot(std::vector<CurvePoint> points, std::string_view name, std::string_view unit, double limit, double min_top) {
  PlotContent plot;
  plot.points = std::move(points);
  plot.limit = limit;
  double largest = limit;
  for (const CurvePoint& point : plot.points) largest = std::max(largest, point.value);
  plot.top = choose_top(largest, min_top);
  const double newest = plot.points.empty() ? 0.0 : plot.points.back().value;
  const std::string limited = limit > 0.0 ? fmt::format(", limit {:.3g}", limit) : std::string();
  plot.title = fmt::format("{} {:.3g} {}{}   (0 to {:g}, {:g} s)", name, newest, unit, limited, plot.top, RecentCurve::kSeconds);
  return plot;
}

void LivePlots::receive(const ProbeState& state, std::int64_t now_ns) {
  newest_force_n_ = state.force_n.norm();
  force_n_.add(now_ns, *newest_force_n_);
  limit_n_ = std::isfinite(state.force_limit_n) ? static_cast<double>(std::max(0.0F, state.force_limit_n)) : 0.0;
}

void LivePlots::record_motion_to_photon(std::int64_t age_ns, std::int64_t now_ns) {
  age_ms_.add(now_ns, 1e-6 * static_cast<double>(age_ns));
}

bool LivePlots::wants_picture(std::int64_t now_ns) const { return is_shown_ && newest_force_n_ && now_ns - plots_made_ns_ >= kPeriodNs; }

const std::vector<PlotContent>& LivePlots::update(std::int64_t now_ns) {
  if (!is_shown_) plots_.clear();
  if (!is_shown_ || (!plots_.empty() && now_ns - plots_made_ns_ < kPeriodNs)) return plots_;
  plots_made_ns_ = now_ns;
  // Without a new state the force is still the last one: the hub does not send states that would look the same.
  if (newest_force_n_) force_n_.add(now_ns, *newest_force_n_);
  plots_ = {make_plot(force_n_.points(now_ns), "force", "N", limit_n_, kMinTopN),
            make_plot(age_ms_.points(now_ns), "age", "ms", 0.0, kMinTopMs)};
  return plots_;
}

}  // namespace hapton
