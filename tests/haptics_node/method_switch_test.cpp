// Method and rate change in contact, with a stationary device and a sliding one, with friction, on a box and on a faceted sphere.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <tuple>

#include "core/geometry/mesh_shapes.h"
#include "haptic_step/haptics_step.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kStiffness = 1000.0;
constexpr double kDepth = 0.002;
constexpr double kRadius = 0.05;
constexpr double kSpeed = 0.05;  // m/s, along the surface
constexpr double kOffset = 0.0005 * 0.0254;

struct Shape {
  const char* name;
  std::shared_ptr<const TriangleMesh> mesh;
  double facet_angle;                          // between neighbouring facets, rad
  std::function<Vec3(double s, double h)> at;  // after s metres along the surface, h above it
};

const Shape& shape_of(const std::string& name) {
  static const Shape kBox = {"box", made::shared(made::box(Vec3::Constant(-kRadius), Vec3::Constant(kRadius))), 0.0,
                             [](double s, double h) { return Vec3(0.003 + s, 0.007 + 0.4 * s, kRadius + h); }};
  static const Shape kSphere = {"sphere", made::shared(make_icosphere(kRadius, 4)), 0.08, [](double s, double h) {
                                  const double a = 0.3 + s / kRadius;
                                  return Vec3((kRadius + h) * Vec3(std::cos(a) * 0.8, std::sin(a), std::cos(a) * 0.6));
                                }};
  return name == "box" ? kBox : kSphere;
}

// Static and dynamic friction are equal: otherwise a release would be a force jump of the method itself.
TouchScene scene_of(const Shape& shape, double friction, double damping = 0.0) {
  return {.objects = {
              {shape.mesh,
               {.stiffness_n_per_m = kStiffness, .damping_ns_per_m = damping, .friction_static = friction, .friction_dynamic = friction}}}};
}

std::unique_ptr<TouchStep> make_touch(const std::string& name, const TouchScene& scene) {
  return std::make_unique<TouchStep>(*make_method({.name = name}, scene));
}

// A hand that comes down obliquely onto the surface, with the forces on it.
class Hand {
 public:
  Hand(const Shape& shape, const std::string& method, const TouchScene& scene) : shape_(shape), step_(make_touch(method, scene), kOffset) {}

  void press() {
    go(0.0, 0.001);
    for (int i = 1; i <= 60; ++i) go(kSpeed * 1e-3 * i, 0.001 - (0.001 + kDepth) * i / 60.0);
    largest_change_n_ = 0.0;
    largest_excess_n_ = -1.0;
  }

  // Continues for this many samples of this duration, stationary or sliding.
  void go_on(int samples, double dt_s, bool slides) {
    dt_s_ = dt_s;
    for (int i = 0; i < samples; ++i) go(s_ + (slides ? kSpeed * dt_s : 0.0), -kDepth);
  }

  void lift() { go(s_, 0.001); }

  HapticsStep& step() { return step_; }
  const ForceCommand& output() const { return output_; }
  // The part of the largest change of force since press() that exceeds twice the stiffness times the motion.
  double largest_excess_n() const { return largest_excess_n_; }
  double largest_change_n() const { return largest_change_n_; }
  double largest_force_n() const { return step_.counts().max_force_n; }

 private:
  void go(double s, double h) {
    const Vec3 p_WD = shape_.at(s, h);
    const Vec3 before_n = output_.force_n;
    time_ns_ += std::llround(1e9 * dt_s_);
    step_.offer({.sample = ++sample_, .sample_time_ns = time_ns_, .p_WD = p_WD});
    output_ = step_.reply();
    const double change_n = (output_.force_n - before_n).norm();
    largest_change_n_ = std::max(largest_change_n_, change_n);
    largest_excess_n_ = std::max(largest_excess_n_, change_n - 2.0 * kStiffness * (p_WD - p_WD_).norm());
    p_WD_ = p_WD;
    s_ = s;
  }

  const Shape& shape_;
  HapticsStep step_;
  ForceCommand output_;
  Vec3 p_WD_ = Vec3::Zero();
  double s_ = 0.0;
  double dt_s_ = 1e-3;
  std::int64_t time_ns_ = 5'000'000'000;
  std::uint64_t sample_ = 100;
  double largest_change_n_ = 0.0;
  double largest_excess_n_ = 0.0;
};

// The force jump that a method makes between two facets; with sweep, whose proxy lags behind, also while the device is at rest.
double facet_jump_n(const Shape& shape, const Hand& hand) { return shape.facet_angle * hand.largest_force_n(); }

using Pair = std::tuple<const char*, const char*, const char*>;

class MethodSwitch : public ::testing::TestWithParam<Pair> {
 protected:
  const Shape& shape_ = shape_of(std::get<0>(GetParam()));
  std::string from_ = std::get<1>(GetParam());
  std::string to_ = std::get<2>(GetParam());
};

TEST_P(MethodSwitch, InContactChangesTheForceByNoMoreThanMotionAndFadeExplain) {
  const TouchScene scene = scene_of(shape_, 0.5);
  for (const bool slides : {false, true}) {
    for (const double dt_s : {2.5e-4, 4e-3}) {
      Hand hand(shape_, from_, scene);
      hand.press();
      hand.go_on(20, dt_s, slides);
      ASSERT_TRUE(hand.output().contact);
      hand.step().replace(make_touch(to_, scene));
      hand.go_on(static_cast<int>(0.15 / dt_s), dt_s, slides);
      const double fade_n = 2.0 * hand.largest_force_n() * dt_s / ForceFade::kInContactS;
      EXPECT_LE(hand.largest_excess_n(), fade_n + facet_jump_n(shape_, hand) + 1e-9)
          << (slides ? "sliding, " : "resting, ") << dt_s << " s";

      EXPECT_TRUE(hand.output().contact);
      if (to_ == "sweep") continue;  // its contact point lags behind
      Hand other(shape_, to_, scene);
      other.press();
      other.go_on(20 + static_cast<int>(0.15 / dt_s), dt_s, slides);
      EXPECT_NEAR(hand.output().force_n.norm(), other.output().force_n.norm(), 0.12 * other.output().force_n.norm())
          << "only the new method is left, but at rest the friction of the old one is gone";
    }
  }
}

TEST_P(MethodSwitch, InContactAndBackAgainBeforeTheFadeIsOverHasNoForceDiscontinuity) {
  const TouchScene scene = scene_of(shape_, 0.5);
  Hand hand(shape_, from_, scene);
  hand.press();
  for (int i = 0; i < 8; ++i) {
    hand.step().replace(make_touch(i % 2 == 0 ? to_ : from_, scene));
    hand.go_on(10, 1e-3, true);
  }
  EXPECT_LE(hand.largest_excess_n(), 0.02 * hand.largest_force_n() + facet_jump_n(shape_, hand) + 1e-9);
  EXPECT_LT(hand.largest_force_n(), 2.0 * kStiffness * kDepth);
}

TEST_P(MethodSwitch, WithDampingDoesNotTakeTheDistanceToTheSurfaceForAMotion) {
  const TouchScene scene = scene_of(shape_, 0.0, 5.0);
  Hand hand(shape_, from_, scene);
  hand.press();
  hand.go_on(20, 1e-3, false);
  hand.step().replace(make_touch(to_, scene));
  hand.go_on(150, 1e-3, false);
  EXPECT_LT(hand.largest_force_n(), 1.2 * kStiffness * kDepth + 5.0 * 0.1);
  EXPECT_LE(hand.largest_excess_n(), 0.02 * hand.largest_force_n() + 5.0 * 0.1);
}

TEST_P(MethodSwitch, WhenTheHandLeavesTheOldForceIsGoneInTenMilliseconds) {
  const TouchScene scene = scene_of(shape_, 0.5);
  Hand hand(shape_, from_, scene);
  hand.press();
  hand.step().replace(make_touch(to_, scene));
  const double felt_n = hand.output().force_n.norm();
  hand.lift();
  double last_n = hand.output().force_n.norm();
  EXPECT_LE(last_n, 0.9 * felt_n + 1e-12);
  for (int i = 0; i < 10; ++i) {
    hand.lift();
    EXPECT_LE(hand.output().force_n.norm(), last_n);
    EXPECT_EQ(hand.output().contact, !hand.output().force_n.isZero(0.0));
    last_n = hand.output().force_n.norm();
  }
  EXPECT_EQ(last_n, 0.0);
}

constexpr std::array kNames = {"proxy", "smooth", "sweep", "reference"};

INSTANTIATE_TEST_SUITE_P(Pairs, MethodSwitch,
                         ::testing::Combine(::testing::Values("box", "sphere"), ::testing::ValuesIn(kNames), ::testing::ValuesIn(kNames)),
                         [](const auto& test) {
                           return std::string(std::get<0>(test.param)) + "_" + std::get<1>(test.param) + "_to_" + std::get<2>(test.param);
                         });

class RateSwitch : public ::testing::TestWithParam<std::tuple<const char*, const char*>> {};

TEST_P(RateSwitch, InContactDoesNotChangeTheForce) {
  const Shape& shape = shape_of(std::get<0>(GetParam()));
  const std::string name = std::get<1>(GetParam());
  const TouchScene scene = scene_of(shape, 0.5);
  for (const bool slides : {false, true}) {
    Hand hand(shape, name, scene);
    hand.press();
    hand.go_on(50, 1e-3, slides);
    const Vec3 before_n = hand.output().force_n;
    for (const double dt_s : {2.5e-4, 4e-3, 1e-4, 1e-3}) hand.go_on(20, dt_s, slides);
    EXPECT_TRUE(hand.output().contact);
    EXPECT_LE(hand.largest_excess_n(), facet_jump_n(shape, hand) + 1e-6) << (slides ? "sliding" : "resting");
    if (!slides && name != "sweep") {
      EXPECT_LE((hand.output().force_n - before_n).norm(), 1e-6);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, RateSwitch, ::testing::Combine(::testing::Values("box", "sphere"), ::testing::ValuesIn(kNames)),
                         [](const auto& test) { return std::string(std::get<0>(test.param)) + "_" + std::get<1>(test.param); });

TEST(FrictionSwitchedOff, TurnsTheForceSlowly) {
  const Shape& box = shape_of("box");
  const TouchScene scene = scene_of(box, 0.5);
  Hand hand(box, "proxy", scene);
  hand.press();
  hand.go_on(20, 1e-3, false);
  const double friction_n = Vec3(hand.output().force_n[0], hand.output().force_n[1], 0.0).norm();
  EXPECT_GT(friction_n, 0.3 * kStiffness * kDepth);
  hand.step().replace(make_touch("smooth", scene));
  hand.go_on(50, 1e-3, false);
  EXPECT_NEAR(Vec3(hand.output().force_n[0], hand.output().force_n[1], 0.0).norm(), 0.5 * friction_n, 0.01);
  EXPECT_LE(hand.largest_change_n(), 0.0101 * friction_n);
  hand.go_on(60, 1e-3, false);
  EXPECT_NEAR((hand.output().force_n - Vec3(0, 0, kStiffness * kDepth)).norm(), 0.0, 1e-6);
}

}  // namespace
}  // namespace hapton
