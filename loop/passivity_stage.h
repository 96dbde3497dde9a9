#pragma once

#include "loop/force_chain.h"
#include "safety/passivity_controller.h"

namespace hapton {

// The passivity controller of the servo in the laboratory's chain.
class PassivityStage final : public ForceStage {
 public:
  explicit PassivityStage(const PassivityController::Options& options) : controller_(options) {}

  void observe(const Vec3& p_WD, std::int64_t now_ns) noexcept override { controller_.observe(p_WD, now_ns); }
  Vec3 shape(const Vec3& force_n, std::int64_t now_ns) noexcept override { return controller_.shape(force_n, now_ns); }
  void note_written(const Vec3& force_n) noexcept override { controller_.note_written(force_n); }

  const PassivityController& controller() const noexcept { return controller_; }

 private:
  PassivityController controller_;
};

}  // namespace hapton
