#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/math/types.h"

namespace hapton::dds {

// A message of the topic servo_cf as it came from DDS. Vectors in the frame that frame_id names.
struct ServoCommand {
  std::uint64_t writer = 0;  // number of the DDS writer that sent it, not 0
  std::string_view frame_id;
  Vec3 force_n = Vec3::Zero();
  Vec3 torque_nm = Vec3::Zero();
};

// Decides which forces and torques from DDS take effect: those of one writer at a time, in the published frame W, finite, shortened to the
// largest allowed, for 20 ms each. The governor of io_node limits them again and does not rely on this. N, Nm, ns. RT: yes. Threads: one.
class ServoForce {
 public:
  // How long a command takes effect: as long as the governor's command timeout.
  static constexpr std::int64_t kMaxAgeNs = 20'000'000;

  enum class Verdict : std::uint8_t {
    accepted,
    reduced,       // accepted, scaled down to the largest force or torque
    wrong_frame,   // dropped
    not_finite,    // dropped, and the force is released
    has_torque,    // dropped, and the force is released: no torques are allowed
    other_writer,  // dropped: a command of another writer is in effect
  };
  struct Counts {
    std::uint64_t accepted = 0;  // includes those reduced
    std::uint64_t reduced = 0;
    std::uint64_t wrong_frame = 0;
    std::uint64_t not_finite = 0;
    std::uint64_t has_torque = 0;
    std::uint64_t other_writer = 0;
  };

  // most_n, most_nm: largest force and torque; most_nm 0: no torque is allowed. Pre: both are finite and not negative.
  ServoForce(std::string frame, double most_n, double most_nm = 0.0) : frame_(std::move(frame)), most_n_(most_n), most_nm_(most_nm) {}

  Verdict take(const ServoCommand& command, std::int64_t now_ns) noexcept;
  // The force and torque in effect, frame W. Zero if the last accepted command is kMaxAgeNs old or was followed by a release.
  Vec3 force_n(std::int64_t now_ns) const noexcept { return is_fresh(now_ns) ? force_n_ : Vec3(Vec3::Zero()); }
  Vec3 torque_nm(std::int64_t now_ns) const noexcept { return is_fresh(now_ns) ? torque_nm_ : Vec3(Vec3::Zero()); }
  const Counts& counts() const noexcept { return counts_; }

 private:
  bool is_fresh(std::int64_t now_ns) const noexcept { return writer_ != 0 && now_ns - accepted_ns_ < kMaxAgeNs; }
  Verdict evaluate(const ServoCommand& command, std::int64_t now_ns) noexcept;

  std::string frame_;
  double most_n_;
  double most_nm_;
  std::uint64_t writer_ = 0;
  std::int64_t accepted_ns_ = 0;
  Vec3 force_n_ = Vec3::Zero();
  Vec3 torque_nm_ = Vec3::Zero();
  Counts counts_;
};

}  // namespace hapton::dds
