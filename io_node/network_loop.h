#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "devices/device.h"
#include "io_node/carve_collector.h"
#include "io_node/cycle_source.h"
#include "io_node/device_loop.h"
#include "io_node/echo_probe.h"
#include "io_node/event_ring.h"
#include "io_node/force_exchange.h"
#include "io_node/hop_meter.h"
#include "io_node/hub_receiver.h"
#include "io_node/loop_reporter.h"
#include "io_node/marker_log.h"
#include "io_node/patch_link.h"
#include "io_node/peer_notices.h"
#include "io_node/reply_spin.h"
#include "io_node/report_server.h"
#include "io_node/request_handler.h"
#include "io_node/safety_notices.h"
#include "io_node/scene_relay.h"
#include "io_node/servo_stats.h"
#include "io_node/servo_tap.h"
#include "io_node/shape_collector.h"
#include "io_node/stats_publisher.h"
#include "io_node/touch_notices.h"
#include "io_node/view_relay.h"
#include "io_node/vision_feed.h"
#include "io_node/vrpn/vrpn_feed.h"
#include "link/budgeted_endpoint.h"
#include "link/hub_peers.h"
#include "runtime/clock.h"

namespace hapton {

// The network side of io_node. It exchanges datagrams with the other nodes and is slaved to the device side (DeviceLoop), which gives it
// samples and takes forces. Each cycle: read the sample, send it to the haptics node, await the force, which the device side governs and
// writes as it arrives; then housekeeping (probe states, statistics) and, halfway, a bare echo.
//
// If several forces arrive, the newest applies. If this side stalls, the device side continues and releases the force in time. If the
// device side has no thread of its own (tests on simulated time), step runs its cycles as well. While the device side computes the forces
// itself (patches), this side wakes kRestedHz times a second, or as often as vision nodes get states, and reads all cycles made since then
// together. Units: ns of the hub's clock. RT: step and finish yes; construction set-up only. Threads: one, except for request_snapshot,
// take_snapshot, snapshot, take_report_request, events, spin and reply_spin (one other thread), and for device_loop (see DeviceLoop).
class NetworkLoop final : private PeerEventHandler {
 public:
  // At 10 kHz, ten cycles are read together; nothing that people or nodes see is more frequent.
  static constexpr double kRestedHz = 1000.0;

  struct Options {
    double rate_hz = 1000.0;
    double vision_rate_hz = 240.0;     // most ProbeStates a second to each vision node (vision_pace.h); 0: none
    DeviceLimits tighter_limits = {};  // limits below the device's own, field by field; 0: the device's own
    bool forbids_force = false;        // the device is read and shown, but never gets a force
    bool forbids_torque = false;       // the device never gets a torque; it may get a force
    std::optional<PassivityController::Mechanics> passive_mechanics = {};  // of the device; none: no passivity controller
    int dead_mans_switch = 0;                                              // button that must be held for force, counted from 1; 0: none
    int clutch_button = 0;  // button that, while held, keeps the device point where it is (clutch.h), counted from 1; 0: none
    OverrunPolicy overrun = OverrunPolicy::skip;
    double spin_share = 0.0;         // largest share of a period spent spinning before each tick; 0: sleeps until the tick
    std::int64_t reply_spin_ns = 0;  // the longest time to spin for a force before this side sleeps (ReplySpin)
  };

  // Pre: all outlive this; rate within kMinServoRateHz .. kMaxServoRateHz. echo and tap may be null.
  NetworkLoop(Device& device, HubPeers& peers, const Clock& clock, const Options& options, EchoProbe* echo = nullptr,
              ServoTap* tap = nullptr);
  // The hub sends its Byes after this, when the tap may be gone.
  ~NetworkLoop() { peers_.set_tap(nullptr); }

  // Set up before start. Pre: each outlives this.
  void set_hop_meter(HopMeter* hops) noexcept;
  void set_report_server(ReportServer* server) noexcept { report_server_ = server; }
  void set_budget(BudgetedEndpoint* budget) noexcept;
  void set_patch_link(PatchLink* patches) noexcept { patches_ = patches; }
  void use_device_thread() noexcept { cycles_.use_device_thread(); }
  // Shows the proxy in this feed too, once a cycle.
  void set_vrpn_feed(vrpn::Feed* feed) noexcept { vrpn_feed_ = feed; }
  DeviceLoop& device_loop() noexcept { return loop_; }

  // Starts the schedule and the statistics. Pre: a device side with a thread of its own has started its clock.
  void start() noexcept;
  // One cycle: waits for its tick if necessary, and ends at the next one.
  void step() noexcept;
  // Receives the last replies and releases the force as the governor does after a command timeout; about 22 ms.
  void finish() noexcept;
  // Records the cycles that the device side has made since the last one read. Threads: any, once the threads of both sides have ended.
  void record_remaining_cycles() noexcept;

  // The statistics so far. Threads: the network side's only.
  const ServoStats& collect_stats() noexcept { return fill_stats(loop_.collect_stats()); }
  DeviceStatus device_status() const noexcept { return loop_.status(); }
  // A cycle was missed under OverrunPolicy::stop.
  bool has_overrun() const noexcept { return loop_.has_overrun(); }
  const DeviceLimits& limits() const noexcept { return loop_.limits(); }
  double rate_hz() const noexcept { return requests_.rate_hz(); }

  // Threads: the other. Limit and measurement of the time spent spinning.
  AdaptiveSpin& spin() noexcept { return loop_.spin(); }
  ReplySpin& reply_spin() noexcept { return reply_spin_; }
  // Threads: the other. See StatsPublisher and RequestHandler.
  void request_snapshot() noexcept { publisher_.request(); }
  bool take_snapshot() noexcept { return publisher_.take(); }
  const ServoStats& snapshot() const noexcept { return publisher_.copy(); }
  bool take_report_request() noexcept { return requests_.take_report_request(); }
  EventRing& events() noexcept { return events_; }

 private:
  bool read_cycles() noexcept;
  void await_force(std::int64_t deadline_ns) noexcept;
  template <class IsNeeded>
  void spin_for_force(IsNeeded&& is_needed, std::int64_t deadline_ns) noexcept;
  void probe_echo(std::int64_t middle_ns) noexcept;
  void do_housekeeping() noexcept;
  void show_proxy() noexcept;

  void handle(const PeerEvent& event, const Datagram& datagram) noexcept override;
  void on_message(const PeerEvent& event, const Datagram& datagram) noexcept;
  void on_newest(const PeerEvent& event, const Datagram& datagram) noexcept;
  void on_joined(const PeerEvent& event) noexcept;
  void on_left(const PeerEvent& event) noexcept;
  void on_view(const ViewTransform& view, std::size_t peer) noexcept;
  void on_setup(const HapticsSetup& setup) noexcept;

  const ServoStats& fill_stats(const DeviceLoopStats& device) noexcept;

  DeviceLoop loop_;
  HubPeers& peers_;
  const Clock& clock_;
  EchoProbe* echo_;
  ServoTap* tap_;
  HopMeter* hops_ = nullptr;
  ReportServer* report_server_ = nullptr;
  BudgetedEndpoint* budget_ = nullptr;
  PatchLink* patches_ = nullptr;
  vrpn::Feed* vrpn_feed_ = nullptr;
  EventRing events_;
  ServoStats stats_;

  HubReceiver receiver_;
  ReplySpin reply_spin_;
  CycleSource cycles_;
  ForceExchange forces_;
  ViewRelay view_;
  SceneRelay scene_;
  VisionFeed vision_;
  RequestHandler requests_;
  LoopReporter loop_reporter_;
  MarkerLog markers_;
  CarveCollector carves_;
  ShapeCollector shapes_;
  PeerNotices peer_notices_;
  TouchNotices touch_notices_;
  SafetyNotices safety_;
  StatsPublisher publisher_;

  // How long this side may rest after the newest cycle; 0: not beyond the next one.
  std::int64_t rest_ns() const noexcept { return forces_.is_local() ? local_rest_ns_ : 0; }

  DeviceCycle cycle_;  // the newest
  const std::int64_t local_rest_ns_;
  std::int64_t next_statistics_ns_ = 0;
};

}  // namespace hapton
