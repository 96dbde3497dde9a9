// Any bytes from a VRPN client, in pieces whose length the first byte gives.
#include <algorithm>

#include "io_node/vrpn/vrpn_client.h"
#include "tests/fuzz/fuzz_target.h"

FUZZ_TARGET(vrpn) {
  using namespace hapton;
  vrpn::Client client("Phantom0");
  if (bytes.empty()) return;
  const std::size_t piece = std::size_t{bytes[0]} + 1;
  std::span<const std::uint8_t> rest = bytes.subspan(1);
  bool goes_on = true;
  while (goes_on && !rest.empty()) {
    const auto now = rest.first(std::min(piece, rest.size()));
    rest = rest.subspan(now.size());
    goes_on = client.receive(std::as_bytes(now), {1, 2});
    client.take_workspace_request();
    // A reply is at most eight times as long as its request (two transforms), beside our names and one text of an error.
    fuzz::require(client.out().size() <= 8 * bytes.size() + 4096);
    fuzz::require(!client.udp_request() || (client.udp_request()->port != 0 && client.udp_request()->address.size() <= 64));
  }
}
