#include "io_node/hub_receiver.h"

namespace hapton {

void HubReceiver::receive_one(std::int64_t deadline_ns) noexcept {
  const PeerEvent event = peers_.receive(incoming_, deadline_ns);
  if (event.kind != PeerEvent::Kind::none) handler_.handle(event, incoming_);
}

void HubReceiver::receive_until(std::int64_t deadline_ns) noexcept {
  std::int64_t now_ns = clock_.now_ns();
  if (now_ns >= deadline_ns) return;
  for (; now_ns < deadline_ns; now_ns = clock_.now_ns()) receive_one(deadline_ns);
  note_waited(deadline_ns, now_ns);
}

void HubReceiver::drain() noexcept {
  for (int count = 0; count < kMaxDrained; ++count) {
    const std::uint64_t before = peers_.counts().received;
    receive_one(0);
    if (peers_.counts().received == before) return;
  }
}

}  // namespace hapton
