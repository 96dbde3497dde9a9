// Any bytes from a VRPN server to the client of its tracker, in pieces whose length the first byte gives.
#include <algorithm>
#include <cmath>

#include "tests/fuzz/fuzz_target.h"
#include "vrpn/tracker_client.h"

FUZZ_TARGET(tracker) {
  using namespace hapton;
  vrpn::TrackerClient client("Head0", 0);
  if (bytes.empty()) return;
  const std::size_t piece = std::size_t{bytes[0]} + 1;
  std::span<const std::uint8_t> rest = bytes.subspan(1);
  bool goes_on = true;
  while (goes_on && !rest.empty()) {
    const auto now = rest.first(std::min(piece, rest.size()));
    rest = rest.subspan(now.size());
    goes_on = client.receive(std::as_bytes(now));
    const auto pose = client.take_newest();
    fuzz::require(!pose || (pose->p_m.allFinite() && std::abs(pose->q.norm() - 1.0) < 1e-9));
    // It says its cookie, its name for the tracker and one of a type, and nothing in reply.
    fuzz::require(client.out().size() <= 256);
    fuzz::require(client.describe_devices().size() <= 8 * 102);
  }
}
