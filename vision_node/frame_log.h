#pragma once

#include <cstdint>
#include <string>

#include "runtime/latency_histogram.h"

namespace hapton {

// Counts frames and records their draw times. Times: any monotonic clock, ns. RT: no. Threads: one.
class FrameLog {
 public:
  // One frame, from the start of drawing to its end.
  void record_frame(std::int64_t start_ns, std::int64_t end_ns);
  // Motion to photon of the frame recorded last: from the arrival of its newest probe state to the frame's end.
  void record_motion_to_photon(std::int64_t motion_to_photon_ns) { motion_to_photon_.record(motion_to_photon_ns); }
  // Counts a probe state that needs no new frame, because the picture would not change.
  void count_skipped() { ++skipped_; }

  std::uint64_t drawn() const { return drawn_; }
  std::uint64_t skipped() const { return skipped_; }

  // Frames a second, not counting pauses: intervals longer than a quarter of a second and than twice the drawing time. 0 until known.
  double rate_hz() const;
  // The same over the newest complete half second, for the HUD.
  double recent_rate_hz() const { return recent_hz_; }
  const LatencyHistogram& draw_time() const { return draw_time_; }
  const LatencyHistogram& motion_to_photon() const { return motion_to_photon_; }
  // "motion to photon p50 8.1 ms p99 12.0 ms (0.3, 0.4 frames)"; empty: none was recorded.
  std::string describe_motion() const;

  // Summary in one line.
  std::string describe() const;

 private:
  std::uint64_t drawn_ = 0;
  std::uint64_t skipped_ = 0;
  std::int64_t last_end_ns_ = 0;
  std::int64_t moving_ns_ = 0;
  std::uint64_t moving_frames_ = 0;
  std::int64_t window_ns_ = 0;
  int window_frames_ = 0;
  double recent_hz_ = 0.0;
  LatencyHistogram draw_time_;
  LatencyHistogram motion_to_photon_;
  double first_draw_ms_ = 0.0;  // drawing time of the first frame, which also builds shaders
};

}  // namespace hapton
