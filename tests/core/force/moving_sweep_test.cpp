#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <tuple>
#include <utility>

#include "tests/core/force/moving_plates.h"

namespace hapton {
namespace {

// A plate that comes from one side upon a hand that holds still, at the largest speed; plates that stand still lie beside it.
struct PlateSweep {
  double rate_hz;
  double radius_m;
  double side;  // +1: the plate comes from above and pushes down
  std::string name = "proxy";
};

class MovingSweep : public testing::TestWithParam<std::tuple<double, double, double, std::string>> {
 protected:
  PlateSweep sweep() const { return {std::get<0>(GetParam()), std::get<1>(GetParam()), std::get<2>(GetParam()), std::get<3>(GetParam())}; }
  MethodSettings settings() const { return {.name = sweep().name, .probe_radius_m = sweep().radius_m}; }
};

// In every step the force is stiffness times the distance by which the face has passed the hand, even long after the whole plate has passed
// it.
TEST_P(MovingSweep, PushesTheHandAheadAndNeverPassesIt) {
  const auto [rate_hz, radius, side, name] = sweep();
  const double duration_s = 0.2;
  TouchScene scene;
  // 4 mm thick; its leading face starts 10 mm before the hand and ends 40 mm behind it.
  const auto motion = shift_motion(Vec3::Zero(), {0, 0, -side * kPlateSpeed * duration_s}, duration_s);
  scene.objects.push_back(plate_object({-0.06, -0.06, side > 0 ? 0.010 : -0.014}, {0.06, 0.06, side > 0 ? 0.014 : -0.010}, motion));
  scene.objects.push_back(plate_object({0.08, -0.06, -0.01}, {0.1, 0.06, 0.01}));  // stands still, out of reach
  const auto method = make_method_for(scene, settings());
  ASSERT_TRUE(method);
  const Vec3 hand(0.0123, -0.0045, 0.0);
  method->reset(hand);
  double last_n = 0.0;
  for (int i = 0; i <= static_cast<int>(duration_s * rate_hz); ++i) {
    const double time_s = i / rate_hz;
    const MethodOutput felt = method->step({.p_SD = hand, .dt_s = 1.0 / rate_hz, .time_s = time_s});
    const double passed_m = kPlateSpeed * time_s - 0.010 + radius;
    const Vec3 expected(0, 0, -side * kPlateStiffness * std::max(0.0, passed_m));
    ASSERT_LT((felt.force_n - expected).norm(), 2e-6 * kPlateStiffness * 0.1 + 1e-3) << "at " << time_s << " s";
    ASSERT_LE(felt.force_n.norm() - last_n, kPlateStiffness * kPlateSpeed / rate_hz * (1.0 + 1e-6) + 1e-9) << "at " << time_s << " s";
    if (passed_m > 1e-6) {
      ASSERT_TRUE(felt.contact) << "at " << time_s << " s";
      ASSERT_EQ(felt.object, 0);
    }
    last_n = felt.force_n.norm();
  }
  EXPECT_GT(last_n, 39.0);
}

// Plates that stand still lie right behind the moving one and beyond the hand: their surfaces stay closed, and the moving plate is not felt
// through them.
TEST_P(MovingSweep, IsNotFeltThroughPlatesThatStandStill) {
  const auto [rate_hz, radius, side, name] = sweep();
  const double duration_s = 0.24;
  TouchScene scene;
  const auto plate_at = [side](double low, double high, std::shared_ptr<const KeyframeMotion> motion = nullptr) {
    return plate_object({-0.06, -0.06, side > 0 ? low : -high}, {0.06, 0.06, side > 0 ? high : -low}, std::move(motion));
  };
  scene.objects.push_back(plate_at(-0.030, -0.020));  // the floor, 20 mm beyond the hand
  scene.objects.push_back(plate_at(0.010, 0.014, shift_motion(Vec3::Zero(), {0, 0, -side * kPlateSpeed * duration_s}, duration_s)));
  scene.objects.push_back(plate_at(0.0145, 0.020));  // right behind the moving plate at the start
  const auto method = make_method_for(scene, settings());
  ASSERT_TRUE(method);
  const Vec3 hand(0.0123, -0.0045, 0.0);
  method->reset(hand);
  Vec3 last = Vec3::Zero();
  for (int i = 0; i <= static_cast<int>(duration_s * rate_hz); ++i) {
    const double time_s = i / rate_hz;
    const MethodOutput felt = method->step({.p_SD = hand, .dt_s = 1.0 / rate_hz, .time_s = time_s});
    // The probe never enters the floor, whatever comes.
    ASSERT_GE(side * felt.p_SP.z(), -0.020 + radius - 1e-9) << "at " << time_s << " s";
    ASSERT_LE((felt.force_n - last).norm(), kPlateStiffness * kPlateSpeed / rate_hz * (1.0 + 1e-6) + 1e-9) << "at " << time_s << " s";
    const double pushed_m = std::max(0.0, kPlateSpeed * time_s - 0.010 + radius);
    const double gap_m = 0.020 - radius;
    ASSERT_NEAR(-side * felt.force_n.z(), kPlateStiffness * std::min(pushed_m, gap_m), 1e-3) << "at " << time_s << " s";
    last = felt.force_n;
  }
}

// A lid on a hinge comes upon the hand from above, until its motion ends; the hand is 60 mm from the hinge.
TEST_P(MovingSweep, ALidThatClosesPushesTheHandAhead) {
  const auto [rate_hz, radius, side, name] = sweep();
  const double duration_s = 0.5;
  const double angle = kPlateSpeed * duration_s / 0.08;  // the lid's edge is 80 mm from the hinge
  TouchScene scene;
  scene.objects.push_back(
      plate_object({-0.08, -0.05, -0.002}, {0.0, 0.05, 0.002}, turn_motion(Vec3::Zero(), Vec3::UnitY(), -side * angle, duration_s)));
  const auto method = make_method_for(scene, settings());
  ASSERT_TRUE(method);
  const Vec3 hand(-0.06, 0.011, -side * 0.015);
  method->reset(hand);
  double last_n = 0.0;
  bool was_touched = false;
  for (int i = 0; i <= static_cast<int>(duration_s * rate_hz); ++i) {
    const double time_s = i / rate_hz;
    const MethodOutput felt = method->step({.p_SD = hand, .dt_s = 1.0 / rate_hz, .time_s = time_s});
    const Pose X_SO = scene.objects[0].motion->pose_at(time_s);
    const Vec3 in_lid = X_SO.inverse(Eigen::Isometry) * hand;
    const double passed_m = side * in_lid.z() + 0.002 + radius;
    ASSERT_NEAR(felt.force_n.norm(), kPlateStiffness * std::max(0.0, passed_m), 1e-3) << "at " << time_s << " s";
    ASSERT_LE(felt.force_n.norm() - last_n, kPlateStiffness * kPlateSpeed / rate_hz * (1.0 + 1e-3)) << "at " << time_s << " s";
    if (passed_m > 1e-6) {
      const Vec3 normal = X_SO.linear() * Vec3(0, 0, -side);
      ASSERT_GT(felt.force_n.normalized().dot(normal), 1.0 - 1e-9) << "at " << time_s << " s";
    }
    was_touched = was_touched || passed_m > 0.01;
    last_n = felt.force_n.norm();
  }
  EXPECT_TRUE(was_touched);
}

INSTANTIATE_TEST_SUITE_P(Rates, MovingSweep,
                         testing::Combine(testing::Values(250.0, 1000.0, 4000.0), testing::Values(0.0, 0.003), testing::Values(1.0, -1.0),
                                          testing::Values("proxy")),
                         [](const auto& given) {
                           return std::to_string(static_cast<int>(std::get<0>(given.param))) + "_Hz_" +
                                  (std::get<1>(given.param) > 0 ? "sphere" : "point") +
                                  (std::get<2>(given.param) > 0 ? "_from_above_" : "_from_below_") + std::get<3>(given.param);
                         });
INSTANTIATE_TEST_SUITE_P(Reference, MovingSweep,
                         testing::Combine(testing::Values(250.0), testing::Values(0.0, 0.003), testing::Values(1.0, -1.0),
                                          testing::Values("reference")),
                         [](const auto& given) {
                           return std::string(std::get<1>(given.param) > 0 ? "sphere" : "point") +
                                  (std::get<2>(given.param) > 0 ? "_from_above" : "_from_below");
                         });

}  // namespace
}  // namespace hapton
