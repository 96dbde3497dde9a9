// An attacker who holds the keys, and so can make valid tags, sends handshake messages to a hub and to a node that has requested a session.
// In all cases nothing is handed out, because nothing was sent; every datagram is counted once or replied to (a request may be a repeat); a
// node gets no more bytes in replies than it sent; and a datagram without a valid tag gets no reply.
#include <map>

#include "tests/fuzz/fixed_random.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/handshake_line.h"

namespace hapton::fuzz {
namespace {

// byte_balance: for each node, the bytes that it sent less those of the replies.
void deliver_to_hub(HandshakeLine& line, const ListedDatagram& datagram, std::map<std::uint8_t, std::ptrdiff_t>& byte_balance) {
  const std::uint64_t rejected = line.hub().seal_counts().rejected();
  const std::uint64_t repeats = line.hub().seal_counts().repeats;
  const std::size_t sent = line.from_hub().size();
  require(line.deliver(datagram) == 0);
  if (line.hub().seal_counts().repeats != repeats) {
    require(has_tag(datagram.bytes, datagram.role()) && line.from_hub().size() == sent);
    return;
  }
  const bool is_rejected = line.hub().seal_counts().rejected() == rejected + 1;
  const bool has_reply = line.from_hub().size() == sent + 1;
  require(is_rejected != has_reply);
  byte_balance[datagram.node()] += static_cast<std::ptrdiff_t>(datagram.bytes.size());
  if (!has_reply) return;
  const OneDatagramEndpoint::Sent& reply = line.from_hub().back();
  require(has_tag(datagram.bytes, datagram.role()) && find_handshake_kind(datagram.bytes) == seal::Kind::request);
  require(reply.to == address_of_node(datagram.node()));
  byte_balance[datagram.node()] -= static_cast<std::ptrdiff_t>(reply.bytes.size());
  require(byte_balance[datagram.node()] >= 0);
}

void deliver_to_node(HandshakeLine& line, const ListedDatagram& datagram) {
  const std::uint64_t handshakes = line.node().seal_counts().handshakes;
  require(line.deliver(datagram) == 0);
  if (line.node().seal_counts().handshakes == handshakes) return;
  require(find_handshake_kind(datagram.bytes) == seal::Kind::reply && has_tag(datagram.bytes, KeyRole::haptics));
}

}  // namespace
}  // namespace hapton::fuzz

FUZZ_TARGET(request) {
  using namespace hapton;
  fuzz::require(fuzz::FixedRandom::install());
  fuzz::HandshakeLine line;
  std::map<std::uint8_t, std::ptrdiff_t> byte_balance;
  bool all_tagged = true;
  const auto datagrams = fuzz::split_datagrams(bytes);
  for (const fuzz::ListedDatagram& datagram : datagrams) {
    if (datagram.bytes.empty() || datagram.bytes.size() > kMaxDatagramBytes) {
      all_tagged = false;
      continue;
    }
    all_tagged = fuzz::has_tag(datagram.bytes, KeyRole::haptics) && all_tagged;
    datagram.is_to_node() ? fuzz::deliver_to_node(line, datagram) : fuzz::deliver_to_hub(line, datagram, byte_balance);
  }
  if (all_tagged && !datagrams.empty()) fuzz::note_passage();
}

FUZZ_MUTATOR(request, hapton::fuzz::mutate_handshakes);
FUZZ_CROSSOVER(request, hapton::fuzz::cross_handshakes);
