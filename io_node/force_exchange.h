#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "io_node/device_loop.h"
#include "io_node/hop_meter.h"
#include "io_node/probe_history.h"
#include "io_node/response_tracker.h"
#include "io_node/servo_stats.h"
#include "link/hub_peers.h"
#include "link/messages.h"

namespace hapton {

// Exchanges samples for forces with the haptics node: sends it the samples, and posts the newest force to the device side, which governs it
// and writes it to the motors. This class measures how long that took. Frames: world. Units: ns of the hub's clock. RT: yes. Threads: the
// network side's.
class ForceExchange {
 public:
  // Pre: all outlive this. Measurements go into stats.
  ForceExchange(DeviceLoop& loop, HubPeers& peers, const Clock& clock, ServoStats& stats) noexcept
      : loop_(loop), peers_(peers), clock_(clock), stats_(stats) {}

  void set_hop_meter(HopMeter* hops) noexcept { hops_ = hops; }

  // Notes a cycle of the device side. is_newest false: a newer cycle has been read already, so this sample is never sent.
  void add_cycle(const DeviceCycle& cycle, bool is_newest) noexcept;
  // Sends the newest sample to the haptics node. While the force is computed on the device side, that node needs samples only to follow the
  // hand. It then gets kThinnedHz a second, one at once when a button is pressed or released, and all of them until it has resumed
  // (request_resume).
  void send(const DeviceCycle& cycle) noexcept;
  // The force for the newest sample may still arrive.
  bool is_awaited() const noexcept { return !responses_.has_newest_reply() && peers_.has_haptics(); }
  // Takes a force that has arrived. Normally it is governed and written to the device before this returns. A force for an older sample than
  // that of the last force is only measured and counted, as is any force while the device side computes its own.
  void accept(const Header& header, const ForceCommand& command) noexcept;
  // Measures the force that was posted last, once it is on the motors.
  void note_written() noexcept;

  void on_haptics_joined() noexcept;
  void on_haptics_left() noexcept { responses_.excuse_waiting(); }
  // The haptics node is to resume from the current position of the probe: the next DeviceState messages contain that position, as for a
  // node that has just joined. When the force stops being local, this is called with the first sample without a local force, unless it was
  // called already while the force was local. Replies to samples before the request are not felt: they were computed for a probe elsewhere.
  void request_resume() noexcept {
    history_.note_resume_request();
    is_resume_requested_ = true;
  }
  // The haptics node has replied since the last request to resume, or since it joined.
  bool has_resumed() const noexcept { return !history_.is_haptics_new(); }
  bool is_local() const noexcept { return is_local_; }
  // Median, s, of the round trips in the last 0.6 s, or in the last 1.6 s while the haptics node gets few samples. Below 0: there are too
  // few so far.
  double find_round_trip_s() const noexcept { return find_median_s(kNewestTrips); }
  // The same over 3.2 s (8 s while samples are few), or since the haptics node joined: a change shorter than half of that has no effect.
  double find_lasting_round_trip_s() const noexcept { return find_median_s(kTrips); }
  // From now on the median of the newest round trips counts as if it had lasted for 3.2 s: older ones are forgotten.
  void settle_round_trip() noexcept;
  // Notes the force that the device side computed in this cycle, if any. view_revision: of the view transform that it was computed with.
  void note_local(const DeviceCycle& cycle, std::uint32_t view_revision) noexcept;

  // The scene was turned: the last position of the probe is no longer valid.
  void forget_probe_position() noexcept { history_.forget_probe_position(); }
  // To be called periodically: declares samples lost that have had no reply for too long after a later one had.
  void settle(std::int64_t now_ns) noexcept { responses_.settle(now_ns); }
  // Settles the samples without a reply at the end of a run. sample_ns: time of the newest sample.
  void close(std::int64_t sample_ns) noexcept { responses_.close(is_haptics_alive(sample_ns)); }

  const ResponseTracker& responses() const noexcept { return responses_; }
  const ProbeHistory& history() const noexcept { return history_; }
  // The last force was one in contact, and a haptics node is joined.
  bool is_in_contact() const noexcept { return history_.last_reply().contact && peers_.has_haptics(); }

 private:
  struct Posted {
    std::uint64_t number = 0;  // DeviceLoop's number of this command
    Header header;
    ForceCommand command;
  };

  // Samples a second while the force is local: the haptics node needs to know only where the hand goes (decision 116).
  static constexpr double kThinnedHz = 20.0;
  // Timeout of the haptics node meanwhile: five samples, so that a second haptics node, which waits for the slot of the first in HubPeers,
  // does not get that slot between two samples.
  static constexpr std::int64_t kThinnedTimeoutNs = 5 * static_cast<std::int64_t>(1e9 / kThinnedHz);

  bool is_thinned(const DeviceCycle& cycle) const noexcept;
  void note_source(bool is_local) noexcept;
  void note_trip(std::int64_t round_trip_ns, std::int64_t now_ns) noexcept;
  bool is_haptics_alive(std::int64_t now_ns) const noexcept;
  void note_round_trip(const Header& header, const ForceCommand& command, std::int64_t ready_ns) noexcept;

  DeviceLoop& loop_;
  HubPeers& peers_;
  const Clock& clock_;
  ServoStats& stats_;
  HopMeter* hops_ = nullptr;
  ResponseTracker responses_;
  ProbeHistory history_;
  std::optional<Posted> posted_;      // the last force posted, until it is known to be written
  bool is_local_ = false;             // the device side computed the force of the newest sample
  bool is_resume_requested_ = false;  // since is_local_ became true
  bool sends_newest_ = true;          // the newest sample is sent
  std::int64_t sent_ns_ = 0;          // time of the newest sample that was sent
  std::uint32_t sent_buttons_ = 0;    // ... and its buttons

  double find_median_s(std::size_t max_trips) const noexcept;

  // One round trip in kTripEveryNs is kept: 0.6 s of them tell the user how late replies are, and decide on the change back to remote
  // forces; 3.2 s of them decide on the change to patches (decision 197).
  static constexpr std::int64_t kTripEveryNs = 20 * kNanosecondsPerMillisecond;
  static constexpr std::size_t kNewestTrips = 32;
  static constexpr std::size_t kTrips = 160;
  std::array<float, kTrips> trips_s_ = {};
  std::size_t trip_count_ = 0;
  std::int64_t last_trip_ns_ = 0;
};

}  // namespace hapton
