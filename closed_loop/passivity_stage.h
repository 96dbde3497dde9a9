#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>

#include "closed_loop/force_chain.h"
#include "safety/passivity_controller.h"

namespace hapton {

// Runs the governor's passivity controller in a simulated force chain that has no governor.
class PassivityStage final : public ForceStage {
 public:
  struct Options {
    PassivityController::Mechanics device;
    double most_damping_ns_per_m = 1.0;
    double max_force_n = 0.0;  // 0: unlimited
  };

  // The damping that a device can render: a quarter of that which stops its mass within one period.
  static constexpr double renderable_damping_ns_per_m(double mass_kg, double rate_hz) noexcept { return 0.25 * mass_kg * rate_hz; }

  explicit PassivityStage(const Options& options) : options_(options), controller_(options.device) {}

  void observe(const Vec3& p_WD, std::int64_t now_ns) noexcept override {
    advance(now_ns);
    const double max_force_n = options_.max_force_n > 0.0 ? options_.max_force_n : std::numeric_limits<double>::infinity();
    if (last_p_WD_) controller_.observe(max_force_n, p_WD - *last_p_WD_);
    last_p_WD_ = p_WD;
    worst_debt_j_ = std::max(worst_debt_j_, controller_.given_j());
  }
  Vec3 shape(const Vec3& force_n, std::int64_t now_ns) noexcept override {
    advance(now_ns);
    written_n_ = controller_.shape(force_n, options_.most_damping_ns_per_m);
    acted_ += controller_.has_limited() ? 1 : 0;
    return written_n_;
  }
  void note_written(const Vec3& force_n) noexcept override { written_n_ = force_n; }

  // Number of forces that the controller changed.
  std::uint64_t acted() const noexcept { return acted_; }
  // The largest energy deficit so far, J.
  double worst_debt_j() const noexcept { return worst_debt_j_; }

 private:
  void advance(std::int64_t now_ns) noexcept {
    if (last_ns_ && now_ns > *last_ns_) controller_.note_applied(written_n_, 1e-9 * static_cast<double>(now_ns - *last_ns_));
    last_ns_ = now_ns;
  }

  Options options_;
  PassivityController controller_;
  std::optional<Vec3> last_p_WD_;
  std::optional<std::int64_t> last_ns_;
  Vec3 written_n_ = Vec3::Zero();
  double worst_debt_j_ = 0.0;
  std::uint64_t acted_ = 0;
};

}  // namespace hapton
