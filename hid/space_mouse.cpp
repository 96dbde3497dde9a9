#include "hid/space_mouse.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

constexpr std::uint8_t kPushId = 1;
constexpr std::uint8_t kTurnId = 2;
constexpr std::uint8_t kButtonsId = 3;
constexpr std::size_t kThreeAxesBytes = 1 + 6;  // the id, then an int16 for each axis
constexpr std::size_t kSixAxesBytes = 1 + 12;

double int16_at(std::span<const std::uint8_t> report, std::size_t byte) noexcept {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(report[byte] | (report[byte + 1] << 8)));
}

// The deflection beyond the dead band, as a share of the travel beyond it: so nothing jumps at the edge of the dead band.
double share(double counts) noexcept {
  const double beyond = std::max(std::abs(counts) - SpaceMouseDecoder::kDeadBand, 0.0);
  const double travel = SpaceMouseDecoder::kFullDeflection - SpaceMouseDecoder::kDeadBand;
  return std::copysign(std::min(beyond / travel, 1.0), counts);
}

// From the axes of the device (x right, y towards the person, z down) to x right, y up, z towards the person.
Vec3 to_person(const double* counts) noexcept { return {share(counts[0]), -share(counts[2]), share(counts[1])}; }

}  // namespace

bool SpaceMouseDecoder::take(std::span<const std::uint8_t> report, std::int64_t now_ns) noexcept {
  if (report.empty()) return false;
  const auto take_three = [&](std::size_t byte, std::size_t axis) {
    for (std::size_t n = 0; n < 3; ++n) counts_[axis + n] = int16_at(report, byte + 2 * n);
  };
  switch (report[0]) {
    case kPushId:
      if (report.size() < kThreeAxesBytes) return false;
      take_three(1, 0);
      pushed_ns_ = now_ns;
      if (report.size() >= kSixAxesBytes) {
        take_three(7, 3);
        turned_ns_ = now_ns;
      }
      return true;
    case kTurnId:
      if (report.size() < kThreeAxesBytes) return false;
      take_three(1, 3);
      turned_ns_ = now_ns;
      return true;
    case kButtonsId:
      if (report.size() < 2) return false;
      buttons_ = 0;
      for (std::size_t byte = 1; byte < std::min<std::size_t>(report.size(), 5); ++byte) {
        buttons_ |= std::uint32_t{report[byte]} << (8 * (byte - 1));
      }
      return true;
    default:
      return false;
  }
}

SpaceMouseState SpaceMouseDecoder::state(std::int64_t now_ns) const noexcept {
  SpaceMouseState state;
  if (now_ns - pushed_ns_ <= kStaleNs) state.push = to_person(counts_.data());
  if (now_ns - turned_ns_ <= kStaleNs) state.turn = to_person(counts_.data() + 3);
  state.buttons = buttons_;
  return state;
}

}  // namespace hapton
