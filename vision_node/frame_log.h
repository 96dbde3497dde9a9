#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "runtime/latency_histogram.h"

namespace hapton {

// What was drawn and how long it took. Times: any monotonic clock, ns. RT: no.
class FrameLog {
 public:
  // One picture, from the start of drawing to its end.
  void drew(std::int64_t start_ns, std::int64_t end_ns);
  // From the newest probe state in that picture, when it was sampled or, where that is not known, received, to the picture's end.
  void moved(std::int64_t motion_to_photon_ns) { motion_to_photon_.record(motion_to_photon_ns); }
  // A new probe state that looked like the picture there was.
  void skipped() { ++skipped_; }

  std::uint64_t drawn() const { return drawn_; }
  std::uint64_t skipped_count() const { return skipped_; }

  // Pictures a second while something moved: pauses above a quarter of a second between pictures are left out. 0 until known.
  double rate_hz() const;
  // The same over the newest second or so, for the HUD.
  double recent_rate_hz() const { return recent_hz_; }
  const LatencyHistogram& draw_time() const { return draw_time_; }
  const LatencyHistogram& motion_to_photon() const { return motion_to_photon_; }
  // Of the first picture, which builds shaders. 0 until then.
  double first_draw_ms() const { return first_draw_ms_; }
  // "motion to photon p50 8.1 ms p99 12.0 ms (0.3, 0.4 frames)"; empty while nothing has moved.
  std::string describe_motion(std::string_view name = "motion to photon") const;

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
  double first_draw_ms_ = 0.0;
};

}  // namespace hapton
