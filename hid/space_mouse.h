#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/math/types.h"

namespace hapton {

// How far the cap of a SpaceMouse is pushed and turned, as shares of its full travel: -1 .. 1 each.
// Frame: that of the person, with the axes of W: x right, y up, z towards the person; turns about these axes by the right-hand rule.
struct SpaceMouseState {
  Vec3 push = Vec3::Zero();
  Vec3 turn = Vec3::Zero();
  std::uint32_t buttons = 0;  // one bit for each button, from the lowest bit

  bool is_at_rest() const noexcept { return push.isZero() && turn.isZero(); }
};

// Decodes a SpaceMouse's reports: two with three axes each, or one with all six, and one with the buttons. Springs hold the cap, and not
// every device reports when the cap is back in the middle: a displacement of at most kDeadBand counts as zero, and an axis without a report
// for kStaleNs counts as at rest. Any bytes are safe as input. Times: any monotonic clock, ns. RT: yes. Threads: one.
// Source: report descriptor of the SpaceNavigator (046d:c626), captures by spacenavd, VRPN and PySpaceMouse.
class SpaceMouseDecoder {
 public:
  static constexpr double kFullDeflection = 350.0;  // counts
  static constexpr double kDeadBand = 10.0;         // counts
  // While the cap is held, a report comes every 16 ms, by radio as well: a few lost reports do not count as a release.
  static constexpr std::int64_t kStaleNs = 200'000'000;

  // Takes one report, with its id as first byte. False: it has no axes or buttons (battery, LED, unknown), or it is too short.
  bool take(std::span<const std::uint8_t> report, std::int64_t now_ns) noexcept;

  SpaceMouseState state(std::int64_t now_ns) const noexcept;

  // Forgets all reports, for use after the device was unplugged.
  void reset() noexcept { *this = {}; }

 private:
  std::array<double, 6> counts_ = {};  // as the device sends them: x, y, z, then turns about these axes
  std::int64_t pushed_ns_ = 0;
  std::int64_t turned_ns_ = 0;
  std::uint32_t buttons_ = 0;
};

}  // namespace hapton
