#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/math/types.h"

namespace hapton {

// How a receiver continues a signal between two updates: with the last value, or along a line.
enum class Prediction : std::uint8_t { hold, linear };

// One update of a signal, as it is sent.
struct SignalUpdate {
  Vec3 value = Vec3::Zero();
  Vec3 per_ns = Vec3::Zero();  // slope of the line that continues it; zero: the value is held
};

// A signal as its receiver knows it. Units: the signal's, ns. RT: yes. Threads: one.
class PredictedSignal {
 public:
  // A line is followed for no longer than this; then its value is held.
  static constexpr std::int64_t kLongestNs = 50'000'000;

  void update(const SignalUpdate& update, std::int64_t now_ns) noexcept;
  // None before the first update.
  std::optional<Vec3> predict(std::int64_t now_ns) const noexcept;
  // The value of the last update.
  const Vec3& value() const noexcept { return last_.value; }

 private:
  SignalUpdate last_;
  std::int64_t updated_ns_ = 0;
  bool has_value_ = false;
};

// Weber's law: a change below a certain share of the last value is not felt, so it is not sent. The sender assumes a receiver that
// gets every update without delay. Source: Hinterseer, Hirche, Chaudhuri, Steinbach and Buss, "Perception-based data reduction and
// transmission of haptic data in telepresence and teleaction systems", IEEE Trans. Signal Processing 56 (2008); IEEE 1918.1.1-2024, codec
// without delay robustness. They draw the line through the last two updates. Our updates contain the slope of the signal over kSlopeRows
// values: on a faceted mesh their prediction sends more updates than no prediction, and a lost update distorts it. RT: yes. Threads: one.
class DeadbandCoder {
 public:
  static constexpr std::size_t kSlopeRows = 10;  // a slope over 9 ms at 1 kHz

  // fraction: Weber's; 0: each value is sent. least: a last value that is smaller counts as this.
  DeadbandCoder(double fraction, double least, Prediction prediction) noexcept
      : fraction_(fraction), min_norm_(least), prediction_(prediction) {}

  // Takes this period's value. True: it must be sent, because its difference from the receiver's prediction can be felt.
  bool note(const Vec3& value, std::int64_t now_ns) noexcept;
  // Returns the update that sends the value noted last, now. Pre: a value was noted.
  SignalUpdate send() noexcept;

 private:
  struct TimedValue {
    Vec3 value = Vec3::Zero();
    std::int64_t time_ns = 0;
  };

  double fraction_;
  double min_norm_;
  Prediction prediction_;
  PredictedSignal receiver_;
  std::array<TimedValue, kSlopeRows> recent_;  // a ring
  std::size_t count_ = 0;
};

}  // namespace hapton
