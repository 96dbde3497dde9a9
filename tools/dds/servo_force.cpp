#include "tools/dds/servo_force.h"

namespace hapton::dds {

ServoForce::Verdict ServoForce::judge(const ServoCommand& command, std::int64_t now_ns) noexcept {
  if (is_fresh(now_ns) && command.writer != writer_) return Verdict::other_writer;
  if (command.frame_id != frame_) return Verdict::wrong_frame;
  if (!command.force_n.allFinite() || !command.torque_nm.allFinite()) return Verdict::not_finite;
  if (!command.torque_nm.isZero(0.0)) return Verdict::has_torque;
  // stableNorm: a square of 1e200 N has no place in a double.
  return command.force_n.stableNorm() > most_n_ ? Verdict::reduced : Verdict::accepted;
}

ServoForce::Verdict ServoForce::take(const ServoCommand& command, std::int64_t now_ns) noexcept {
  const Verdict verdict = judge(command, now_ns);
  switch (verdict) {
    case Verdict::other_writer:
      ++counts_.other_writer;
      return verdict;
    case Verdict::wrong_frame:
      ++counts_.wrong_frame;
      return verdict;
    case Verdict::not_finite:
      ++counts_.not_finite;
      writer_ = 0;
      return verdict;
    case Verdict::has_torque:
      ++counts_.has_torque;
      writer_ = 0;
      return verdict;
    case Verdict::reduced:
      ++counts_.reduced;
      break;
    case Verdict::accepted:
      break;
  }
  ++counts_.accepted;
  writer_ = command.writer;
  taken_ns_ = now_ns;
  force_n_ = command.force_n;
  if (verdict == Verdict::reduced) {
    // In two steps, as the largest numbers have no product.
    const double largest = command.force_n.cwiseAbs().maxCoeff();
    force_n_ = most_n_ * (command.force_n / largest).normalized();
  }
  return verdict;
}

}  // namespace hapton::dds
