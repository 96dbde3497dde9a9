#include "closed_loop/loop_simulation.h"

#include <algorithm>
#include <limits>

namespace hapton {

LoopSimulation::LoopSimulation(ForceChain& chain, const Options& options)
    : chain_(chain), options_(options), motion_(options.device, options.hand) {
  for (int i = 0; i < 3; ++i) axes_[static_cast<std::size_t>(i)] = motion_.rest_at(options.start_m[i]);
}

Vec3 LoopSimulation::position_m() const noexcept { return {axes_[0].position_m(), axes_[1].position_m(), axes_[2].position_m()}; }

Vec3 LoopSimulation::velocity_m_per_s() const noexcept {
  return {axes_[0].velocity_m_per_s(), axes_[1].velocity_m_per_s(), axes_[2].velocity_m_per_s()};
}

double LoopSimulation::motor_j() const noexcept { return axes_[0].motor_j + axes_[1].motor_j + axes_[2].motor_j; }
double LoopSimulation::lost_j() const noexcept { return axes_[0].lost_j + axes_[1].lost_j + axes_[2].lost_j; }

double LoopSimulation::stored_j() const noexcept {
  const Vec3 hand_m = options_.path.position_m(now_ns_);
  double stored = 0.0;
  for (int i = 0; i < options_.axes; ++i) stored += motion_.stored_j(axes_[static_cast<std::size_t>(i)], hand_m[i]);
  return stored;
}

LoopRow LoopSimulation::row() const noexcept { return {now_ns_, position_m(), chain_.force_n(), motor_j(), lost_j()}; }

// Pre: the force and the course of the hand do not change before time_ns.
void LoopSimulation::move_until(std::int64_t time_ns) noexcept {
  const Vec3 hand_m = options_.path.position_m(now_ns_);
  const Vec3 hand_m_per_s = options_.path.velocity_m_per_s(now_ns_);
  const Vec3 push_n = options_.path.push_n(now_ns_);
  for (int i = 0; i < options_.axes; ++i) {
    motion_.advance(axes_[static_cast<std::size_t>(i)],
                    {.command_n = chain_.force_n()[i], .hand_m = hand_m[i], .hand_m_per_s = hand_m_per_s[i], .push_n = push_n[i]},
                    time_ns - now_ns_);
  }
  now_ns_ = time_ns;
}

bool LoopSimulation::run_until(std::int64_t end_ns, std::vector<LoopRow>* rows) {
  while (now_ns_ < end_ns) {
    if (now_ns_ == tick_ns_) {
      chain_.sample(position_m(), now_ns_);
      tick_ns_ += options_.period_ns;
      if (rows != nullptr) rows->push_back(row());
      if (!(position_m().norm() < kOutOfReachM)) return false;
    }
    const std::int64_t due_ns = chain_.next_ns().value_or(std::numeric_limits<std::int64_t>::max());
    move_until(std::min({end_ns, tick_ns_, due_ns, options_.path.next_ns(now_ns_)}));
    chain_.receive(now_ns_);
  }
  return true;
}

}  // namespace hapton
