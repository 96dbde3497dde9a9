#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "io_node/devices/device.h"
#include "io_node/echo_probe.h"
#include "io_node/event_ring.h"
#include "io_node/report_desk.h"
#include "io_node/safety/safety_governor.h"
#include "io_node/sample_ledger.h"
#include "io_node/servo_stats.h"
#include "io_node/servo_tap.h"
#include "io_node/stranger_news.h"
#include "io_node/vision_pace.h"
#include "io_node/way_meter.h"
#include "link/hub_peers.h"
#include "runtime/adaptive_spin.h"
#include "runtime/clock.h"
#include "runtime/mailbox.h"

namespace hapton {

// The loop that owns the device and is the clock of the whole system. One cycle, begun at each tick of absolute time:
//
//   read the device, send the sample to the haptics node
//   wait on the hub's socket until the next tick; the instant the force for this sample is there: govern it, write it
//   then what is left to do: the probe to the vision nodes, a repeat of the view, figures, halfway a bare echo
//
// A cycle that comes a period or more late follows the overrun policy, and is counted with its cause. The newest force wins: one that
// answers an older sample than the last is counted and dropped. Forces reach the device through the governor only.
// Overruns:
//   skip      whole periods are left out, and the next tick is on time again
//   catch_up  the cycles that were missed run at once, one after the other, up to kMostCaughtUp of them; what is beyond that is skipped
//   stop      a missed cycle ends the session: has_overrun() from then on
// RT: step and finish yes; making one is set-up only. Threads: one, but for ask_for_snapshot, snapshot and events (one other).
enum class OverrunPolicy : std::uint8_t { skip, catch_up, stop };

class Servo {
 public:
  static constexpr double kLowestRateHz = 250.0;
  static constexpr double kHighestRateHz = 10'000.0;
  static constexpr std::int64_t kMostCaughtUp = 10;
  // Later than any work, device or wake-up of a running machine makes a cycle.
  static constexpr std::int64_t kStallNs = 10 * kNanosecondsPerMillisecond;

  struct Options {
    double rate_hz = 1000.0;
    double vision_rate_hz = 240.0;  // ProbeStates a second to each vision node, at most (vision_pace.h); 0: none
    DeviceLimits tighter = {};      // than the device's own limits, field by field; 0: the device's
    int hold_button = -1;           // that must be held for force to be there, lowest bit 0; below 0: none
    OverrunPolicy overrun = OverrunPolicy::skip;
    double spin_share = 0.0;  // of a period, at most, before each tick; 0: sleeps to the tick
  };

  // Pre: all outlive the servo; rates in range. echo and tap may be null.
  Servo(Device& device, HubPeers& peers, const Clock& clock, const Options& options, EchoProbe* echo = nullptr, ServoTap* tap = nullptr);

  // Set up before start: who measures the ways, and who hands out reports. Pre: they outlive the servo.
  void set_way_meter(WayMeter* ways) noexcept { ways_ = ways; }
  void set_report_desk(ReportDesk* desk) noexcept { desk_ = desk; }

  // Sets the first tick one period from now.
  void start() noexcept;
  // One cycle: from this tick, waiting for it if need be, to the next.
  void step() noexcept;
  // Hears the last answers and lets the device go as the governor does in a silence; about 22 ms.
  void finish() noexcept;

  // What was measured so far, as a copy; the servo's thread only.
  const ServoStats& collect_stats() noexcept;
  DeviceStatus device_status() const noexcept { return device_.status(); }
  // A cycle was missed under OverrunPolicy::stop.
  bool has_overrun() const noexcept { return has_overrun_; }
  const DeviceLimits& limits() const noexcept { return governor_.limits(); }
  double rate_hz() const noexcept { return stats_.rate_hz; }

  // The other thread: how much may be spun, and was.
  AdaptiveSpin& spin() noexcept { return spin_; }

  // The other thread: asks for a copy, and takes it when it is there (within a few cycles).
  void ask_for_snapshot() noexcept { snapshot_asked_.store(true, std::memory_order_release); }
  bool take_snapshot() noexcept { return snapshots_.take(); }
  const ServoStats& snapshot() const noexcept { return snapshots_.value(); }
  // A tool wished for a report; true once for each wish.
  bool take_report_wish() noexcept { return report_wished_.exchange(false, std::memory_order_acq_rel); }
  EventRing& events() noexcept { return events_; }

 private:
  void wait_for_tick() noexcept;
  void begin_cycle() noexcept;
  void overrun(std::int64_t late_ns) noexcept;
  MissCause cause_of(std::int64_t late_ns) const noexcept;
  void tell_tap(std::int64_t now_ns) noexcept;
  void tell_of_safety(std::int64_t now_ns) noexcept;
  void tell_fault(SessionFault fault, bool is_there, std::int64_t now_ns) noexcept;
  void sample_device() noexcept;
  void receive_until(std::int64_t deadline_ns) noexcept;
  void drain() noexcept;
  void await_force(std::int64_t deadline_ns) noexcept;
  void note_waited(std::int64_t deadline_ns, std::int64_t woke_ns) noexcept;
  void receive_one(std::int64_t deadline_ns) noexcept;
  void hear(const PeerEvent& event, const Datagram& datagram) noexcept;
  void hear_message(const PeerEvent& event, const Datagram& datagram) noexcept;
  void on_force(const ForceCommand& command) noexcept;
  void remember_probe(const ForceCommand& command) noexcept;
  void on_view(const ViewTransform& view) noexcept;
  void on_drawn(const Drawn& drawn, std::size_t peer) noexcept;
  void on_hand(const HandTarget& hand, std::size_t peer) noexcept;
  void on_settings(const Settings& settings, const PeerEvent& event) noexcept;
  void reset_faults(const Peer& asker) noexcept;
  void on_joined(const PeerEvent& event) noexcept;
  void on_left(const PeerEvent& event) noexcept;
  void hold_force() noexcept;
  void write(const Wrench& wrench) noexcept;
  void do_spare_work() noexcept;
  void fill_probe() noexcept;
  bool is_pose_known(std::uint64_t sample) const noexcept;
  void tell_vision(std::int64_t now_ns) noexcept;
  void refresh_figures(std::int64_t now_ns) noexcept;
  void tell_of_strangers(std::int64_t now_ns) noexcept;
  bool haptics_alive(std::int64_t now_ns) const noexcept;
  void tell(ServoEvent::Kind kind, NodeRole role, const Address& address) noexcept;
  std::int64_t period_ns() const noexcept;

  static constexpr std::size_t kNobody = HubPeers::kCapacity;

  Device& device_;
  HubPeers& peers_;
  const Clock& clock_;
  EchoProbe* echo_;
  WayMeter* ways_ = nullptr;
  ReportDesk* desk_ = nullptr;
  ServoTap* tap_;
  OverrunPolicy policy_;
  SafetyGovernor governor_;
  SampleLedger ledger_;
  ServoStats stats_;
  VisionPace pace_;

  std::int64_t tick_ns_ = 0;
  AdaptiveSpin spin_;
  std::int64_t device_ns_ = 0;     // spent on the device since the last tick
  std::int64_t overslept_ns_ = 0;  // by the wait since then that ended latest
  bool is_behind_ = false;         // the loop came to wait for this tick when it had passed
  bool has_overrun_ = false;
  CycleNote cycle_;
  GovernorCounters governor_told_;
  DeviceStatus status_told_ = DeviceStatus::ready;
  std::int64_t status_since_ns_ = 0;  // the newest cycle with that status
  std::uint32_t faults_ = 0;          // of the newest cycle, a bit each
  std::int64_t next_view_repeat_ns_ = 0;
  std::int64_t next_figures_ns_ = 0;
  StrangerNews strangers_;
  std::int64_t next_denial_ns_ = 0;
  std::int64_t figures_since_ns_ = 0;
  std::uint64_t figures_samples_ = 0;

  DeviceSample sample_;
  std::uint64_t sample_number_ = 0;
  Wrench written_;
  bool is_force_new_ = false;  // since the last tick
  bool is_finished_ = false;
  std::int64_t accepted_ns_ = 0;  // the last force that the governor let pass
  struct Pose {
    std::int64_t time_ns = 0;
    Vec3 p_WD = Vec3::Zero();
    Quat q_WT = Quat::Identity();
  };
  std::array<Pose, 256> poses_ = {};  // of the newest samples, by number
  std::optional<Vec3> p_WP_;          // where the probe rests, in contact, as far as known
  bool is_haptics_new_ = false;       // it has not answered yet
  ForceCommand last_force_;
  std::optional<ViewTransform> view_;
  std::size_t hand_leader_ = kNobody;
  ProbeState probe_;
  Datagram incoming_;

  EventRing events_;
  Mailbox<ServoStats> snapshots_;
  std::atomic<bool> snapshot_asked_{false};
  std::atomic<bool> report_wished_{false};
};

}  // namespace hapton
