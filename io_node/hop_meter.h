#pragma once

#include <array>
#include <cstdint>

#include "link/clock_offset.h"
#include "link/hub_peers.h"
#include "link/messages.h"
#include "link/metered_endpoint.h"
#include "runtime/latency_histogram.h"

namespace hapton {

// Latencies between the nodes, hop by hop. Those of one sample add up to its round trip: encode + wire_out + haptics_compute + wire_back +
// decode.
struct HopStats {
  LatencyHistogram encode;            // sample taken -> encoded, sealed and about to be handed to the system
  LatencyHistogram wire_out;          // -> the haptics node has read it
  LatencyHistogram wire_back;         // its reply is ready to be encoded -> taken from the system
  LatencyHistogram decode;            // -> opened, decoded and governed
  LatencyHistogram device_write;      // -> written to the device
  LatencyHistogram jitter;            // difference between a round trip and the one before
  LatencyHistogram vision_draw;       // a vision node has read a state -> it has drawn it
  LatencyHistogram motion_to_photon;  // sample taken -> the frame that shows it is drawn
  MeteredEndpoint::Counts link;

  // The haptics node's clock minus ours, with its error bound. On one host there is one clock, and the offset is zero.
  bool is_offset_known = false;
  bool is_one_clock = false;
  std::int64_t clock_offset_ns = 0;
  std::int64_t clock_error_ns = 0;
};

// Measures HopStats from the times in the datagrams and those of the endpoint. One-way times between hosts
// use ClockOffset and have its error bound; on one host they are exact. RT: yes. Threads: the network
// side's.
class HopMeter {
 public:
  // Pre: the endpoint, the one that carries the hub's datagrams, outlives this.
  explicit HopMeter(const MeteredEndpoint& endpoint) : endpoint_(endpoint) {}

  // A node has joined in this slot.
  void on_joined(std::size_t slot, const Address& address) noexcept;
  // A sample has been sent: to the haptics node (on_state_sent), or in a probe state to the vision nodes (on_probe_sent).
  void on_state_sent(std::uint64_t sample, std::int64_t sample_time_ns) noexcept;
  void on_probe_sent(std::uint64_t sample) noexcept;
  // A force is ready to be written.
  void on_force(const Header& header, const ForceCommand& command, std::int64_t ready_ns) noexcept;
  void on_force_written(std::int64_t ready_ns, std::int64_t now_ns) noexcept { stats_.device_write.record(now_ns - ready_ns); }
  // The vision node in this slot has drawn a frame.
  void on_frame_ack(const Header& header, const FrameAck& frame, std::size_t slot) noexcept;

  // The statistics, up to date as of now_ns.
  const HopStats& collect(std::int64_t now_ns) noexcept;

 private:
  static constexpr std::size_t kStatesKept = 1024;  // by sample number; wire times of replies to older samples are not measured
  static constexpr std::size_t kProbesKept = 256;   // in order of time: a second of them at the default of 240 Hz

  struct SentSample {
    std::uint64_t sample = 0;  // 0: none
    std::int64_t time_ns = 0;
  };

  std::int64_t offset_ns(std::size_t slot) const noexcept { return is_one_clock_[slot] ? 0 : offsets_[slot].offset_ns(); }
  bool is_offset_known(std::size_t slot) const noexcept { return is_one_clock_[slot] || offsets_[slot].is_known(); }

  const MeteredEndpoint& endpoint_;
  HopStats stats_;
  std::array<ClockOffset, HubPeers::kCapacity> offsets_ = {};
  std::array<bool, HubPeers::kCapacity> is_one_clock_ = {};
  std::array<SentSample, kStatesKept> states_ = {};
  std::array<SentSample, kProbesKept> probes_ = {};
  std::size_t next_probe_ = 0;
  std::int64_t last_round_trip_ns_ = -1;
};

}  // namespace hapton
