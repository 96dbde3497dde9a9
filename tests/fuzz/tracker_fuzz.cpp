// Any bytes from a VRPN server to the client of its tracker, in pieces whose length the first byte gives.
#include <cmath>

#include "tests/fuzz/fuzz_target.h"
#include "vrpn/tracker_client.h"

FUZZ_TARGET(tracker) {
  using namespace hapton;
  vrpn::TrackerClient client("Head0", 0);
  fuzz::feed_in_pieces(bytes, [&](std::span<const std::byte> piece) {
    const bool goes_on = client.receive(piece);
    const auto pose = client.take_newest();
    fuzz::require(!pose || (pose->p_m.allFinite() && std::abs(pose->q.norm() - 1.0) < 1e-9));
    // The client sends its cookie, the name of its tracker and the name of one message type, and no replies.
    fuzz::require(client.out().size() <= 256);
    fuzz::require(client.describe_devices().size() <= 8 * 102);
    return goes_on;
  });
}
