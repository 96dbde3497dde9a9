#pragma once

#include <cstdint>
#include <string>

#include "runtime/latency_histogram.h"

namespace hapton {

// Frames and their times. Times: any monotonic clock, ns. RT: no.
class FrameLog {
 public:
  // One frame, from the start of drawing to its end.
  void record_frame(std::int64_t start_ns, std::int64_t end_ns);
  // From the newest probe state in that frame, when it was sampled or, if unknown, received, to the frame's end.
  void record_motion_to_photon(std::int64_t motion_to_photon_ns) { motion_to_photon_.record(motion_to_photon_ns); }
  // A new probe state that would not change the picture.
  void count_skipped() { ++skipped_; }

  std::uint64_t drawn() const { return drawn_; }
  std::uint64_t skipped() const { return skipped_; }

  // Frames a second while something moved: pauses above a quarter of a second are left out. 0 until known.
  double rate_hz() const;
  // The same over the newest second or so, for the HUD.
  double recent_rate_hz() const { return recent_hz_; }
  const LatencyHistogram& draw_time() const { return draw_time_; }
  const LatencyHistogram& motion_to_photon() const { return motion_to_photon_; }
  // "motion to photon p50 8.1 ms p99 12.0 ms (0.3, 0.4 frames)"; empty while nothing has moved.
  std::string describe_motion() const;

  // One line for people.
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
  double first_draw_ms_ = 0.0;  // of the first frame, which builds shaders
};

}  // namespace hapton
