// Any bytes from a VRPN client, in pieces whose length the first byte gives.
#include "io_node/vrpn/vrpn_client.h"
#include "tests/fuzz/fuzz_target.h"

FUZZ_TARGET(vrpn) {
  using namespace hapton;
  vrpn::Client client("Phantom0");
  fuzz::feed_in_pieces(bytes, [&](std::span<const std::byte> piece) {
    const bool goes_on = client.receive(piece, {1, 2});
    client.take_workspace_request();
    // A reply is at most eight times as long as its request (two transforms). Our names and one error text come in addition.
    fuzz::require(client.out().size() <= 8 * bytes.size() + 4096);
    fuzz::require(!client.udp_request() || (client.udp_request()->port != 0 && client.udp_request()->address.size() <= 64));
    return goes_on;
  });
}
