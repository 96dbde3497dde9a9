#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <optional>

#include "io_node/servo_tap.h"
#include "link/haptics_source.h"
#include "link/hub_peers.h"
#include "link/messages.h"
#include "runtime/clock.h"

namespace hapton {

// While the session is recorded, requests from the haptics node those parts of the newest shape of each object deformed by a program that
// were sent before the recording began or were lost on the way, as a vision node does. So a recording has the shapes that hold when it
// begins. Units: ns of the hub's clock. RT: yes. Threads: the network side's.
class ShapeCollector {
 public:
  static constexpr std::int64_t kPartTimeoutNs = 60 * kNanosecondsPerMillisecond;  // before a request: the parts may be on their way
  // Time between two requests, as KnownShapes::kRequestEveryNs.
  static constexpr std::int64_t kRequestEveryNs = 200 * kNanosecondsPerMillisecond;

  // Pre: both outlive this; tap may be null.
  ShapeCollector(HubPeers& peers, const ServoTap* tap) noexcept : peers_(peers), tap_(tap) {}

  void note(const ObjectShape& shape, Arrival arrival) noexcept;
  void note(const ShapeStart& start, Arrival arrival, std::int64_t now_ns) noexcept;
  void request_if_due(std::int64_t now_ns) noexcept;

 private:
  // The newest shape of an object.
  struct NewestShape {
    std::int32_t object = -1;          // -1: none yet
    std::uint32_t serial = 0;          // 0: at rest
    std::uint32_t total = 0;           // vertices
    bool has_begun = false;            // its ShapeStart has come
    std::int64_t next_request_ns = 0;  // time before which nothing is requested
    std::bitset<ShapePart::kMaxParts> received = {};
    bool is_missing() const noexcept { return serial != 0 && has_begun && received.count() < ShapePart::count_parts(total); }
  };
  NewestShape* find_or_begin(std::uint32_t source, std::int32_t object, std::uint32_t serial, std::uint32_t total,
                             Arrival arrival) noexcept;
  ShapeStatus make_request(const NewestShape& newest) const noexcept;

  HubPeers& peers_;
  const ServoTap* tap_;
  HapticsSource processes_;
  std::uint32_t source_ = 0;
  std::array<NewestShape, ShapePart::kMaxObjects> objects_ = {};
};

}  // namespace hapton
