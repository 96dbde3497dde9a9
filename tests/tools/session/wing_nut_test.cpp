// The wing nut of scenes/wing_nut.toml on its bolt.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "core/tool/penetration_check.h"
#include "core/tool/tool_step.h"
#include "scene/scene_file.h"

namespace hapton {
namespace {

constexpr double kNutTurnRad = 2.0 * std::numbers::pi;
constexpr double kNutPitchM = 0.004;
constexpr double kNutFootM = -0.011;  // foot of the thread: the nut fits into the bolt's thread where it is whole pitches above this
// Axial play: the clearance of 0.2 mm at the steepest flank, where the radius changes by pi / 2 times the height.
constexpr double kNutPlayM = 0.0002 / (0.5 * std::numbers::pi);

class WingNut : public testing::Test {
 protected:
  void SetUp() override {
    const auto scene = load_scene(HAPTON_SOURCE_DIR "/scenes/wing_nut.toml");
    ASSERT_TRUE(scene) << scene.error().what;
    ASSERT_TRUE(scene->tool);
    std::vector<std::shared_ptr<const TriangleMesh>> meshes;
    for (const SceneObject& object : scene->objects) meshes.push_back(object.mesh);
    auto made = ToolStep::make(*scene->tool->mesh, meshes, {.stiffness_n_per_m = 800.0});
    ASSERT_TRUE(made) << made.error().what;
    step_ = std::move(*made);
    check_ = std::make_unique<PenetrationCheck>(step_->tool(), step_->scene());
  }

  static Pose nut_at(double height_m, double angle_rad) {
    Pose X = Pose::Identity();
    X.translation() = Vec3(0.0, height_m, 0.0);
    X.linear() = turn_by(angle_rad * Vec3::UnitY()).toRotationMatrix();
    return X;
  }
  // The angle of the drawn nut; of the angles that differ by whole turns it is the one nearest to near_rad.
  static double angle_of(const Pose& X_WP, double near_rad) {
    const double angle = std::atan2(X_WP.linear()(0, 2), X_WP.linear()(2, 2));
    return angle + kNutTurnRad * std::round((near_rad - angle) / kNutTurnRad);
  }
  // PenetrationCheck decides by exact signs.
  void expect_free(int n) { ASSERT_FALSE(check_->penetrates(step_->proxy().placement())) << n; }

  std::unique_ptr<ToolStep> step_;
  std::unique_ptr<PenetrationCheck> check_;
};

TEST_F(WingNut, ATurnMovesItAlongByThePitch) {
  const double start_m = kNutFootM + 3.0 * kNutPitchM;
  step_->reset({nut_at(start_m, 0.0)});
  double max_torque_nm = 0.0;
  double risen_m = 0.0;
  for (int n = 1; n <= 300; ++n) {
    const double angle = kNutTurnRad * n / 300.0;
    const double hand_m = start_m + kNutPitchM * angle / kNutTurnRad - 0.001;  // the hand lags behind: the thread must lift the nut
    const ToolOutput out = step_->step({nut_at(hand_m, angle)});
    ASSERT_FALSE(out.proxy.is_blocked);
    const double turned = angle_of(out.X_WP, angle);
    ASSERT_NEAR(turned, angle, 0.1) << n;
    risen_m = out.X_WP.translation().y() - start_m;
    ASSERT_NEAR(risen_m, kNutPitchM * turned / kNutTurnRad, kNutPlayM + 2e-5) << n;
    max_torque_nm = std::max(max_torque_nm, std::abs(out.torque_nm.y()));
    if (n % 20 == 0) expect_free(n);
  }
  EXPECT_NEAR(risen_m, kNutPitchM, kNutPlayM + 1e-4);
  EXPECT_GT(max_torque_nm, 1e-4) << "the thread resists by the torque that lifts it";
}

}  // namespace
}  // namespace hapton
