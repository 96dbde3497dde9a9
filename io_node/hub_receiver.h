#pragma once

#include <cstdint>

#include "io_node/device_loop.h"
#include "link/hub_peers.h"
#include "runtime/clock.h"

namespace hapton {

// Handles the events of the hub's peers. RT: yes.
class PeerEventHandler {
 public:
  // datagram: valid only for PeerEvent::Kind::message.
  virtual void handle(const PeerEvent& event, const Datagram& datagram) noexcept = 0;

 protected:
  ~PeerEventHandler() = default;
};

// Waits on the hub's socket for the network side and hands over each event as it arrives.
// Units: ns of the hub's clock. RT: yes. Threads: the network side's.
class HubReceiver {
 public:
  // Pre: all outlive this; handler may be under construction.
  HubReceiver(HubPeers& peers, const Clock& clock, PeerEventHandler& handler) noexcept : peers_(peers), clock_(clock), handler_(handler) {}

  // The device loop whose cycles run in this thread: it is notified how late a wait ended. Null: the device loop has a thread of its own.
  void set_device_loop(DeviceLoop* loop) noexcept { loop_ = loop; }

  // Receives until the deadline.
  void receive_until(std::int64_t deadline_ns) noexcept;

  // Receives until the deadline, or until is_needed() is false.
  template <class IsNeeded>
  void receive_while(IsNeeded&& is_needed, std::int64_t deadline_ns) noexcept {
    while (is_needed()) {
      const std::int64_t now_ns = clock_.now_ns();
      if (now_ns >= deadline_ns) return note_waited(deadline_ns, now_ns);
      receive_one(deadline_ns);
    }
  }

  // Does the same without a sleep; the device loop is not notified.
  template <class IsNeeded>
  void spin_while(IsNeeded&& is_needed, std::int64_t deadline_ns) noexcept {
    while (is_needed() && clock_.now_ns() < deadline_ns) receive_one(0);
  }

  // Handles what has already arrived; at most kMaxDrained datagrams, so that a flood cannot delay the loop for long.
  void drain() noexcept;

  // A wait that was to end at deadline_ns ended at woke_ns.
  void note_waited(std::int64_t deadline_ns, std::int64_t woke_ns) noexcept {
    if (loop_ != nullptr) loop_->note_overslept(woke_ns - deadline_ns);
  }

 private:
  // 1 us each, and twice what 16 nodes send in a millisecond (CycleSource::kDatagramsPerMs).
  static constexpr int kMaxDrained = 32;

  void receive_one(std::int64_t deadline_ns) noexcept;

  HubPeers& peers_;
  const Clock& clock_;
  PeerEventHandler& handler_;
  DeviceLoop* loop_ = nullptr;
  Datagram incoming_;
};

}  // namespace hapton
