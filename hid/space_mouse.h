#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/math/types.h"

namespace hapton {

// How far the cap of a SpaceMouse is pushed and turned, in shares of its full way: -1 .. 1 each.
// Frame: the person's, as W: x right, y up, z to the person; turns about these by the right-hand rule.
struct SpaceMouseState {
  Vec3 push = Vec3::Zero();
  Vec3 turn = Vec3::Zero();
  std::uint32_t buttons = 0;  // one bit each, lowest first

  bool is_at_rest() const noexcept { return push.isZero() && turn.isZero(); }
};

// Makes sense of a SpaceMouse's reports: two of three axes, or one of all six, and buttons. The cap is held by springs and not every
// device says so when it is back in the middle: what is less than kDeadBand counts as nothing, and after kStaleNs without a report of an
// axis that axis is at rest. Every byte string is safe. Times: any monotonic clock, ns. RT: yes.
// Source: report descriptor of the SpaceNavigator (046d:c626), captures by spacenavd, VRPN and PySpaceMouse.
class SpaceMouseDecoder {
 public:
  static constexpr double kFullWay = 350.0;  // counts
  static constexpr double kDeadBand = 10.0;  // counts
  // A held cap repeats itself every 16 ms even over the air: some lost reports are not a release.
  static constexpr std::int64_t kStaleNs = 200'000'000;

  // One report, its id in front. False: it says nothing of axes or buttons (battery, LED, unknown), or it is too short.
  bool take(std::span<const std::uint8_t> report, std::int64_t now_ns) noexcept;

  SpaceMouseState state(std::int64_t now_ns) const noexcept;

  // As after unplugging.
  void reset() noexcept { *this = {}; }

 private:
  std::array<double, 6> counts_ = {};  // as the device sends them: x, y, z, turns about these
  std::int64_t pushed_ns_ = 0;
  std::int64_t turned_ns_ = 0;
  std::uint32_t buttons_ = 0;
};

}  // namespace hapton
