#include "safety/energy_budget.h"

#include <algorithm>

namespace hapton {

void EnergyBudget::observe(double max_force_n, const Wrench& wrench, const Vec3& moved_m, const Vec3& turned_rad) noexcept {
  const bool knows_mean = passed_s_ > 0.0;
  const double force_j = knows_mean ? force_n_s_.dot(moved_m) / passed_s_ : wrench.force_n.dot(moved_m);
  const double torque_j = knows_mean ? torque_nm_s_.dot(turned_rad) / passed_s_ : wrench.torque_nm.dot(turned_rad);
  const double forgiven_j = kForgivenMPerS * max_force_n * passed_s_;
  spent_j_ = std::clamp(spent_j_ + force_j + torque_j - forgiven_j, -free_j(max_force_n), kSaturationM * max_force_n);
  force_n_s_ = torque_nm_s_ = Vec3::Zero();
  passed_s_ = 0.0;
}

double EnergyBudget::damping_n_s_per_m(double max_force_n, double speed_m_per_s, double most) const noexcept {
  const double excess_j = spent_j_ - free_j(max_force_n);
  if (excess_j <= 0.0 || speed_m_per_s <= 0.0) return 0.0;
  return std::min(most, excess_j / (kTakeBackS * speed_m_per_s * speed_m_per_s));
}

double EnergyBudget::share(double max_force_n) const noexcept {
  const double free_limit_j = free_j(max_force_n);
  if (spent_j_ <= free_limit_j) return 1.0;
  return std::max((most_j(max_force_n) - spent_j_) / (most_j(max_force_n) - free_limit_j), 0.0);
}

}  // namespace hapton
