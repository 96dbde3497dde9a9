#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "devices/device.h"
#include "io_node/device_loop.h"
#include "io_node/echo_probe.h"
#include "io_node/event_ring.h"
#include "io_node/probe_memory.h"
#include "io_node/report_desk.h"
#include "io_node/safety_news.h"
#include "io_node/sample_ledger.h"
#include "io_node/scene_reach.h"
#include "io_node/servo_stats.h"
#include "io_node/servo_tap.h"
#include "io_node/stranger_news.h"
#include "io_node/vision_feed.h"
#include "io_node/way_meter.h"
#include "link/budgeted_endpoint.h"
#include "link/hub_peers.h"
#include "runtime/clock.h"
#include "runtime/mailbox.h"

namespace hapton {

// The network side of io_node: it exchanges datagrams with the other nodes, and is slaved to the device side (DeviceLoop), from which it
// has the samples and to which it posts the forces. One cycle of it, for each of the device's:
//
//   the sample goes to the haptics node
//   wait on the hub's socket; the instant the force for this sample is there it is posted: governed and written
//   then what is left to do: the probe to the vision nodes, a repeat of the view, figures, halfway a bare echo
//
// The newest force wins: one that answers an older sample than the last is counted and dropped. However long this side takes, the device
// side goes on and lets the force go in time. Where the device side has no thread of its own (tests on simulated time), step runs its
// cycles as well: from one tick to the next. RT: step and finish yes; making one is set-up only. Threads: one, but for ask_for_snapshot,
// snapshot and events (one other), and for device_loop, see there.
class Servo {
 public:
  static constexpr double kLowestRateHz = 250.0;
  static constexpr double kHighestRateHz = 10'000.0;
  // How long a cycle of the device side is waited for, spinning: it is due, and made on another CPU or displaces this thread.
  static constexpr std::int64_t kLongestSpinNs = 50'000;
  // Datagrams looked at in a millisecond, at most: 1 us each, so that three tenths of the time go on them; twenty times what 16 nodes send.
  static constexpr std::int64_t kDatagramsPerMs = 300;

  struct Options {
    double rate_hz = 1000.0;
    double vision_rate_hz = 240.0;  // ProbeStates a second to each vision node, at most (vision_pace.h); 0: none
    DeviceLimits tighter = {};      // than the device's own limits, field by field; 0: the device's
    bool forbids_force = false;     // the device moves and is seen, and never gets a force
    int hold_button = -1;           // that must be held for force to be there, lowest bit 0; below 0: none
    OverrunPolicy overrun = OverrunPolicy::skip;
    double spin_share = 0.0;  // of a period, at most, before each tick; 0: sleeps to the tick
  };

  // Pre: all outlive the servo; rates in range. echo and tap may be null.
  Servo(Device& device, HubPeers& peers, const Clock& clock, const Options& options, EchoProbe* echo = nullptr, ServoTap* tap = nullptr);

  // Set up before start: who measures the ways, and who hands out reports. Pre: they outlive the servo.
  void set_way_meter(WayMeter* ways) noexcept {
    ways_ = ways;
    vision_.set_way_meter(ways);
  }
  void set_report_desk(ReportDesk* desk) noexcept { desk_ = desk; }
  // ... what bounds the datagrams of a cycle.
  void set_budget(BudgetedEndpoint* budget) noexcept { budget_ = budget; }
  // ... and that the device side has a thread of its own.
  void use_device_thread() noexcept { has_device_thread_ = true; }
  DeviceLoop& device_loop() noexcept { return loop_; }

  // The device side starts its clock first.
  void start() noexcept;
  // One cycle: from this tick, waiting for it if need be, to the next.
  void step() noexcept;
  // Hears the last answers and lets the device go as the governor does in a silence; about 22 ms.
  void finish() noexcept;

  // What was measured so far, as a copy; the servo's thread only.
  const ServoStats& collect_stats() noexcept;
  DeviceStatus device_status() const noexcept { return loop_.status(); }
  // A cycle was missed under OverrunPolicy::stop.
  bool has_overrun() const noexcept { return loop_.has_overrun(); }
  const DeviceLimits& limits() const noexcept { return loop_.limits(); }
  double rate_hz() const noexcept { return rate_hz_; }

  // The other thread: how much may be spun, and was.
  AdaptiveSpin& spin() noexcept { return loop_.spin(); }

  // The other thread: asks for a copy, and takes it when it is there (within a few cycles).
  void ask_for_snapshot() noexcept { snapshot_asked_.store(true, std::memory_order_release); }
  bool take_snapshot() noexcept { return snapshots_.take(); }
  const ServoStats& snapshot() const noexcept { return snapshots_.value(); }
  // A tool wished for a report; true once for each wish.
  bool take_report_wish() noexcept { return report_wished_.exchange(false, std::memory_order_acq_rel); }
  EventRing& events() noexcept { return events_; }

 private:
  void renew_budget() noexcept;
  void run_device_cycle() noexcept;
  bool await_cycle() noexcept;
  void take_cycles() noexcept;
  void on_cycle(bool is_newest) noexcept;
  void send_state() noexcept;
  void receive_until(std::int64_t deadline_ns) noexcept;
  void drain() noexcept;
  void await_force(std::int64_t deadline_ns) noexcept;
  void note_waited(std::int64_t deadline_ns, std::int64_t woke_ns) noexcept;
  void receive_one(std::int64_t deadline_ns) noexcept;
  void hear(const PeerEvent& event, const Datagram& datagram) noexcept;
  void hear_message(const PeerEvent& event, const Datagram& datagram) noexcept;
  void on_force(const ForceCommand& command) noexcept;
  void note_written() noexcept;
  void note_round_trip(const ForceCommand& command, std::int64_t ready_ns) noexcept;
  void hand_out_snapshot() noexcept;
  const ServoStats& fill_stats(const DeviceLoopStats& device) noexcept;
  void on_view(const ViewTransform& view) noexcept;
  void on_setup(const HapticsSetup& setup) noexcept;
  void on_scene(const SceneFacts& scene, NodeRole role) noexcept;
  void place_scene() noexcept;
  ProbeStatus status_now() noexcept;
  void on_hand(const HandTarget& hand, std::size_t peer) noexcept;
  void on_settings(const Settings& settings, const PeerEvent& event) noexcept;
  void reset_faults(const Peer& asker) noexcept;
  void on_joined(const PeerEvent& event) noexcept;
  void on_left(const PeerEvent& event) noexcept;
  void do_spare_work() noexcept;
  void tell_of_strangers(std::int64_t now_ns) noexcept;
  bool haptics_alive(std::int64_t now_ns) const noexcept;
  void tell(ServoEvent::Kind kind, NodeRole role, const Address& address) noexcept;
  std::int64_t period_ns() const noexcept;

  static constexpr std::size_t kNobody = HubPeers::kCapacity;

  DeviceLoop loop_;
  HubPeers& peers_;
  const Clock& clock_;
  EchoProbe* echo_;
  WayMeter* ways_ = nullptr;
  ReportDesk* desk_ = nullptr;
  BudgetedEndpoint* budget_ = nullptr;
  ServoTap* tap_;
  EventRing events_;
  SampleLedger ledger_;
  ServoStats stats_;
  VisionFeed vision_;

  bool has_device_thread_ = false;
  double rate_hz_;
  SafetyNews safety_;
  DeviceCycle cycle_;                   // the newest
  std::optional<ForceCommand> posted_;  // a force that is not known to be written yet, and its number
  std::uint64_t posted_number_ = 0;
  std::uint32_t cycles_behind_ = 0;
  bool is_snapshot_due_ = false;
  std::int64_t next_view_repeat_ns_ = 0;
  std::int64_t next_figures_ns_ = 0;
  StrangerNews strangers_;
  RefusalNews refusals_;
  std::int64_t next_denial_ns_ = 0;
  std::uint64_t resets_denied_ = 0;  // here, for want of the right or of a person

  bool is_finished_ = false;
  ProbeMemory probe_memory_;
  std::optional<ViewTransform> view_;
  std::optional<SceneFacts> scene_;  // of the haptics node
  SceneReach reach_ = SceneReach::unknown;
  std::size_t hand_leader_ = kNobody;
  Datagram incoming_;

  Mailbox<ServoStats> snapshots_;
  std::atomic<bool> snapshot_asked_{false};
  std::atomic<bool> report_wished_{false};
};

}  // namespace hapton
