#include "io_node/echo_probe.h"

#include <algorithm>
#include <cstring>

#include "link/bare_echo_endpoint.h"
#include "link/codec.h"
#include "link/seal_format.h"

namespace hapton {
namespace {

// The size of a sealed DeviceState on the wire, with counters as they are after a minute.
std::size_t device_state_bytes() {
  std::array<std::byte, kMaxDatagramBytes> bytes;
  Datagram datagram;
  datagram.header = {~0ULL, ~0ULL, 60'000, 60'000'000'000'000};
  datagram.message = DeviceState{60'000, 60'000'000'000'000, Vec3(0.1, 0.1, 0.1), Quat(0.5, 0.5, 0.5, 0.5), 1};
  return Codec().encode(datagram, bytes) + seal::kOverheadBytes;
}

}  // namespace

EchoProbe::EchoProbe(Endpoint& endpoint, const Clock& clock, const Address& responder, std::size_t bytes)
    : endpoint_(endpoint),
      clock_(clock),
      responder_(responder),
      bytes_(bytes == 0 ? device_state_bytes() : std::max(bytes, kEchoMarkBytes + sizeof sequence_)) {
  std::memcpy(out_.data(), kEchoRequest.data(), kEchoMarkBytes);
}

void EchoProbe::probe(std::int64_t deadline_ns) noexcept {
  ++sequence_;
  std::memcpy(out_.data() + kEchoMarkBytes, &sequence_, sizeof sequence_);
  const std::int64_t sent_ns = clock_.now_ns();
  if (!endpoint_.send(responder_, std::span(out_).first(bytes_))) return;
  ++counts_.sent;
  for (std::int64_t now_ns = sent_ns; now_ns < deadline_ns; now_ns = clock_.now_ns()) {
    const Received received = endpoint_.receive(in_, deadline_ns);
    if (received.bytes == 0) continue;
    std::uint64_t echoed = 0;
    std::memcpy(&echoed, in_.data() + kEchoMarkBytes, sizeof echoed);
    const bool is_reply = std::memcmp(in_.data(), kEchoReply.data(), kEchoMarkBytes) == 0;
    const bool is_ours = received.from == responder_ && received.bytes == bytes_ && is_reply && echoed != 0 && echoed <= sequence_;
    if (is_ours && echoed == sequence_) {
      round_trip_.record(clock_.now_ns() - sent_ns);
      ++counts_.replied;
      return;
    }
    ++(is_ours ? counts_.late : counts_.foreign);
  }
}

}  // namespace hapton
