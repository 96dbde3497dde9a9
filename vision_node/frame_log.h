#pragma once

#include <cstdint>
#include <string>

#include "runtime/latency_histogram.h"

namespace hapton {

// What was drawn and how long it took. Times: any monotonic clock, ns. RT: no.
class FrameLog {
 public:
  // One picture, from the start of drawing to its end.
  void drew(std::int64_t start_ns, std::int64_t end_ns);
  // A new probe state that looked like the picture there was.
  void skipped() { ++skipped_; }

  std::uint64_t drawn() const { return drawn_; }
  std::uint64_t skipped_count() const { return skipped_; }

  // Pictures a second while something moved: pauses above a quarter of a second between pictures are left out. 0 until known.
  double rate_hz() const;
  // The same over the newest second or so, for the HUD.
  double recent_rate_hz() const { return recent_hz_; }
  const LatencyHistogram& draw_time() const { return draw_time_; }

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
};

}  // namespace hapton
