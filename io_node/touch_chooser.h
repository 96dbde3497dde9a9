#pragma once

#include <cstdint>
#include <string_view>

namespace hapton {

// Where forces are computed: by the haptics node (remote), by the hub from the patches that it gets (patch), or chosen by the round trip.
enum class TouchChoice : std::uint8_t { remote, patch, automatic };

// Chooses by the round trip, with hysteresis: patches above kSlowS, remote force again when it has stayed below kFastS for kSettledNs. A
// local network is a hundred times faster than either, so on it the force stays remote. Between the two, remote force is late enough to be
// felt but not to be unstable at the stiffness of ordinary materials. Units: s, ns. RT: yes. Threads: one.
class TouchChooser {
 public:
  // Choices. Above 20 ms a force is rejected (kCommandTimeoutNs), so both leave room for jitter.
  static constexpr double kSlowS = 8e-3;
  static constexpr double kFastS = 4e-3;
  static constexpr std::int64_t kSettledNs = 3'000'000'000;

  explicit TouchChooser(TouchChoice choice) noexcept : choice_(choice), wants_patch_(choice == TouchChoice::patch) {}

  // round_trip_s: a median; below 0: not known.
  bool choose_patch(double round_trip_s, std::int64_t now_ns) noexcept {
    if (choice_ != TouchChoice::automatic) return wants_patch_;
    if (!(round_trip_s >= 0.0 && round_trip_s < kFastS) || !wants_patch_) fast_since_ns_ = now_ns;
    if (round_trip_s > kSlowS) wants_patch_ = true;
    if (now_ns - fast_since_ns_ >= kSettledNs) wants_patch_ = false;
    return wants_patch_;
  }

 private:
  TouchChoice choice_;
  bool wants_patch_;
  std::int64_t fast_since_ns_ = 0;
};

}  // namespace hapton
