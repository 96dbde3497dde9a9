#pragma once

#include <array>
#include <cstdint>

#include "devices/device.h"
#include "io_node/device_loop.h"
#include "io_node/echo_probe.h"
#include "io_node/hop_meter.h"
#include "io_node/patch_thread.h"
#include "io_node/response_tracker.h"
#include "io_node/scene_reach.h"
#include "link/hub_peers.h"
#include "link/session_entry.h"
#include "runtime/latency_histogram.h"
#include "safety/safety_governor.h"
#include "safety/safety_limits.h"

namespace hapton {

// A node that has joined, in its slot of the hub; not present: the slot is free.
struct PeerStats {
  bool present = false;
  NodeRole role = NodeRole::tool;
  Address address;
  std::int64_t joined_ns = 0;
  std::uint64_t sent = 0;
  std::uint64_t send_failures = 0;
  SequenceCounts sequence;
};

// All that the device side and the network side have measured since the start; times in ns of the hub's clock. A plain value: share it by
// copy.
struct ServoStats {
  std::int64_t start_ns = 0;  // first tick
  std::int64_t end_ns = 0;    // end of the newest cycle, so that whole cycles lie between the two
  double rate_hz = 0.0;       // requested at present

  LatencyHistogram round_trip;       // sample taken -> matching force ready to write
  LatencyHistogram haptics_compute;  // the part of the round trip that the haptics node spent on the sample
  LatencyHistogram wire;             // the rest of the round trip
  LatencyHistogram force_age;        // sample taken -> its force written to the device
  LatencyHistogram wake_lateness;    // tick of a cycle -> start of the cycle
  LatencyHistogram device_read;      // how long reading the device takes
  LatencyHistogram device_to_drawn;  // sample taken -> a vision node acknowledges the frame that shows it
  LatencyHistogram bare_echo;

  std::uint64_t samples = 0;
  std::uint64_t forces = 0;                           // valid ForceCommands, the first for each sample
  std::uint64_t contact_samples = 0;                  // those forces that were in contact
  std::uint64_t missed_cycles = 0;                    // ticks skipped because the loop came too late for them
  std::uint64_t caught_up_cycles = 0;                 // cycles run late, one after the other, instead of being skipped
  std::array<std::uint64_t, 5> missed_by_cause = {};  // missed and caught-up cycles, by MissCause
  std::uint64_t states_sent = 0;
  std::uint64_t probe_states_sent = 0;
  std::uint64_t probe_states_unchanged = 0;  // due, but not sent, as nothing had changed
  std::uint64_t drawn = 0;                   // frames that vision nodes acknowledged
  std::uint64_t views_forwarded = 0;
  std::uint64_t bad_settings = 0;          // Settings with a servo rate out of range
  std::uint64_t markers = 0;               // recorded
  std::uint64_t markers_rejected = 0;      // sent, but not recorded
  std::uint64_t shape_parts_rejected = 0;  // parts of shapes of objects beyond the limits of RequestHandler
  std::uint64_t moves_rejected = 0;        // requests to move an object beyond RequestHandler::kMovesPerSecond
  std::uint64_t resets_denied = 0;         // requested without the right, or without a person at the device
  double frame_rate_hz = 0.0;              // as last reported by a vision node
  double max_force_n = 0.0;                // written to the device
  double max_torque_nm = 0.0;              // written to the device
  std::int64_t longest_release_ns = 0;     // over all command timeouts: sample of the last accepted force -> zero force on the device
  std::uint64_t cuts = 0;                  // times the device side cut the device, as the network side was stuck in the middle of a write
  std::uint64_t local_forces = 0;          // computed on the device side, from patches of the scene
  PatchThreadCounts patch_thread;
  PatchTouch::Counts patch_touch;
  std::uint64_t cycles_unreported = 0;  // cycles of the device side that the network side was too late to receive

  ResponseTracker::Counts responses;
  GovernorStats governor;
  HubCounts hub;
  SealCounts seal;
  SocketCounts socket;
  std::uint64_t budget_spent = 0;  // times the budget of datagrams was spent before the cycle was over
  EchoProbe::Counts echo;
  std::uint64_t events_dropped = 0;
  HopStats hops;
  std::array<PeerStats, HubPeers::kCapacity> peers = {};
  DeviceStatus device_status = DeviceStatus::ready;
  ProbeStatus status = ProbeStatus::ok;  // as shown in the picture
  double newest_round_trip_s = -1.0;     // median of the newest replies of the haptics node that has joined; below 0: not known
  SceneReach reach = SceneReach::unknown;
  std::int32_t touched_object = -1;    // the object touched now, by its number in the scene; -1: none
  HapticsSetup setup;                  // last reported; its hash is 0 if there was none
  std::uint64_t scene_given_hash = 0;  // SceneFacts::given_hash of the haptics node, last reported; 0: none
  DeviceCondition device;

  double seconds() const { return 1e-9 * static_cast<double>(end_ns - start_ns); }
  // Replies come, but after the time for which a force is used.
  bool are_replies_late() const { return newest_round_trip_s > 1e-9 * static_cast<double>(kCommandTimeoutNs); }
};

// Sets the device side's part of the statistics.
// RT: yes.
void add_device_stats(const DeviceLoopStats& device, ServoStats& stats) noexcept;
// Sets the hub's part: its counters and peers. RT: yes.
void add_peer_stats(const HubPeers& peers, ServoStats& stats) noexcept;

}  // namespace hapton
