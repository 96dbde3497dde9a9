// Damping at the contacts of a rigid tool, over steps of ToolStep and HeldTool: what the hand feels when the scene, the samples or the
// contacts change suddenly or are interrupted.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "core/geometry/mesh_shapes.h"
#include "core/tool/held_tool.h"

namespace hapton {
namespace {

constexpr double kTickS = 1e-3;
constexpr double kDampedStiffness = 1000.0;  // N/m, of the coupling
constexpr DampingCoefficients kSyrup = {.normal_ns_per_m = 3.0, .along_ns_per_m = 5.0};

std::unique_ptr<ToolStep> make_step_with_damping(const std::vector<TriangleMesh>& scene, const std::vector<DampingCoefficients>& damping,
                                                 const std::vector<CoulombFriction>& friction = {}, const std::vector<int>& parts = {}) {
  std::vector<std::shared_ptr<const TriangleMesh>> meshes;
  for (const TriangleMesh& mesh : scene) meshes.push_back(std::make_shared<TriangleMesh>(mesh));
  auto made =
      ToolStep::make(make_box({0.02, 0.02, 0.02}), std::move(meshes), {.stiffness_n_per_m = kDampedStiffness}, friction, nullptr, parts);
  EXPECT_TRUE(made) << made.error().what;
  EXPECT_TRUE((*made)->damp(damping));
  return std::move(*made);
}

ToolInput damping_input(const Vec3& p, const Vec3& turn = Vec3::Zero()) {
  ToolInput input;
  input.X_WD.translation() = p;
  input.X_WD.linear() = turn_by(turn).toRotationMatrix();
  input.dt_s = kTickS;
  return input;
}

Vec3 pressing_path(int n) { return {0.003, 0.004, 0.03 - 0.0001 * std::min(n, 220)}; }

// A tool with damping and one without get the same input, in whole steps or in two tasks; `added_by_damping` returns the difference.
class ToolPair {
 public:
  virtual ~ToolPair() = default;
  virtual ToolOutput added_by_damping(const ToolInput& input) = 0;
};

ToolOutput difference(const ToolOutput& damped, const ToolOutput& plain) {
  ToolOutput out = plain;
  out.force_n = damped.force_n - plain.force_n;
  out.torque_nm = damped.torque_nm - plain.torque_nm;
  return out;
}

class WholeStepPair : public ToolPair {
 public:
  WholeStepPair(std::unique_ptr<ToolStep> damped, std::unique_ptr<ToolStep> plain) : damped_(std::move(damped)), plain_(std::move(plain)) {}
  ToolOutput added_by_damping(const ToolInput& input) override {
    if (!std::exchange(has_begun_, true)) {
      damped_->reset(input);
      plain_->reset(input);
    }
    const ToolOutput plain = plain_->step(input);
    return difference(damped_->step(input), plain);
  }

 private:
  std::unique_ptr<ToolStep> damped_;
  std::unique_ptr<ToolStep> plain_;
  bool has_begun_ = false;
};

class HeldToolPair : public ToolPair {
 public:
  HeldToolPair(std::unique_ptr<ToolStep> damped, std::unique_ptr<ToolStep> plain) : damped_(std::move(damped)), plain_(std::move(plain)) {}
  ToolOutput added_by_damping(const ToolInput& input) override { return added_by_damping_at(input, time_ns_ + 1'000'000); }
  ToolOutput added_by_damping_at(const ToolInput& input, std::int64_t time_ns) {
    time_ns_ = time_ns;
    plain_output = plain_.step(input, time_ns);
    const ToolOutput added = difference(damped_.step(input, time_ns), plain_output);
    if (runs_slow_task) {
      damped_.follow();
      plain_.follow();
    }
    return added;
  }
  HeldTool& damped() { return damped_; }
  std::int64_t time_ns() const { return time_ns_; }

  bool runs_slow_task = true;  // after each sample
  ToolOutput plain_output;     // the last output without damping

 private:
  HeldTool damped_;
  HeldTool plain_;
  std::int64_t time_ns_ = 0;
};

std::vector<std::unique_ptr<ToolPair>> make_tool_pairs(const std::vector<TriangleMesh>& scene,
                                                       const std::vector<DampingCoefficients>& damping,
                                                       const std::vector<CoulombFriction>& friction = {},
                                                       const std::vector<int>& parts = {}) {
  std::vector<std::unique_ptr<ToolPair>> pairs;
  const auto damped = [&] { return make_step_with_damping(scene, damping, friction, parts); };
  const auto plain = [&] { return make_step_with_damping(scene, {}, friction, parts); };
  pairs.push_back(std::make_unique<WholeStepPair>(damped(), plain()));
  pairs.push_back(std::make_unique<HeldToolPair>(damped(), plain()));
  return pairs;
}

TEST(ToolDamping, AViewThatTurnsIsNoMotionOfTheHand) {
  for (const auto& pair : make_tool_pairs({make_plane_grid(0.2, 8)}, {kSyrup})) {
    for (int n = 0; n <= 240; ++n) pair->added_by_damping(damping_input(pressing_path(n)));
    ToolInput input = damping_input(pressing_path(240));
    for (int n = 1; n <= 30; ++n) {
      input.X_WS.translation() = Vec3(4e-5 * n, 0.0, -1e-5 * n);
      input.X_WS.linear() = turn_by({0.0, 0.0, 1e-3 * n}).toRotationMatrix();
      const ToolOutput added = pair->added_by_damping(input);
      ASSERT_TRUE(added.contact) << n;
      ASSERT_LT(added.force_n.norm(), 1e-9) << n << ": the hand is at rest";
      ASSERT_LT(added.torque_nm.norm(), 1e-9) << n;
    }
    // The hand's own motion still counts, along the axes of the view.
    ToolOutput added;
    for (int n = 1; n <= 60; ++n) {
      input.X_WD.translation().x() += 4e-5;
      if (n % 2 == 0) input.X_WS.translation().y() += 1e-5;
      added = pair->added_by_damping(input);
    }
    EXPECT_LT((added.force_n - Vec3(-5.0 * 0.04, 0.0, 0.0)).norm(), 1e-6);
  }
}

// After late contacts only the spring force is handed over gradually; the drag follows the hand at once.
TEST(ToolDamping, LateContactsDoNotHoldBackADrag) {
  HeldToolPair pair(make_step_with_damping({make_plane_grid(0.2, 8)}, {kSyrup}), make_step_with_damping({make_plane_grid(0.2, 8)}, {}));
  for (int n = 0; n <= 220; ++n) pair.added_by_damping(damping_input(pressing_path(n)));
  ToolInput input = damping_input(pressing_path(220));
  ToolOutput added;
  for (int n = 0; n < 60; ++n) {
    pair.runs_slow_task = n < 40;
    input.X_WD.translation().x() += 4e-5;
    added = pair.added_by_damping(input);
  }
  EXPECT_NEAR(added.force_n.x(), -5.0 * 0.04, 1e-5);
  pair.runs_slow_task = true;
  for (int n = 0; n < 20; ++n) {
    added = pair.added_by_damping(input);
    if (n < 8) continue;
    ASSERT_LT(added.force_n.norm(), 1e-9) << n << ": the hand is at rest";
    ASSERT_LT(added.torque_nm.norm(), 1e-9) << n;
  }
}

TEST(ToolDamping, AGapOfSamplesIsNoMotion) {
  for (const std::int64_t gap_ns : {100'000'000LL, -200'000'000LL}) {
    HeldToolPair pair(make_step_with_damping({make_plane_grid(0.2, 8)}, {kSyrup}), make_step_with_damping({make_plane_grid(0.2, 8)}, {}));
    for (int n = 0; n <= 220; ++n) pair.added_by_damping(damping_input(pressing_path(n)));
    ToolInput input = damping_input(pressing_path(220));
    const auto slide = [&] {
      ToolOutput added;
      for (int n = 0; n < 60; ++n) {
        input.X_WD.translation().x() += 4e-5;
        added = pair.added_by_damping(input);
      }
      return added;
    };
    EXPECT_NEAR(slide().force_n.x(), -5.0 * 0.04, 1e-5);
    input.X_WD.translation().x() += 0.005;
    EXPECT_EQ(pair.added_by_damping_at(input, pair.time_ns() + gap_ns).force_n, Vec3(Vec3::Zero())) << gap_ns;
    for (int n = 0; n < 10; ++n) ASSERT_EQ(pair.added_by_damping(input).force_n, Vec3(Vec3::Zero())) << n;
    EXPECT_NEAR(slide().force_n.x(), -5.0 * 0.04, 1e-4);
    pair.damped().forget_motion();
    input.X_WD.translation().x() += 0.005;
    EXPECT_EQ(pair.added_by_damping(input).force_n, Vec3(Vec3::Zero())) << "another session, at once";
  }
}

TriangleMesh half_plane(double from_x, int cells) {
  TriangleMesh plane = make_plane_grid(0.06, cells);
  for (Vec3& v : plane.vertices) v.x() += from_x + 0.03;
  return plane;
}

// Where the search for contacts finds more than it can handle, the tool stays in place without known contacts, and the spring holds it.
TEST(ToolDamping, TheDragDecaysWhereContactsAreNotKnown) {
  const auto step = make_step_with_damping({half_plane(-0.06, 4), half_plane(0.0, 450)}, {kSyrup, kSyrup});
  const auto drag_n = [&](const ToolInput& input) {
    const ToolOutput out = step->step(input);
    EXPECT_TRUE(out.contact);
    return Vec3(out.force_n - kDampedStiffness * (out.X_WP.translation() - input.X_WD.translation())).x();
  };
  step->reset(damping_input({-0.011, 0.004, 0.03}));
  for (int n = 0; n <= 320; ++n) step->step(damping_input({-0.011, 0.004, 0.03 - 0.0001 * std::min(n, 220)}));
  double last_n = 0.0;
  int unknown_samples = 0;
  for (int n = 1; n < 120 && unknown_samples < 8; ++n) {
    const double current_n = drag_n(damping_input({-0.011 + 2e-4 * n, 0.004, 0.008}));
    if (step->proxy().contacts().empty()) {
      ++unknown_samples;
      ASSERT_NEAR(current_n, last_n / (1.0 + kTickS / ContactDamping::kSmoothS), 1e-9) << n;
    }
    last_n = current_n;
  }
  EXPECT_EQ(unknown_samples, 8) << "the contacts are known nearly everywhere: the test needs more triangles";
  EXPECT_LT(last_n, -0.2);
}

TEST(ToolDamping, EndsWithContact) {
  for (const auto& pair : make_tool_pairs({make_plane_grid(0.2, 8)}, {kSyrup})) {
    for (int n = 0; n <= 220; ++n) pair->added_by_damping(damping_input(pressing_path(n)));
    ToolOutput added;
    for (int n = 0; n < 60; ++n) added = pair->added_by_damping(damping_input(pressing_path(220) + Vec3(4e-5 * n, 0.0, 0.0)));
    EXPECT_LT(added.force_n.x(), -0.19);
    int free_samples = 0;
    for (int n = 0; n < 20; ++n) {
      added = pair->added_by_damping(damping_input(pressing_path(220) + Vec3(4e-5 * n, 0.0, 4e-4 * n)));
      if (added.contact) continue;
      ++free_samples;
      ASSERT_EQ(added.force_n, Vec3(Vec3::Zero())) << n;
    }
    EXPECT_GT(free_samples, 10);
  }
}

// A plate turns under a box at rest, 30 mm from the plate's axis. It drags the box along, as if the box moved the other way round.
TEST(ToolDamping, APartThatTurnsPassesTheToolWithItsSurface) {
  constexpr double kRateRadPerS = 1.5;
  for (const auto& pair : make_tool_pairs({make_plane_grid(0.2, 1)}, {kSyrup}, {}, {1})) {
    std::vector<Pose> parts = {Pose::Identity()};
    const Vec3 from_axis(0.03, 0.0, 0.0);
    ToolOutput added;
    for (int n = 0; n <= 400; ++n) {
      ToolInput input = damping_input(from_axis + Vec3(0.0, 0.0, 0.03 - 0.0001 * std::min(n, 220)));
      parts[0].linear() = turn_by({0.0, 0.0, kRateRadPerS * kTickS * std::max(0, n - 350)}).toRotationMatrix();
      input.X_SO = parts;
      added = pair->added_by_damping(input);
    }
    EXPECT_NEAR(added.force_n.y(), 5.0 * kRateRadPerS * from_axis.x(), 1e-3);
    EXPECT_NEAR(added.force_n.x(), 0.0, 5e-3);
    EXPECT_GT(added.torque_nm.z(), 1e-5) << "and turns it along";
  }
}

// The tool first sticks while the hand stretches the coupling, and then slides; the hand feels the viscosity all the time.
TEST(ToolDamping, ActsBesideFriction) {
  const std::vector<CoulombFriction> friction = {{.friction_static = 0.5, .friction_dynamic = 0.4}};
  for (const auto& pair : make_tool_pairs({make_plane_grid(0.2, 8)}, {kSyrup}, friction)) {
    for (int n = 0; n <= 420; ++n) pair->added_by_damping(damping_input(pressing_path(n)));
    for (int n = 1; n <= 120; ++n) {
      const ToolOutput added = pair->added_by_damping(damping_input(pressing_path(420) + Vec3(4e-5 * n, 0.0, 0.0)));
      if (n < 10) continue;
      ASSERT_NEAR(added.force_n.x(), -5.0 * 0.04, 1e-4) << n;
      ASSERT_NEAR(added.force_n.y(), 0.0, 1e-4) << n;
    }
  }
}

TEST(ToolDamping, ImpossibleDampingIsRejected) {
  const auto step = make_step_with_damping({make_plane_grid(0.2, 2)}, {});
  for (const DampingCoefficients impossible : {DampingCoefficients{-1.0, 0.0}, {0.0, -1.0}, {std::nan(""), 0.0}, {0.0, HUGE_VAL}}) {
    EXPECT_FALSE(step->damp({impossible}));
  }
}

}  // namespace
}  // namespace hapton
