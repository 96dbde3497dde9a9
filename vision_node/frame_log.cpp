#include "vision_node/frame_log.h"

#include <algorithm>

#include <fmt/format.h>

namespace hapton {
namespace {

constexpr std::int64_t kPauseNs = 250'000'000;   // a longer interval between frames is a pause, not a low frame rate; a choice
constexpr std::int64_t kWindowNs = 500'000'000;  // averaging time of the displayed frame rate: two numbers a second are readable

}  // namespace

void FrameLog::record_frame(std::int64_t start_ns, std::int64_t end_ns) {
  draw_time_.record(end_ns - start_ns);
  if (drawn_ == 0) first_draw_ms_ = static_cast<double>(end_ns - start_ns) * 1e-6;
  const std::int64_t period = end_ns - last_end_ns_;
  if (drawn_ > 0 && period <= std::max(kPauseNs, 2 * (end_ns - start_ns))) {
    moving_ns_ += period;
    ++moving_frames_;
    window_ns_ += period;
    ++window_frames_;
    if (window_ns_ >= kWindowNs) {
      recent_hz_ = window_frames_ * 1e9 / static_cast<double>(window_ns_);
      window_ns_ = 0;
      window_frames_ = 0;
    }
  }
  last_end_ns_ = end_ns;
  ++drawn_;
}

double FrameLog::rate_hz() const {
  return moving_ns_ > 0 ? static_cast<double>(moving_frames_) * 1e9 / static_cast<double>(moving_ns_) : 0.0;
}

std::string FrameLog::describe_motion() const {
  if (motion_to_photon_.count() == 0) return {};
  const double p50_ns = static_cast<double>(motion_to_photon_.quantile_ns(0.5));
  const double p99_ns = static_cast<double>(motion_to_photon_.quantile_ns(0.99));
  std::string text = fmt::format("motion to photon p50 {:.1f} ms p99 {:.1f} ms", p50_ns * 1e-6, p99_ns * 1e-6);
  if (rate_hz() > 0.0) text += fmt::format(" ({:.2f}, {:.2f} frames)", p50_ns * 1e-9 * rate_hz(), p99_ns * 1e-9 * rate_hz());
  return text;
}

std::string FrameLog::describe() const {
  std::string text = fmt::format(
      "frames drawn {}, states that needed no frame {}, {:.1f} frames/s while moving, drawing p50 {:.1f} ms p99 {:.1f} ms, the first "
      "{:.0f} ms",
      drawn_, skipped_, rate_hz(), draw_time_.quantile_ns(0.5) * 1e-6, draw_time_.quantile_ns(0.99) * 1e-6, first_draw_ms_);
  if (motion_to_photon_.count() > 0) text += ", " + describe_motion();
  return text;
}

}  // namespace hapton
