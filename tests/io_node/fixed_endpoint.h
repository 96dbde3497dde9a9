#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>

#include "link/codec.h"
#include "link/endpoint.h"
#include "runtime/clock.h"

namespace hapton {

// A haptics, a vision and a tool node in fixed memory: each sample gets a force 50 us later; all other messages are those given to say().
class FixedEndpoint final : public Endpoint {
 public:
  explicit FixedEndpoint(SimulatedClock& clock) : clock_(clock) {}

  bool send(const Address&, std::span<const std::byte> bytes) noexcept override {
    if (codec_.decode(bytes, received_) != DecodeStatus::ok) return true;
    const auto* state = std::get_if<DeviceState>(&received_.message);
    if (state == nullptr) return true;
    ForceCommand force;
    force.echo_sample = state->sample;
    force.echo_sample_time_ns = state->sample_time_ns;
    force.force_n = Vec3(0, 0, 1);
    force.contact = true;
    say(1, force, clock_.now_ns() + 50'000);
    return true;
  }

  Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept override {
    if (bytes_ == 0 || when_ns_ > deadline_ns) {
      clock_.sleep_until_ns(deadline_ns);
      return {};
    }
    clock_.sleep_until_ns(when_ns_);
    std::copy_n(outgoing_.begin(), bytes_, into.begin());
    return {std::exchange(bytes_, 0), Address{{}, from_}};
  }

  void say(std::uint16_t node, const Message& message, std::int64_t when_ns) noexcept {
    sent_.header = {5, 100ULL + node, ++sequence_, when_ns};
    sent_.message = message;
    bytes_ = codec_.encode(sent_, outgoing_);
    when_ns_ = when_ns;
    from_ = node;
  }

  Address local_address() const override { return {{}, 4950}; }

 private:
  SimulatedClock& clock_;
  Codec codec_;
  Datagram received_;
  Datagram sent_;
  std::array<std::byte, kMaxDatagramBytes> outgoing_ = {};
  std::size_t bytes_ = 0;
  std::int64_t when_ns_ = 0;
  std::uint16_t from_ = 0;
  std::uint64_t sequence_ = 0;
};

}  // namespace hapton
