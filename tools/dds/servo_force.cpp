#include "tools/dds/servo_force.h"

namespace hapton::dds {
namespace {

// stableNorm, because the square of 1e200 N is too large for a double.
bool is_above(const Vec3& vector, double most) { return vector.stableNorm() > most; }

// Shortens the vector and keeps its direction, in two steps, so that the largest numbers do not overflow.
Vec3 shortened(const Vec3& vector, double most) {
  if (!is_above(vector, most)) return vector;
  return most * (vector / vector.cwiseAbs().maxCoeff()).normalized();
}

}  // namespace

ServoForce::Verdict ServoForce::evaluate(const ServoCommand& command, std::int64_t now_ns) noexcept {
  if (is_fresh(now_ns) && command.writer != writer_) return Verdict::other_writer;
  if (command.frame_id != frame_) return Verdict::wrong_frame;
  if (!command.force_n.allFinite() || !command.torque_nm.allFinite()) return Verdict::not_finite;
  if (most_nm_ == 0.0 && !command.torque_nm.isZero(0.0)) return Verdict::has_torque;
  return is_above(command.force_n, most_n_) || is_above(command.torque_nm, most_nm_) ? Verdict::reduced : Verdict::accepted;
}

ServoForce::Verdict ServoForce::take(const ServoCommand& command, std::int64_t now_ns) noexcept {
  const Verdict verdict = evaluate(command, now_ns);
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
  accepted_ns_ = now_ns;
  force_n_ = shortened(command.force_n, most_n_);
  torque_nm_ = shortened(command.torque_nm, most_nm_);
  return verdict;
}

}  // namespace hapton::dds
