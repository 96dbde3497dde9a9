#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "safety/command_filter.h"

namespace hapton {

// A stream of random bits that is the same everywhere. Source: Steele, Lea and Flood, "Fast splittable pseudorandom number generators"
// (2014): SplitMix64.
class SplitMix {
 public:
  explicit SplitMix(std::uint64_t seed) noexcept : state_(seed) {}
  std::uint64_t bits() noexcept {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15U);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31);
  }
  // 0 .. n - 1; n > 0.
  std::uint64_t below(std::uint64_t n) noexcept { return bits() % n; }
  double uniform(double low, double high) noexcept { return low + (high - low) * (static_cast<double>(bits() >> 11) * 0x1p-53); }
  bool once_in(std::uint64_t n) noexcept { return below(n) == 0; }
  Vec3 vector(double size) noexcept { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }

 private:
  std::uint64_t state_;
};

// The inputs of a governor in one turn, in this order; those that are empty, false or negative are left out.
struct HostileStep {
  std::optional<DeviceLimits> tighter_limits;
  bool resets_faults = false;
  double temperature = -1.0;
  DeviceSample sample;  // its time_ns may contradict now_ns
  DeviceStatus status = DeviceStatus::ready;
  std::optional<WrenchCommand> command;
  std::int64_t now_ns = 0;
};

// A hostile device, hand and haptics node, from one seed: a device with random limits, and phases of 5 to 204 turns, each
// with one kind of force (spring, square wave at the Nyquist frequency, NaN, active force, old commands, none), of motion (a mass
// on a soft spring, a hand that follows the force, jumps, invalid poses) and of time (250 Hz to 10 kHz, jitter, jumps, backwards);
// the state (away, released, hot, failed) changes at random. Time, motion and state are each regular in about half of the
// programs, because otherwise each would soon end in a latched fault. RT: no heap. Threads: one for each object.
class HostileProgram {
 public:
  static constexpr double kTurnRadPerS = 5.0;  // angular velocity that a physical device does not exceed; a free choice

  explicit HostileProgram(std::uint64_t seed) noexcept;

  const DeviceLimits& device() const noexcept { return device_; }
  // Button that the governor must require, counted from 1; 0 or above 32: none.
  int button() const noexcept { return button_; }
  // The number of turns that the program has.
  int turns() const noexcept { return turns_; }
  // Time never jumps, and the device moves physically: its heat and energy can be checked against absolute bounds.
  bool is_physical() const noexcept { return is_physical_; }

  // Makes the inputs of the next turn. out: the governor's last output to the motors.
  const HostileStep& turn(const Wrench& out) noexcept;

 private:
  enum class Force : std::uint8_t { none, spring, active, most, sine, noise, nyquist, huge, tiny, replay, extreme, count };
  enum class Motion : std::uint8_t { mass, still, sweep, yielding, noise, fast, jump, extreme, count };
  enum class Time : std::uint8_t { steady, jitter, stall, jump, back, count };

  void choose_device() noexcept;
  void choose_phase() noexcept;
  void advance_time() noexcept;
  void move(const Wrench& out) noexcept;
  void move_mass(const Vec3& force_n, double passed_s) noexcept;
  void choose_state() noexcept;
  void choose_command() noexcept;
  Vec3 command_force_n(double most) noexcept;
  double extreme_value() noexcept;

  SplitMix random_;
  DeviceLimits device_;
  HostileStep step_;
  int turns_ = 0;
  int button_ = 0;
  bool is_physical_ = false;
  bool is_regular_in_time_ = false;
  bool is_regular_in_motion_ = false;
  bool is_regular_in_state_ = false;
  Force force_ = Force::none;
  Motion motion_ = Motion::still;
  Time time_ = Time::steady;
  int remaining_turns_ = 0;  // remaining turns of this phase
  int turn_ = 0;
  std::int64_t period_ns_ = 1'000'000;
  std::int64_t clock_ns_ = 0;  // the true time
  double passed_s_ = 0.0;
  Vec3 p_m_ = Vec3::Zero();
  Vec3 v_m_per_s_ = Vec3::Zero();
  Vec3 hand_m_ = Vec3::Zero();
  Vec3 hand_m_per_s_ = Vec3::Zero();
  Quat q_ = Quat::Identity();
  Vec3 turn_rad_per_s_ = Vec3::Zero();
  Vec3 axis_ = Vec3::UnitZ();
  double hertz_ = 1.0;
  std::array<WrenchCommand, 16> sent_commands_ = {};
};

}  // namespace hapton
