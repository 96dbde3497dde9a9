#pragma once

#include <memory>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "link/stream_endpoint.h"
#include "runtime/clock.h"
#include "vrpn/vrpn_wire.h"

namespace hapton::vrpn {

// The bytes of a server's first messages, and of a pose. The functions that encode them are tested against VRPN's bytes.
constexpr std::int32_t kMadeSender = 3, kMadeType = 7;
inline Bytes say_hello(std::string_view device) {
  Bytes bytes;
  append_cookie(bytes);
  append_description(bytes, kSenderDescription, kMadeSender, device, {}, 1);
  append_description(bytes, kTypeDescription, kMadeType, "vrpn_Tracker Pos_Quat", {}, 2);
  return bytes;
}
inline Bytes say_pose(std::int32_t sensor, const Vec3& p_m, const Quat& q = Quat::Identity()) {
  Bytes bytes;
  append_position(bytes, {kMadeSender, kMadeType, {}, 3}, sensor, p_m, q);
  return bytes;
}

// A small VRPN server: greets every client that connects; say() sends bytes to the newest one. It has no thread: call poll().
class MadeTracker final : private StreamEndpoint::Listener {
 public:
  explicit MadeTracker(const std::string& address = "127.0.0.1:0") : streams_(std::move(*StreamEndpoint::open(address, 0))) {}

  Address address() const { return streams_->local_address(); }
  void poll() { streams_->wait(0, *this); }
  void say(const Bytes& bytes) {
    if (id_ != 0) streams_->send(id_, bytes);
  }
  void hang_up() { streams_->close(id_); }
  bool has_client() const { return id_ != 0; }
  int calls() const { return calls_; }           // how many clients have connected so far
  const Bytes& heard() const { return heard_; }  // all bytes from all clients
  void set_hello(Bytes hello) { hello_ = std::move(hello); }

  // Calls poll(), which serves the client, and step(now_ns), until step returns true. False: it did not within 20 s.
  template <class Step>
  bool attend_until(Step&& step) {
    SteadyClock clock;
    const std::int64_t end_ns = clock.now_ns() + 20 * kNanosecondsPerSecond;
    while (clock.now_ns() < end_ns) {
      poll();
      if (step(clock.now_ns())) return true;
      clock.sleep_until_ns(clock.now_ns() + kNanosecondsPerMillisecond);
    }
    return false;
  }

 private:
  void on_connected(StreamEndpoint::Id id, const Address&) override {
    id_ = id;
    ++calls_;
    streams_->send(id, hello_);
  }
  void on_bytes(StreamEndpoint::Id, std::span<const std::byte> bytes) override { heard_.insert(heard_.end(), bytes.begin(), bytes.end()); }
  void on_closed(StreamEndpoint::Id id) override {
    if (id == id_) id_ = 0;
  }
  void on_datagram(const Address&, std::span<const std::byte>) override {}

  std::unique_ptr<StreamEndpoint> streams_;
  StreamEndpoint::Id id_ = 0;
  int calls_ = 0;
  Bytes hello_ = say_hello("Head0");
  Bytes heard_;
};

}  // namespace hapton::vrpn
