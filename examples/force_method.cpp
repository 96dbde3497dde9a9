// Shows: a force method of your own, here an exact ball without a mesh, in the same step that the nodes use.
// Run:   force_method
#include <cstdio>
#include <memory>

#include "core/force/touch_step.h"

using namespace hapton;

class BallMethod final : public ForceMethod {
 public:
  BallMethod(double radius_m, const Material& material) : radius_m_(radius_m), material_(material) {}

  // Bounded time, and no heap, lock, system call, log or throw: a servo loop calls it.
  MethodOutput step(const MethodInput& input) noexcept override {
    if (!input.p_SD.allFinite()) return {};
    const double distance_m = input.p_SD.norm();
    MethodOutput out{.p_SP = input.p_SD};
    if (distance_m >= radius_m_ || distance_m == 0.0) return out;
    out.p_SP = input.p_SD * (radius_m_ / distance_m);  // the proxy rests on the surface
    out.force_n = material_.stiffness_n_per_m * (out.p_SP - input.p_SD);
    out.contact = true;
    out.object = 0;
    return out;
  }
  void reset(const Vec3&) noexcept override {}  // it remembers nothing
  void set_materials(std::span<const Material> materials) noexcept override { material_ = materials[0]; }
  std::string describe() const override { return "an exact ball"; }

 private:
  double radius_m_;
  Material material_;
};

int main() {
  TouchStep touch(std::make_shared<BallMethod>(0.03, Material{.stiffness_n_per_m = 500.0}));
  // The scene is turned and moved like any other: X_WS is its pose in the world.
  Pose X_WS = Pose::Identity();
  X_WS.translate(Vec3(0.0, 0.05, 0.0));
  touch.reset({.p_WD = {0.0, 0.1, 0.0}, .X_WS = X_WS});
  TouchOutput felt;
  for (int k = 0; k <= 25; ++k) {
    felt = touch.step({.p_WD = {0.0, 0.1 - 1e-3 * k, 0.0}, .X_WS = X_WS});
    std::printf("y %.3f m: force %.3f N, probe drawn at y %.3f m\n", 0.1 - 1e-3 * k, felt.force_n.y(),
                0.1 - 1e-3 * k + felt.visual_offset_m.y());
  }
  // 5 mm deep at 500 N/m.
  return felt.force_n.isApprox(Vec3(0.0, 2.5, 0.0)) ? 0 : 1;
}
