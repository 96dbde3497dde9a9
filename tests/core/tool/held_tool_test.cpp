#include "core/tool/held_tool.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr std::int64_t kTickNs = 1'000'000;

std::unique_ptr<ToolStep> make_held_step(const TriangleMesh& tool, const TriangleMesh& scene) {
  auto made = ToolStep::make(tool, {std::make_shared<TriangleMesh>(scene)}, {});
  EXPECT_TRUE(made) << made.error().what;
  return std::move(*made);
}

ToolInput input_at(const Vec3& p, const Vec3& turn = Vec3::Zero()) {
  ToolInput input;
  input.X_WD.translation() = p;
  input.X_WD.linear() = turn_by(turn).toRotationMatrix();
  return input;
}

// A box that is pressed on a bumpy ball, slid and turned over it, at up to 100 mm/s and 1 rad/s.
ToolInput sliding_input(int n) {
  const double t = 1e-3 * n;
  const double depth = std::min(t * 0.05, 0.02);
  return input_at({0.012 * std::sin(7.0 * t), 0.01 * std::sin(5.0 * t), 0.075 - depth},
                  {0.2 * std::sin(4.0 * t), 0.1 * std::sin(3.0 * t), t});
}

struct Difference {
  double force_n = 0.0;  // largest difference
  double torque_nm = 0.0;
  double largest_n = 0.0;  // largest force of the whole step
  int samples_in_contact = 0;
};

// Compares the fast task with the whole step at each sample; the slow task runs once in `slow_period` samples.
Difference compare_with_whole_step(int slow_period) {
  const TriangleMesh tool = make_box({0.02, 0.02, 0.02}, 3);
  const TriangleMesh scene = make_bumpy_sphere(0.05, 0.05, 5000, 1);
  const auto whole = make_held_step(tool, scene);
  HeldTool held(make_held_step(tool, scene));
  Difference difference;
  for (int n = 0; n < 2500; ++n) {
    const ToolInput input = sliding_input(n);
    if (n == 0) whole->reset(input);
    const ToolOutput expected = whole->step(input);
    if (n % slow_period == 0) {
      held.step(input, n * kTickNs);  // the sample that the slow task takes up
      held.follow();
    }
    const ToolOutput felt = held.step(input, n * kTickNs);
    if (n < 5) continue;
    difference.force_n = std::max(difference.force_n, (felt.force_n - expected.force_n).norm());
    difference.torque_nm = std::max(difference.torque_nm, (felt.torque_nm - expected.torque_nm).norm());
    difference.largest_n = std::max(difference.largest_n, expected.force_n.norm());
    difference.samples_in_contact += felt.contact ? 1 : 0;
  }
  return difference;
}

// On a fine mesh a flat face has far more contacts than the local set holds. The nearest of them alone would let the tool tilt.
TEST(HeldTool, OnAFineMeshItsForceIsThatOfTheWholeStep) {
  const TriangleMesh tool = make_box({0.02, 0.02, 0.02}, 3);
  for (const int cells : {40, 100}) {  // up to 1,200 vertices below the box
    const TriangleMesh scene = make_plane_grid(0.06, cells);
    const auto whole = make_held_step(tool, scene);
    HeldTool held(make_held_step(tool, scene));
    int samples_in_contact = 0;
    for (int n = 0; n < 300; ++n) {
      const double t = 1e-3 * n;
      const ToolInput input = input_at({0.004 * std::sin(7.0 * t), 0.003 * std::sin(5.0 * t), 0.0115 - std::min(t * 0.05, 0.004)},
                                       {0.05 * std::sin(9.0 * t), 0.04 * std::sin(8.0 * t), 0.5 * t});
      if (n == 0) whole->reset(input);
      const ToolOutput expected = whole->step(input);
      if (n % 5 == 0) {
        held.step(input, n * kTickNs);
        held.follow();
      }
      const ToolOutput felt = held.step(input, n * kTickNs);
      if (n < 60) continue;
      EXPECT_LT((felt.force_n - expected.force_n).norm(), 1e-4) << cells << " cells, sample " << n;
      EXPECT_LT((felt.torque_nm - expected.torque_nm).norm(), 1e-5) << cells << " cells, sample " << n;
      EXPECT_GT(held.tool().proxy().last_local_reach(), 2.0 * ToolProxy::kMinLocalReach) << "a shorter one would find as many";
      samples_in_contact += felt.contact ? 1 : 0;
    }
    EXPECT_GT(samples_in_contact, 200);
  }
}

// A fine ball slides and turns in a fine bowl that is 1 % larger: its lower half is near the bowl. Only the nearest contacts are found.
TEST(HeldTool, WhereSurfacesNearlyFitItLooksLessFarAndFeelsTheSame) {
  const TriangleMesh tool = make_icosphere(0.0099, 4);
  const TriangleMesh scene = make_icosphere(0.01, 5);
  const auto whole = make_held_step(tool, scene);
  HeldTool held(make_held_step(tool, scene));
  const double kMinReach = ToolProxy::kMinLocalReach;
  int samples_in_contact = 0;
  for (int n = 0; n < 100; ++n) {
    const double t = 1e-3 * n;
    const double d = std::min(t * 0.05, 0.003);
    const ToolInput input = input_at({d * std::cos(4.0 * t), d * std::sin(4.0 * t), 0.3 * d}, {0.0, 0.0, 0.5 * t});
    if (n == 0) whole->reset(input);
    const ToolOutput expected = whole->step(input);
    held.step(input, n * kTickNs);
    held.follow();
    const ToolOutput felt = held.step(input, n * kTickNs);
    if (n < 20) continue;
    EXPECT_GE(held.tool().proxy().last_local_reach(), kMinReach);
    EXPECT_LE(held.tool().proxy().last_local_reach(), 6.0 * kMinReach) << "sample " << n;  // requested: 15 times kMinReach
    EXPECT_LT((felt.force_n - expected.force_n).norm(), 0.01 * expected.force_n.norm()) << "sample " << n;
    samples_in_contact += felt.contact ? 1 : 0;
  }
  EXPECT_EQ(samples_in_contact, 80);
}

TEST(HeldTool, FeelsWhatTheWholeStepFeels) {
  const Difference at_each_sample = compare_with_whole_step(1);
  EXPECT_GT(at_each_sample.samples_in_contact, 1000);
  EXPECT_GT(at_each_sample.largest_n, 5.0);
  EXPECT_LT(at_each_sample.force_n, 2e-3 * at_each_sample.largest_n);
  EXPECT_LT(at_each_sample.torque_nm, 2e-3 * at_each_sample.largest_n * 0.02);
  // The slow task runs only every 5 ms; until it runs again, the fast task uses the surface near the pose of its last run.
  const Difference at_each_fifth = compare_with_whole_step(5);
  EXPECT_LT(at_each_fifth.force_n, 0.1 * at_each_fifth.largest_n);
}

TEST(HeldTool, FreeSpaceGivesNothingAtAll) {
  HeldTool held(make_held_step(make_box({0.02, 0.02, 0.02}), make_plane_grid(0.2, 8)));
  for (int n = 0; n < 100; ++n) {
    const ToolOutput out = held.step(input_at({0.0001 * n, 0.0, 0.03}, {0.01 * n, 0.02 * n, 0.0}), n * kTickNs);
    held.follow();
    ASSERT_EQ(out.force_n, Vec3(Vec3::Zero()));
    ASSERT_EQ(out.torque_nm, Vec3(Vec3::Zero()));
    ASSERT_FALSE(out.contact);
  }
}

TEST(HeldTool, GivesNoForceBeforeItKnowsAndWhereItOverlaps) {
  HeldTool held(make_held_step(make_box({0.02, 0.02, 0.02}), make_plane_grid(0.2, 8)));
  ToolOutput out = held.step(input_at({0.0, 0.0, 0.005}), 0);
  EXPECT_FALSE(out.proxy.is_blocked) << "not known yet";
  EXPECT_FALSE(held.is_known());
  EXPECT_EQ(out.force_n, Vec3(Vec3::Zero()));
  EXPECT_TRUE(held.follow());
  EXPECT_FALSE(held.follow()) << "there is nothing new";
  out = held.step(input_at({0.0, 0.0, 0.005}), kTickNs);
  EXPECT_TRUE(out.proxy.is_blocked);
  EXPECT_TRUE(held.is_known());
  EXPECT_EQ(out.force_n, Vec3(Vec3::Zero()));
  // The tool leaves the plane and comes back: now the plane is felt.
  for (int n = 0; n <= 300; ++n) {
    out = held.step(input_at({0.0, 0.0, n < 150 ? 0.005 + 1e-4 * n : 0.035 - 1e-4 * n}), (2 + n) * kTickNs);
    held.follow();
  }
  EXPECT_FALSE(out.proxy.is_blocked);
  EXPECT_NEAR(out.force_n.z(), 5.0, 0.2);
}

TEST(HeldTool, TheForceFadesWhereTheSlowTaskStalls) {
  HeldTool held(make_held_step(make_box({0.02, 0.02, 0.02}), make_plane_grid(0.2, 8)));
  std::int64_t now_ns = 0;
  for (int n = 0; n <= 150; ++n, now_ns += kTickNs) {
    held.step(input_at({0.0, 0.0, 0.02 - 1e-4 * n}), now_ns);
    held.follow();
  }
  const ToolInput pressed = input_at({0.0, 0.0, 0.005});
  const double whole_n = held.step(pressed, now_ns).force_n.z();
  EXPECT_NEAR(whole_n, 5.0, 0.1);
  double before_n = whole_n;
  for (int n = 0; n < 200; ++n, now_ns += kTickNs) {
    const double force_n = held.step(pressed, now_ns).force_n.z();
    ASSERT_LE(force_n, before_n + 1e-12);
    ASSERT_GE(force_n, before_n - 0.02 * whole_n) << "no jump";
    before_n = force_n;
    if (held.age_s() < HeldTool::kFreshS) {
      ASSERT_NEAR(force_n, whole_n, 1e-9);
    }
  }
  EXPECT_EQ(before_n, 0.0);
  held.follow();
  for (int n = 0; n < 25; ++n, now_ns += kTickNs) {
    const double force_n = held.step(pressed, now_ns).force_n.z();
    EXPECT_LE(force_n, before_n + 0.06 * whole_n) << "no jump when the slow task runs again either";
    before_n = force_n;
  }
  EXPECT_NEAR(before_n, whole_n, 0.1);
}

// The hand moves on into a plate that the slow task has not found yet: the tool is drawn above the plate.
TEST(HeldTool, ThePictureShowsTheToolWhereItIsKnownToBeFree) {
  const TriangleMesh tool = make_box({0.02, 0.02, 0.02}, 2);
  HeldTool held(make_held_step(tool, make_box({0.1, 0.1, 0.02}, 4)));
  std::int64_t now_ns = 0;
  const auto step = [&](double height_m) { return held.step(input_at({0, 0, 0.02 + height_m}), now_ns += kTickNs); };
  for (int n = 0; n < 5; ++n) {
    step(0.002);
    held.follow();
  }
  EXPECT_EQ(held.lateness().faded, 0U);
  for (int n = 0; n < 100; ++n) {
    const ToolOutput felt = step(0.002 - 1e-4 * n);
    if (n <= 20) continue;  // twice kLateS has passed, and the hand has moved 2 mm
    EXPECT_GT(felt.X_WP.translation().z(), 0.02) << n;
  }
  EXPECT_GT(held.lateness().faded, 45U);
  EXPECT_NEAR(held.lateness().longest_s, 0.1, 0.002);
  held.follow();
  EXPECT_NEAR(step(-0.0079).X_WP.translation().z(), 0.02, 1e-4) << "on the plate";
  const auto before = held.lateness();
  now_ns += 10'000'000'000;
  step(-0.0079);
  step(-0.0079);
  EXPECT_EQ(held.lateness().samples, before.samples) << "a gap between samples does not count as late contacts";
  held.follow();
  step(-0.0079);
  EXPECT_EQ(held.lateness().samples, before.samples + 1);
  EXPECT_EQ(held.lateness().faded, before.faded);
}

TEST(HeldTool, BeginningAnewPutsTheToolWhereTheDeviceIs) {
  HeldTool held(make_held_step(make_box({0.02, 0.02, 0.02}), make_plane_grid(0.2, 8)));
  for (int n = 0; n <= 150; ++n) {
    held.step(input_at({0.0, 0.0, 0.02 - 1e-4 * n}), n * kTickNs);
    held.follow();
  }
  held.begin_anew();
  EXPECT_EQ(held.step(input_at({0.0, 0.0, 0.03}), 200 * kTickNs).force_n, Vec3(Vec3::Zero())) << "the contacts that were known are dropped";
  held.follow();
  const ToolOutput out = held.step(input_at({0.0, 0.0, 0.03}), 201 * kTickNs);
  EXPECT_FALSE(out.contact);
  EXPECT_FALSE(out.proxy.is_blocked);
}

// Two fine faces that are flush, with more pairs of features than are considered: the proxy cannot move. It must not hold the hand
// forever.
TEST(HeldTool, WhereTooManyPairsAreNearTheForceFades) {
  const TriangleMesh tool = make_box({0.02, 0.02, 0.02}, 36);
  HeldTool held(make_held_step(tool, make_plane_grid(0.02, 36)));
  int n = 0;
  const auto step_at = [&](double z) {
    const ToolOutput out = held.step(input_at({0.0, 0.0, z}), (n += 4) * kTickNs);
    held.follow();
    return out.force_n.norm();
  };
  for (double z = 0.0102; z > 0.00995; z -= 2e-5) step_at(z);
  double largest_n = 0.0;
  for (double z = 0.01; z < 0.03; z += 2e-3) largest_n = std::max(largest_n, step_at(z));
  EXPECT_GT(largest_n, 0.5) << "it was not held: the test needs more triangles";
  double before_n = step_at(0.03);
  for (int k = 0; k < 45; ++k) {
    const double force_n = step_at(0.03);
    EXPECT_LT(std::abs(force_n - before_n), 1.5) << k << ": it fades in a tenth of a second";
    before_n = force_n;
  }
  EXPECT_EQ(before_n, 0.0);
  // The proxy is at the hand again: a motion down to the surface is felt at the hand, not where the proxy was before.
  const Vec3 at_hand = held.tool().to_local(input_at({0.0, 0.0, 0.03})).position;
  EXPECT_LT((held.tool().proxy().placement().position - at_hand).norm(), 1e-9);
}

// A long box on a sheet cannot tilt in either direction. When the stylus has made half a turn, the shortest turn back reverses.
TEST(HeldTool, TheTorqueReversesAtHalfATurnWithoutAJump) {
  const TriangleMesh box = make_box({0.2, 0.01, 0.01});
  const TriangleMesh sheet = make_plane_grid(0.5, 8);
  const ToolCoupling soft{.stiffness_n_per_m = 1000.0, .rotational_stiffness_nm_per_rad = 0.005};
  const auto make_soft = [&] { return std::move(*ToolStep::make(box, {std::make_shared<TriangleMesh>(sheet)}, soft)); };
  const auto whole = make_soft();
  HeldTool held(make_soft());
  double last_held_nm = 0.0;
  double last_whole_nm = 0.0;
  double largest_nm = 0.0;
  double smallest_nm = 0.0;
  for (int n = 0; n < 2000; ++n) {
    const ToolInput input = input_at({0.0, 0.0, 0.00501}, {0.0, 0.002 * n, 0.0});
    if (n == 0) whole->reset(input);
    const double held_nm = held.step(input, n * kTickNs).torque_nm.y();
    held.follow();
    const double whole_nm = whole->step(input).torque_nm.y();
    EXPECT_LT(std::abs(held_nm - last_held_nm), 0.03 * 0.0157) << n;
    EXPECT_LT(std::abs(whole_nm - last_whole_nm), 0.03 * 0.0157) << n;
    last_held_nm = held_nm;
    last_whole_nm = whole_nm;
    largest_nm = std::max(largest_nm, last_held_nm);
    smallest_nm = std::min(smallest_nm, last_held_nm);
  }
  EXPECT_GT(largest_nm, 0.01);
  EXPECT_LT(smallest_nm, -0.01);
}

TEST(HeldTool, IgnoresWhatIsNotFinite) {
  HeldTool held(make_held_step(make_box({0.02, 0.02, 0.02}), make_plane_grid(0.2, 8)));
  const ToolOutput out = held.step(input_at({std::nan(""), 0.0, 0.0}), 0);
  EXPECT_EQ(out.force_n, Vec3(Vec3::Zero()));
  EXPECT_FALSE(held.follow()) << "the slow task never sees it";
}

TEST(HeldTool, TwoThreadsUseNoHeapInTheFastOne) {
  HeldTool held(make_held_step(make_box({0.02, 0.02, 0.02}, 3), make_bumpy_sphere(0.05, 0.05, 5000, 1)));
  std::atomic<bool> stop = false;
  std::thread slow([&] {
    while (!stop) {
      if (!held.follow()) std::this_thread::yield();
    }
  });
  std::uint64_t allocation_count = 0;
  for (int n = 0; n < 2000; ++n) {
    const ToolInput input = sliding_input(n);
    const AllocationGuard guard;
    const ToolOutput out = held.step(input, n * kTickNs);
    allocation_count += guard.count();
    ASSERT_TRUE(out.force_n.allFinite() && out.torque_nm.allFinite());
  }
  stop = true;
  slow.join();
  if (!AllocationGuard::is_available()) GTEST_SKIP();
  EXPECT_EQ(allocation_count, 0U);
}

// The slow task runs only every 40 ms: it finds the contact after the box has entered the plate, and notices only later that it has left.
TEST(HeldTool, ContactsThatComeLateChangeTheForceWithoutADiscontinuity) {
  HeldTool held(make_held_step(make_box({0.02, 0.02, 0.02}, 2), make_box({0.2, 0.2, 0.02}, 4)));
  Vec3 last_n = Vec3::Zero();
  double largest_jump_n = 0.0;
  double largest_n = 0.0;
  constexpr double kSpeedMPerS = 0.1;
  for (int n = 0; n < 600; ++n) {
    const double travel_m = kSpeedMPerS * 1e-3 * (n < 300 ? n : 600 - n);
    const ToolOutput felt = held.step(input_at({0.0, 0.0, 0.035 - travel_m}), n * kTickNs);
    if (n % 40 == 0) held.follow();
    largest_jump_n = std::max(largest_jump_n, (felt.force_n - last_n).norm());
    largest_n = std::max(largest_n, felt.force_n.norm());
    last_n = felt.force_n;
  }
  const double stiffness = held.tool().coupling().stiffness_n_per_m;
  EXPECT_GT(largest_n, 10.0);
  // At most the distance that the device moved until the slow task knew, spread over kContactFadeS, plus the motion of the step itself.
  EXPECT_LT(largest_jump_n, stiffness * kSpeedMPerS * (0.08 * 1e-3 / HeldTool::kContactFadeS + 2e-3));
  EXPECT_EQ(last_n, Vec3::Zero());
}

}  // namespace
}  // namespace hapton
