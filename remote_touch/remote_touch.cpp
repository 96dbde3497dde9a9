#include "remote_touch/remote_touch.h"

namespace hapton {

RemoteNetwork RemoteNetwork::of(double round_trip_s, double loss, double jitter_s, std::uint64_t seed) {
  const LinkFaults faults{
      .delay_ns = static_cast<std::int64_t>(0.5e9 * round_trip_s), .jitter_ns = static_cast<std::int64_t>(1e9 * jitter_s), .loss = loss};
  return {.up = faults, .down = faults, .seed = seed};
}

}  // namespace hapton
