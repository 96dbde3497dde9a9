#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/mailbox.h"
#include "core/force/force_fade.h"
#include "devices/device.h"
#include "io_node/clutch.h"
#include "io_node/local_touch.h"
#include "link/session_entry.h"
#include "runtime/adaptive_spin.h"
#include "runtime/clock.h"
#include "runtime/latency_histogram.h"
#include "safety/safety_governor.h"

namespace hapton {

// What happens when a cycle is late by a period or more:
//   skip      whole periods are skipped, and the next tick is on time again
//   catch_up  up to kMaxCaughtUp missed cycles run at once, one after the other; more are skipped
//   stop      a missed cycle ends the session: has_overrun() from then on
enum class OverrunPolicy : std::uint8_t { skip, catch_up, stop };

// How the presence of a person is verified for the reset of a latched fault (reset_permission.h). known: it is known already; while_held:
// by the dead man's switch, which must still be held when the reset takes effect.
enum class ResetPresence : std::uint8_t { known, while_held };

// One cycle of the device loop, as reported to the network side.
struct DeviceCycle {
  std::uint64_t number = 0;  // number of the sample, from 1
  DeviceSample sample;
  std::int64_t tick_ns = 0;
  std::int64_t next_tick_ns = 0;
  std::int64_t next_wake_ns = 0;  // when the cycle's thread ends its sleep before next_tick_ns
  std::int64_t late_ns = 0;
  std::uint32_t missed = 0;  // number of cycles skipped before this one
  MissCause cause = MissCause::none;
  std::optional<LocalForce> local;  // the force for this sample, if the device side computed it
  Wrench written;                   // on the motors at the end of the cycle, before any reply of the haptics node to this sample
};

// The present state of the device side.
struct DeviceSide {
  Wrench written;  // on the motors
  DeviceStatus status = DeviceStatus::ready;
  GovernorStats governor;
  bool has_timed_out = true;  // see SafetyGovernor::has_timed_out
  bool is_energy_gone = false;
  bool is_switch_held = false;  // see SafetyGovernor::is_switch_held
  bool has_overrun = false;
  std::uint64_t command_number = 0;  // number of the newest force command that was governed
  std::int64_t ready_ns = 0;         // when its governed force was ready, and when it was written to the device
  std::int64_t written_ns = 0;
};

// Measurements of the device side.
struct DeviceLoopStats {
  std::int64_t start_ns = 0;
  std::int64_t end_ns = 0;
  double rate_hz = 0.0;
  LatencyHistogram wake_lateness;
  LatencyHistogram device_read;
  std::uint64_t samples = 0;
  std::uint64_t missed_cycles = 0;
  std::uint64_t caught_up_cycles = 0;
  std::array<std::uint64_t, 5> missed_by_cause = {};
  double max_force_n = 0.0;
  double max_torque_nm = 0.0;
  std::int64_t longest_release_ns = 0;  // sample of the last force -> zero on the device, over all command timeouts
  std::uint64_t commands = 0;           // force commands governed
  std::uint64_t local_forces = 0;       // forces that the device side computed
  std::uint64_t commands_unused = 0;    // force commands that came while the device side computed the forces
  std::uint64_t resets_denied = 0;      // resets denied because the switch was released before they took effect
  std::uint64_t cuts = 0;               // times that a force became too old and the device was cut off (cut_if_older)
  std::uint64_t cycles_unreported = 0;  // cycles lost because the network side was kMaxQueuedCycles cycles behind
  GovernorStats governor;
  DeviceStatus status = DeviceStatus::ready;
  DeviceCondition condition;
};

// The device side of io_node: it owns the device and its safety governor and is the clock of the whole system. Each cycle begins at a tick
// of absolute time: release a force that is too old, read the device, update the governor, hold or ramp down the present force. It handles
// no datagram, key, parser or socket, allocates nothing and never blocks. Forces arrive in a mailbox that keeps the newest; the cycle
// brings the motors to zero in time even if none arrives.
//
// A force must not wait for the next tick, and waking another thread would add 3 to 30 us to every round trip (decision 94). So the
// thread that posts a force also governs and writes it, unless the device side is in the middle of its cycle; then the cycle does so at its
// end. A thread that uses device and governor holds the claim, a try-lock on which no thread waits. A cycle that finds the claim taken (the
// network side was preempted while it held it) retries soon, and cuts the device off (Device::cut) if the force becomes too old meanwhile:
// that needs no claim. Any other thread can do the same if this cycle does not run (cut_if_older).
//
// Units: ns of the clock; frame W (world). RT: yes, except the constructor. Threads: one for the cycle (start to finish), one for the
// network side; they may be the same.
class DeviceLoop {
 public:
  // A choice: at 1 kHz, as many cycles as the longest delay that does not count as a stall (kStallNs).
  static constexpr std::int64_t kMaxCaughtUp = 10;
  // A cycle that is late by this much or more means that the machine was stalled: no work, device access or wake-up takes that long.
  static constexpr std::int64_t kStallNs = 10 * kNanosecondsPerMillisecond;
  // Size of the queue of cycles to the network side: 0.8 s at 10 kHz. For that time the network side may have no CPU, or not have started
  // yet, without a gap in a recording.
  static constexpr std::size_t kMaxQueuedCycles = 8192;

  struct Options {
    double rate_hz = 1000.0;
    DeviceLimits tighter_limits = {};
    bool forbids_force = false;
    bool forbids_torque = false;
    int dead_mans_switch = 0;  // button, counted from 1; 0: none
    int clutch_button = 0;     // button, counted from 1; 0: no clutch
    std::optional<PassivityController::Mechanics> passive_mechanics = {};
    OverrunPolicy overrun = OverrunPolicy::skip;
    double spin_share = 0.0;
  };

  // Pre: device and clock outlive this.
  DeviceLoop(Device& device, const Clock& clock, const Options& options);

  // Set up before start: the page in which the watchdog process reads the heartbeat. Pre: page outlives this.
  void set_heartbeat_page(HeartbeatPage* page) noexcept { heartbeat_page_ = page; }

  // Set up before start: what computes forces on the device side when it can; null: none are computed here. Pre: local outlives this.
  void set_local_touch(LocalTouch* local) noexcept { local_touch_ = local; }

  // Set up before start: latches again the fault that was latched when an earlier process ended.
  void restore_latched_fault(SafetyFault fault) noexcept { governor_.restore_latched_fault(fault); }

  // --- the cycle's thread

  // Sets the first tick one period from now.
  void start() noexcept;
  std::int64_t tick_ns() const noexcept { return tick_ns_; }
  // When to end a sleep before the next tick; the rest is spun.
  std::int64_t wake_ns() const noexcept { return tick_ns_ - spin_.margin_ns(period_ns()); }
  std::int64_t wake_after_next_ns() const noexcept { return wake_ns() + period_ns(); }
  // To be called before the wait for a tick: whether the tick has passed already; after that wait: how long after wake_ns() it ended; after
  // any other wait of the thread: how long after its intended end it ended.
  void note_behind(bool is_behind) noexcept { is_behind_ = is_behind; }
  void note_wake_up(std::int64_t late_ns) noexcept { spin_.note_wake_up(late_ns); }
  void note_overslept(std::int64_t late_ns) noexcept { overslept_ns_ = late_ns > overslept_ns_ ? late_ns : overslept_ns_; }
  // Spins until the tick, and handles the cycles missed before it (OverrunPolicy).
  void begin_cycle() noexcept;
  // Runs the cycle. False: the network side is writing a force; call again soon. Nothing was done, but the device may have been cut off.
  bool run_cycle() noexcept;
  // hold: a cycle without a sample: applies requests and ramps the force down. finish: at the end, writes zero force. False: as run_cycle.
  bool hold() noexcept;
  bool finish() noexcept;
  const DeviceLoopStats& collect_stats() noexcept;

  // --- the network side

  // Takes the oldest cycle that was not taken yet; false: there is none.
  bool take_cycle(DeviceCycle& cycle) noexcept;
  bool has_cycle() const noexcept { return cycles_begin_.load(std::memory_order_relaxed) != cycles_end_.load(std::memory_order_acquire); }
  // The newest state of the device side; stays as it is until the next call.
  const DeviceSide& latest() noexcept {
    sides_.take();
    return sides_.value();
  }
  // Posts a force. Returns its number (DeviceSide::command_number); normally it is governed and written when this returns.
  std::uint64_t post(const WrenchCommand& wrench_command) noexcept;
  // These take effect with the next cycle.
  void set_hand_target(const std::optional<Vec3>& p_WH, std::uint32_t buttons = 0, const Vec3& turn_rad = Vec3::Zero()) noexcept;
  void aim_hand(std::span<const Vec3> p_WA) noexcept;  // see Device::aim_hand; at most Device::kMaxAims points
  void reset_faults(ResetPresence presence) noexcept;
  void set_rate_hz(double rate_hz) noexcept;  // the next tick is still that of the rate before
  void end() noexcept;                        // the session ends: the governor's later events are not counted
  // Requests a copy of the measurements; take_stats() returns true once when stats_copy() has a new one.
  void request_stats() noexcept;
  bool take_stats() noexcept { return stats_copies_.take(); }
  const DeviceLoopStats& stats_copy() const noexcept { return stats_copies_.value(); }
  const DeviceLimits& limits() const noexcept { return governor_.limits(); }

  // --- any thread
  // Cuts the device off (Device::cut) if the force on its motors replies to a sample of that age or older: for a monitor in a thread of
  // another scheduling class, which runs when the cycle's thread cannot. The force ramps up afterwards. True: the device was cut off;
  // false: no force is that old, or the device has no cut. RT: yes, wait-free.
  bool cut_if_older(std::int64_t limit_ns) noexcept;
  // Time at which the newest cycle ended.
  std::int64_t heartbeat_ns() const noexcept { return heartbeat_ns_.load(std::memory_order_acquire); }
  AdaptiveSpin& spin() noexcept { return spin_; }
  // Time of the sample that the force on the motors replies to; 0: no force.
  std::int64_t force_sample_ns() const noexcept { return force_sample_ns_.load(std::memory_order_acquire); }
  DeviceStatus status() const noexcept { return status_.load(std::memory_order_acquire); }
  bool has_overrun() const noexcept { return has_overrun_.load(std::memory_order_acquire); }

 private:
  struct Command {
    WrenchCommand wrench_command;
    std::uint64_t number = 0;
  };
  struct Requests {        // each serial counts the requests of its kind
    double rate_hz = 0.0;  // 0: unchanged
    std::optional<Vec3> p_WH;
    std::uint32_t buttons = 0;
    Vec3 turn_rad = Vec3::Zero();
    std::uint32_t hand_target_serial = 0;
    std::array<Vec3, Device::kMaxAims> p_WA;
    std::size_t aim_count = 0;
    std::uint32_t aim_serial = 0;
    std::uint32_t reset_serial = 0;          // of resets with ResetPresence::known
    std::uint32_t reset_if_held_serial = 0;  // of resets with ResetPresence::while_held
    std::uint32_t stats_serial = 0;
    bool ends = false;
  };

  std::int64_t period_ns() const noexcept;
  bool claim() noexcept;
  void release_claim() noexcept { claimed_.exchange(false); }
  void serve() noexcept;
  void serve_command(const Command& command) noexcept;
  void govern(const WrenchCommand& wrench_command, std::int64_t now_ns) noexcept;
  void step_locally() noexcept;
  Vec3 fade_force(const Vec3& force_n, bool contact, bool is_new_source, std::int64_t now_ns) noexcept;
  void handle_overrun(std::int64_t late_ns) noexcept;
  MissCause cause_of(std::int64_t late_ns) const noexcept;
  void apply_requests() noexcept;
  void sample_device() noexcept;
  void hold_force() noexcept;
  void write(const Wrench& wrench) noexcept;
  void publish_side() noexcept;
  void set_force_sample(std::int64_t sample_ns) noexcept;
  bool is_cut() const noexcept;
  void cut_or_restore() noexcept;

  Device& device_;
  const Clock& clock_;
  OverrunPolicy policy_;
  HeartbeatPage* heartbeat_page_ = nullptr;
  LocalTouch* local_touch_ = nullptr;
  SafetyGovernor governor_;
  Clutch clutch_;  // owned by the holder of the claim
  DeviceLoopStats stats_;
  AdaptiveSpin spin_;

  // Used by the cycle's thread.
  std::int64_t tick_ns_ = 0;
  std::int64_t overslept_ns_ = 0;  // by how much a wait since the last tick ended too late, at most
  bool is_behind_ = false;         // the tick had passed before the loop began to wait for it
  bool is_finished_ = false;
  DeviceCycle cycle_;
  std::int64_t next_temperature_check_ns_ = 0;  // when the temperature of the motors is read next
  std::uint32_t hand_target_serial_ = 0;
  std::uint32_t aim_serial_ = 0;
  std::uint32_t reset_serial_ = 0;
  std::uint32_t reset_if_held_serial_ = 0;
  std::uint32_t stats_serial_ = 0;

  // Used by the holder of the claim.
  // Time spent in calls of the device since the last tick; also read without the claim, for the cause of a missed cycle.
  std::atomic<std::int64_t> device_call_ns_{0};
  Wrench written_;
  bool is_local_ = false;                // the force comes from local_touch_
  ForceFade fade_;                       // from remote force to local force and back, and from patch to patch
  std::int64_t last_fade_ns_ = 0;        // time of the last step of fade_
  std::int64_t accepted_sample_ns_ = 0;  // sample time of the last force that the governor accepted
  std::int64_t force_ready_ns_ = 0;
  std::int64_t force_written_ns_ = -1;  // time of the last force since the last cycle; below 0: none
  std::uint64_t command_number_ = 0;    // DeviceSide::command_number of the newest command; the next two: its times, as there
  std::int64_t command_ready_ns_ = 0;
  std::int64_t command_written_ns_ = 0;

  std::atomic<bool> claimed_{false};
  std::atomic<std::uint64_t> posted_{0};
  std::atomic<std::uint64_t> served_{0};
  std::atomic<std::int64_t> force_sample_ns_{0};
  std::atomic<std::int64_t> heartbeat_ns_{0};
  std::atomic<DeviceStatus> status_{DeviceStatus::ready};
  std::atomic<bool> has_overrun_{false};
  std::atomic<bool> is_cut_by_process_{false};
  bool is_cut_for_fault_ = false;  // used by the holder of the claim: cut because a fault is latched
  std::atomic<std::uint64_t> cuts_{0};
  Mailbox<Command> commands_;
  Mailbox<DeviceSide> sides_;
  Mailbox<DeviceLoopStats> stats_copies_;

  // Used by the network side.
  Requests requests_;
  Mailbox<Requests> request_mailbox_;

  std::vector<DeviceCycle> cycles_ = std::vector<DeviceCycle>(kMaxQueuedCycles);  // ring buffer
  alignas(64) std::atomic<std::size_t> cycles_begin_{0};
  alignas(64) std::atomic<std::size_t> cycles_end_{0};
};

}  // namespace hapton
