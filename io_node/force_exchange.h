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

// Exchanges samples for forces with the haptics node: sends each device sample, posts the newest force to the device side, which governs
// and writes it, and measures how long that took. Frames: world. Units: ns of the hub's clock. RT: yes. Threads: the network side's.
class ForceExchange {
 public:
  // Pre: all outlive this. Measurements go into stats.
  ForceExchange(DeviceLoop& loop, HubPeers& peers, const Clock& clock, ServoStats& stats) noexcept
      : loop_(loop), peers_(peers), clock_(clock), stats_(stats) {}

  void set_hop_meter(HopMeter* hops) noexcept { hops_ = hops; }

  // A cycle of the device side. is_newest false: a newer one is there already, so this sample is never sent.
  void add_cycle(const DeviceCycle& cycle, bool is_newest) noexcept;
  // The newest sample, to the haptics node. While the force is computed on the device side the haptics node needs it only to see where
  // the hand goes, kThinnedHz times a second, and at once when a button is pressed or released.
  void send(const DeviceCycle& cycle) noexcept;
  // The force for the newest sample may still arrive.
  bool is_awaited() const noexcept { return !responses_.has_newest_reply() && peers_.has_haptics(); }
  // Normally the newest force is governed and written to the device before this returns. A force for an older sample than the last one's is
  // counted and dropped.
  void accept(const Header& header, const ForceCommand& command) noexcept;
  // Measures the force that was posted last, once it is on the motors.
  void note_written() noexcept;

  void on_haptics_joined() noexcept;
  void on_haptics_left() noexcept { responses_.excuse_waiting(); }
  // The haptics node continues from the current position of the probe: the next states carry it, as for a node that has just joined. Called
  // while the force is local, it is not requested once more when that ends; otherwise it is, with the first sample that has no local force.
  // Replies to samples before the request are not felt: their probe was elsewhere.
  void request_resume() noexcept {
    history_.note_resume_request();
    is_resume_requested_ = true;
  }
  // It has replied since.
  bool has_resumed() const noexcept { return !history_.is_haptics_new(); }
  bool is_local() const noexcept { return is_local_; }
  // The median of the newest round trips, of 0.6 s, or 1.6 s while the haptics node gets few samples; below 0: too few so far.
  double find_round_trip_s() const noexcept { return find_median_s(kNewestTrips); }
  // As above, of 3.2 s, or of all since the haptics node joined: what lasts for less than half of that does not count.
  double find_lasting_round_trip_s() const noexcept { return find_median_s(kTrips); }
  // From now on the newest round trips count as if they had lasted for 3.2 s: what was before them is over.
  void settle_round_trip() noexcept;
  // view_revision: of the view that forces of the device side are computed with.
  void note_local(const DeviceCycle& cycle, std::uint32_t view_revision) noexcept;

  // The scene was turned.
  void forget_rest() noexcept { history_.forget_rest(); }
  void settle(std::int64_t now_ns) noexcept { responses_.settle(now_ns); }
  // At the end of a run. sample_ns: time of the newest sample.
  void close(std::int64_t sample_ns) noexcept { responses_.close(is_haptics_alive(sample_ns)); }

  const ResponseTracker& responses() const noexcept { return responses_; }
  const ProbeHistory& history() const noexcept { return history_; }
  // The last force came in contact, from a node that is still there.
  bool is_in_contact() const noexcept { return history_.last_reply().contact && peers_.has_haptics(); }

 private:
  struct Posted {
    std::uint64_t number = 0;  // of the device loop's command
    Header header;
    ForceCommand command;
  };

  // The haptics node needs to know only where the hand goes (decision 116).
  static constexpr double kThinnedHz = 20.0;
  // Then a haptics node has little to reply to: five states, so that a waiting one does not take its slot between two of them.
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
  std::optional<Posted> posted_;      // not known to be written yet
  bool is_local_ = false;             // the newest sample's force is the device side's
  bool is_resume_requested_ = false;  // since that began
  bool sends_ = true;                 // the newest sample
  std::int64_t sent_ns_ = 0;          // the newest that was sent
  std::uint32_t sent_buttons_ = 0;    // ... with it

  double find_median_s(std::size_t most) const noexcept;

  // One in 20 ms: 0.6 s for a change back and for advice, 3.2 s for a change to patches (decision 197).
  static constexpr std::size_t kNewestTrips = 32;
  static constexpr std::size_t kTrips = 160;
  std::array<float, kTrips> trips_s_ = {};
  std::size_t trips_ = 0;
  std::int64_t trip_ns_ = 0;
};

}  // namespace hapton
