#include "core/force/deforming_method.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "core/geometry/winding_number.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"
#include "tests/support/settled_twin.h"
#include "tests/support/wandering_hand.h"

namespace hapton {
namespace {

constexpr double kSheetStiffnessNPerM = 1000.0;
constexpr double kSheetSpeed = 0.25;  // m/s

template <class Displacement>
MorphTarget morph_target_of(const TriangleMesh& mesh, const Displacement& displacement) {
  MorphTarget target;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    target.vertices.push_back(v);
    target.displacements.push_back(displacement(mesh.vertices[v]));
  }
  return target;
}

TouchScene deforming_scene(TriangleMesh mesh, std::vector<MorphTarget> targets, std::vector<MorphKey> keys, bool loops,
                           Material material = {}) {
  TouchScene scene;
  scene.objects.push_back({.mesh = made::shared(std::move(mesh)),
                           .material = material,
                           .deformation = std::make_shared<const MeshDeformation>(std::move(targets), std::move(keys), loops)});
  return scene;
}

std::unique_ptr<ForceMethod> make_deforming(const TouchScene& scene, const MethodSettings& settings = {}) {
  auto made = make_method(settings, scene);
  EXPECT_TRUE(made) << (made ? "" : made.error().what);
  return made ? std::move(*made) : nullptr;
}

TriangleMesh deformed_mesh(const TouchObject& object, double time_s) {
  TriangleMesh mesh = *object.mesh;
  mesh.vertices = object.deformation->vertices_at(mesh.vertices, object.deformation->weights_at(time_s));
  return mesh;
}

// A sheet with sides of 60 mm that moves as a whole, at the largest speed of a surface, towards a hand that holds still. side: +1 from
// above, -1 from below.
TouchScene approaching_sheet(double side, double seconds) {
  TriangleMesh sheet = made::sheet(0.03, side * 0.010, 12);
  const auto target = morph_target_of(sheet, [&](const Vec3&) { return Vec3(0, 0, -side * kSheetSpeed * seconds); });
  return deforming_scene(std::move(sheet), {target}, {{0.0, {0.0}}, {seconds, {1.0}}}, false);
}

class DeformingSweep : public testing::TestWithParam<std::tuple<double, double>> {};

// In every step, to the end of the motion, the force is stiffness times the distance by which the sheet has passed the hand.
TEST_P(DeformingSweep, PushesTheHandAheadAndNeverPassesIt) {
  const auto [rate_hz, side] = GetParam();
  const double seconds = 0.2;
  const auto method = make_deforming(approaching_sheet(side, seconds));
  ASSERT_TRUE(method);
  // On an edge, at a vertex, and within a face.
  for (const Vec3& hand : {Vec3(0.0025, -0.0025, 0), Vec3(0.005, -0.005, 0), Vec3(0.0123, -0.0045, 0)}) {
    method->reset(hand);
    double last_n = 0.0;
    for (int i = 0; i <= static_cast<int>(seconds * rate_hz); ++i) {
      const double time_s = i / rate_hz;
      const MethodOutput felt = method->step({.p_SD = hand, .dt_s = 1.0 / rate_hz, .time_s = time_s});
      const double passed = kSheetSpeed * time_s - 0.010;
      const Vec3 expected(0, 0, -side * kSheetStiffnessNPerM * std::max(0.0, passed));
      ASSERT_LT((felt.force_n - expected).norm(), 1e-3) << "at " << time_s << " s";
      ASSERT_LE(felt.force_n.norm() - last_n, kSheetStiffnessNPerM * kSheetSpeed / rate_hz * (1.0 + 1e-6) + 1e-6)
          << "at " << time_s << " s";
      if (passed > 1e-6) {
        ASSERT_TRUE(felt.contact) << "at " << time_s << " s";
      }
      last_n = felt.force_n.norm();
    }
    EXPECT_GT(last_n, 39.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Rates, DeformingSweep, testing::Combine(testing::Values(250.0, 1000.0, 4000.0), testing::Values(1.0, -1.0)),
                         [](const auto& given) {
                           return std::to_string(static_cast<int>(std::get<0>(given.param))) + "_Hz_" +
                                  (std::get<1>(given.param) > 0 ? "from_above" : "from_below");
                         });

// A bumpy ball that breathes, lengthens and has a dent that comes and goes.
TouchScene breathing_ball(Material material = {}) {
  TriangleMesh ball = made::sphere(0.03, 20, 0.05);
  const MorphTarget breath = morph_target_of(ball, [](const Vec3& p) { return Vec3(0.15 * p); });
  const MorphTarget longer = morph_target_of(ball, [](const Vec3& p) { return Vec3(0, 0, 0.3 * p.z()); });
  const MorphTarget dent = morph_target_of(ball, [](const Vec3& p) {
    const double r = (p - Vec3(0, 0.02, 0.02)).norm() / 0.015;
    return Vec3(-0.3 * std::pow(std::max(0.0, 1.0 - r * r), 2) * p);
  });
  return deforming_scene(std::move(ball), {breath, longer, dent},
                         {{0.0, {0.0, 0.0, 0.0}}, {0.1, {1.0, 0.0, 0.5}}, {0.25, {0.3, 1.0, 1.0}}, {0.4, {0.0, 0.0, 0.0}}}, true, material);
}

// The twin is the reference on the mesh of that time, with all triangles. Started at the proxy, it must stay there.
TEST(DeformingMethod, IsWhereTheReferenceStaysOnTheMeshOfThatTime) {
  const TouchScene scene = breathing_ball();
  int contact_steps = 0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const double rate_hz = seed == 2 ? 300.0 : 1000.0;
    const auto method = make_deforming(scene);
    ASSERT_TRUE(method);
    WanderingHand hand(seed);
    method->reset(hand.p);
    for (int i = 0; i < 2500; ++i) {
      const double time_s = i / rate_hz;
      const Vec3& p_SD = hand.next(1.0 / rate_hz);
      const MethodOutput felt = method->step({.p_SD = p_SD, .dt_s = 1.0 / rate_hz, .time_s = time_s});
      ASSERT_NO_FATAL_FAILURE(expect_settled(deformed_mesh(scene.objects[0], time_s), p_SD, felt, i % 10 == 0)) << "step " << i;
      contact_steps += felt.contact ? 1 : 0;
    }
  }
  EXPECT_GT(contact_steps, 2000);
}

// A hand that holds still, while the surface passes over it again and again in 20 periods of the deformation.
TEST(DeformingMethod, AHandThatHoldsStillIsNeverFallenThrough) {
  const TouchScene scene = breathing_ball({.friction_static = 0.4, .friction_dynamic = 0.3});
  std::mt19937_64 random(7);
  SCOPED_TRACE("seed 7");
  std::normal_distribution<double> normal;
  int contact_steps = 0;
  for (int h = 0; h < 40; ++h) {
    const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
    const Vec3 hand = 0.0325 * direction;
    if (std::fabs(compute_winding_number(*scene.objects[0].mesh, hand)) > 1e-3) continue;
    const auto method = make_deforming(scene);
    ASSERT_TRUE(method);
    method->reset(hand);
    for (int i = 0; i < 2000; ++i) {
      const double time_s = 4e-3 * i;
      const MethodOutput felt = method->step({.p_SD = hand, .dt_s = 4e-3, .time_s = time_s});
      contact_steps += felt.contact ? 1 : 0;
      if (i % 7 != 0) continue;
      const double winding = compute_winding_number(deformed_mesh(scene.objects[0], time_s), hand);
      if (winding > 1.0 - 1e-6) {
        ASSERT_TRUE(felt.contact) << "hand " << h << " step " << i;
      } else if (winding < 1e-6) {
        ASSERT_FALSE(felt.contact) << "hand " << h << " step " << i;
      }
    }
  }
  EXPECT_GT(contact_steps, 10'000);
}

// In a gap of the samples, of any length, the sheet does not pass the hand either.
TEST(DeformingMethod, AGapInTheSamplesLosesNoContact) {
  for (const double gap_s : {0.02, 0.05, 0.15}) {
    const auto method = make_deforming(approaching_sheet(1.0, 0.2));
    ASSERT_TRUE(method);
    const Vec3 hand(0.0123, -0.0045, 0.0);
    method->reset(hand);
    (void)method->step({.p_SD = hand, .dt_s = 1e-3, .time_s = 0.035});
    const MethodOutput felt = method->step({.p_SD = hand, .dt_s = gap_s, .time_s = 0.035 + gap_s});
    EXPECT_NEAR(felt.force_n.z(), -kSheetStiffnessNPerM * std::max(0.0, kSheetSpeed * (0.035 + gap_s) - 0.010), 1e-3) << gap_s;
  }
}

// While the hand is far away, the shape is not computed. When the hand comes near, it must feel the present shape.
TEST(DeformingMethod, IsFeltAfterALongTimeFarAway) {
  const TouchScene scene = breathing_ball({.damping_ns_per_m = 1.0});
  const auto method = make_deforming(scene);
  ASSERT_TRUE(method);
  method->reset({0, 0, 0.2});
  double most_n = 0.0;
  for (int i = 0; i <= 3000; ++i) {
    const double z = i < 2000 ? 0.2 : 0.2 - 0.17 * (i - 2000) / 1000.0;
    const MethodOutput felt = method->step({.p_SD = {0.001, 0.0005, z}, .dt_s = 1e-3, .time_s = 1e-3 * i});
    const bool is_inside = compute_winding_number(deformed_mesh(scene.objects[0], 1e-3 * i), {0.001, 0.0005, z}) > 0.999;
    if (is_inside) {
      ASSERT_TRUE(felt.contact) << i;
    }
    most_n = std::max(most_n, felt.force_n.norm());
    ASSERT_LT(felt.force_n.norm(), 20.0) << i;
  }
  EXPECT_GT(most_n, 3.0);
}

// Where nothing changes, the force is that of the proxy on a mesh that does not deform.
TEST(DeformingMethod, IsTheProxyWhereNothingChanges) {
  TouchScene scene = breathing_ball({.friction_static = 0.4, .friction_dynamic = 0.3});
  TouchScene still = scene;
  still.objects[0].deformation = nullptr;
  const auto on_deforming = make_deforming(scene);
  const auto on_rigid = make_deforming(still);
  ASSERT_TRUE(on_deforming && on_rigid);
  WanderingHand hand(11);
  SCOPED_TRACE("seed 11");
  on_deforming->reset(hand.p);
  on_rigid->reset(hand.p);
  int contact_steps = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vec3& p_SD = hand.next(1e-3);
    const MethodOutput deforming = on_deforming->step({.p_SD = p_SD, .time_s = 0.0});
    const MethodOutput rigid = on_rigid->step({.p_SD = p_SD, .time_s = 0.0});
    ASSERT_LT((deforming.force_n - rigid.force_n).norm(), 1e-5 * (1.0 + rigid.force_n.norm())) << i;
    contact_steps += rigid.contact ? 1 : 0;
  }
  EXPECT_GT(contact_steps, 500);
}

// A bar along x, cut into pieces and closed at both ends. The ends slant: at the end of larger x, the upper edge overhangs.
TriangleMesh long_bar(double length, double half_width, std::uint32_t pieces) {
  TriangleMesh bar;
  const double corners[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  for (std::uint32_t i = 0; i <= pieces; ++i) {
    for (const auto& yz : corners)
      bar.vertices.emplace_back(length * i / pieces - 0.5 * half_width * (1.0 - yz[1]), half_width * yz[0], half_width * yz[1]);
  }
  for (std::uint32_t i = 0; i < pieces; ++i) {
    for (std::uint32_t k = 0; k < 4; ++k) {
      const std::uint32_t a = 4 * i + k;
      const std::uint32_t b = 4 * i + (k + 1) % 4;
      bar.triangles.push_back({a, b + 4, b});
      bar.triangles.push_back({a, a + 4, b + 4});
    }
  }
  const std::uint32_t last_ring = 4 * pieces;
  for (const Triangle& cap : {Triangle{0, 1, 2}, Triangle{0, 2, 3}, Triangle{last_ring, last_ring + 2, last_ring + 1},
                              Triangle{last_ring, last_ring + 3, last_ring + 2}})
    bar.triangles.push_back(cap);
  for (Triangle& triangle : bar.triangles) std::swap(triangle[1], triangle[2]);
  return bar;
}

// A step may run out of work anywhere, also just after the probe has left the surface. The surface must then still take it along.
TEST(DeformingMethod, AProbeThatIsOutOfWorkInTheAirIsNotPassed) {
  constexpr double kLength = 0.2;
  constexpr double kHalfWidth = 0.005;
  constexpr std::uint32_t kPieces = 600;
  TriangleMesh bar = long_bar(kLength, kHalfWidth, kPieces);
  const MorphTarget ahead = morph_target_of(bar, [](const Vec3&) { return Vec3(0.01, 0, 0); });
  const TouchScene scene = deforming_scene(std::move(bar), {ahead}, {{0.0, {0.0}}, {1.0, {0.0}}, {1.001, {1.0}}, {2.0, {1.0}}}, false);
  const auto method = make_deforming(scene);
  ASSERT_TRUE(method);
  int steps_in_the_air = 0;
  for (int i = 0; i < 590; ++i) {
    const double x = kLength * (1.0 - (i + 0.3) / kPieces);
    method->reset({x, 0.001, kHalfWidth + 0.001});
    (void)method->step({.p_SD = {x, 0.001, kHalfWidth - 0.001}, .dt_s = 1e-3, .time_s = 0.5});
    const Vec3 device(kLength + 0.002, 0.001, kHalfWidth - 0.001);
    MethodOutput felt = method->step({.p_SD = device, .dt_s = 1e-3, .time_s = 0.501});
    steps_in_the_air += felt.contact && felt.p_SP.z() < kHalfWidth - 0.0005 ? 1 : 0;
    felt = method->step({.p_SD = device, .dt_s = 1.0, .time_s = 1.501});
    EXPECT_TRUE(felt.contact) << i;
    method->reset(device);
    (void)method->step({.p_SD = {kLength + 0.1, 0, 0}, .dt_s = 1e-3, .time_s = 2.0});
  }
  EXPECT_GT(steps_in_the_air, 0);
}

// Without friction the probe slides off; with friction it is carried along.
TEST(DeformingMethod, CarriesTheProxyAlongByFriction) {
  for (const double friction : {0.0, 0.8}) {
    TriangleMesh sheet = made::sheet(0.05, 0.0, 10);
    const auto target = morph_target_of(sheet, [](const Vec3&) { return Vec3(0.02, 0, 0); });
    const auto method = make_deforming(deforming_scene(std::move(sheet), {target}, {{0.0, {0.0}}, {0.2, {1.0}}}, false,
                                                       {.friction_static = friction, .friction_dynamic = friction}));
    ASSERT_TRUE(method);
    method->reset({0, 0, 0.001});
    const Vec3 hand(0, 0, -0.003);  // 3 N: friction holds 2.4 N
    MethodOutput felt;
    for (int i = 0; i <= 200; ++i) felt = method->step({.p_SD = hand, .dt_s = 1e-3, .time_s = 1e-3 * i});
    EXPECT_NEAR(felt.force_n.z(), 3.0, 1e-3);
    EXPECT_NEAR(felt.force_n.x(), friction * 3.0, 1e-2) << "friction " << friction;
  }
}

TEST(DeformingMethod, DampsTheMotionOfAnApproachingSurface) {
  TriangleMesh sheet = made::sheet(0.05, 0.0, 10);
  const auto target = morph_target_of(sheet, [](const Vec3&) { return Vec3(0, 0, 0.02); });
  const auto method =
      make_deforming(deforming_scene(std::move(sheet), {target}, {{0.0, {0.0}}, {0.1, {1.0}}}, false, {.damping_ns_per_m = 2.0}));
  ASSERT_TRUE(method);
  const Vec3 hand(0.001, 0.002, 0.005);
  method->reset(hand);
  MethodOutput felt;
  for (int i = 0; i <= 50; ++i) felt = method->step({.p_SD = hand, .dt_s = 1e-3, .time_s = 1e-3 * i});
  // 10 mm up, 5 mm beyond the hand, at 0.2 m/s: 5 N, and 0.4 N of damping.
  EXPECT_NEAR(felt.force_n.z(), 5.4, 1e-3);
}

// A sheet that can deform, but is at rest.
TouchScene resting_sheet(TriangleMesh sheet, Material material = {}) {
  const auto target = morph_target_of(sheet, [](const Vec3&) { return Vec3(0, 0, 0.01); });
  return deforming_scene(std::move(sheet), {target}, {{0.0, {0.0}}, {1.0, {0.0}}}, false, material);
}

// As in ProxyResume, but the sheet can deform. Its triangles face away from the hand: only the position of the probe shows on which side it
// is.
TEST(DeformingMethod, ResumesOnTheSideThatTheProbeIsOn) {
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  TriangleMesh sheet = made::sheet(0.05, 0.0, 10);
  for (Vec3& vertex : sheet.vertices) vertex = turn * vertex;
  for (Triangle& triangle : sheet.triangles) std::swap(triangle[1], triangle[2]);
  const TouchScene scene = resting_sheet(std::move(sheet));
  const auto before = DeformingMethod::make({}, scene);
  const auto after = DeformingMethod::make({}, scene);
  ASSERT_TRUE(before && after);
  std::mt19937_64 random(3);
  SCOPED_TRACE("seed 3");
  std::uniform_real_distribution<double> unit(-0.04, 0.04);
  for (int n = 0; n < 200; ++n) {
    const double x = unit(random);
    const Vec3 above(x, unit(random), 0.01);
    const Vec3 below = turn * Vec3(above + Vec3(0.001, 0.0005, -0.012));
    (*before)->reset(turn * above);
    ASSERT_FALSE((*before)->held_at()) << "contact is forgotten";
    const MethodOutput held = (*before)->step({.p_SD = below});
    ASSERT_TRUE(held.contact && (*before)->held_at());
    (*after)->resume(*(*before)->held_at());
    ASSERT_LT(((*after)->step({.p_SD = below}).force_n - held.force_n).norm(), 1e-6) << n;
  }
}

// A sample that is far from the surface may be handled without computing the proxy. Its correction is damped with the motion since the
// sample before it, not with the motion since the proxy was last computed.
TEST(DeformingMethod, ACorrectionIsDampedAsItsSample) {
  const auto method = DeformingMethod::make({}, resting_sheet(made::sheet(0.05, 0.0, 10), {.damping_ns_per_m = 2.0}));
  ASSERT_TRUE(method);
  const auto at = [](double z) { return Vec3(0.0013, 0.0021, z); };
  (*method)->reset(at(0.006));
  for (const double z : {0.0055, 0.0012, 0.001}) EXPECT_FALSE((*method)->step({.p_SD = at(z)}).contact) << z;
  // 0.5 mm deep, after 1.7 mm in a millisecond.
  EXPECT_NEAR((*method)->step({.p_SD = at(-0.0005), .is_correction = true}).force_n.z(), 0.5 + 2.0 * 1.7, 1e-3);
}

// Together with a floor that stands still: the sheet never presses the proxy into the floor, and the floor is felt as well.
TEST(DeformingMethod, NeverPressesTheProxyIntoAFloorThatStandsStill) {
  TouchScene scene = approaching_sheet(1.0, 0.2);
  scene.objects.push_back({.mesh = made::shared(made::box({-0.1, -0.1, -0.03}, {0.1, 0.1, -0.02})), .material = {}});
  const auto method = make_deforming(scene);
  ASSERT_TRUE(method);
  const Vec3 hand(0.0123, -0.0045, 0.0);
  method->reset(hand);
  for (int i = 0; i <= 200; ++i) {
    const MethodOutput felt = method->step({.p_SD = hand, .dt_s = 1e-3, .time_s = 1e-3 * i});
    ASSERT_GE(felt.p_SP.z(), -0.02 - 1e-9) << i;
    ASSERT_NEAR(felt.force_n.z(), -kSheetStiffnessNPerM * std::clamp(kSheetSpeed * 1e-3 * i - 0.010, 0.0, 0.020), 1e-3) << i;
  }
}

// The object moves as well: a sheet that rises by as much as it deforms downwards stays where it is.
TEST(DeformingMethod, DeformsInTheFrameThatMovesAlong) {
  TouchScene scene = approaching_sheet(1.0, 0.2);
  scene.objects[0].motion = std::make_shared<const KeyframeMotion>(
      Vec3::Zero(), std::vector<Keyframe>{{0.0, Vec3::Zero(), Quat::Identity()}, {0.2, Vec3(0, 0, kSheetSpeed * 0.2), Quat::Identity()}},
      false);
  const auto method = make_deforming(scene);
  ASSERT_TRUE(method);
  const Vec3 hand(0.0123, -0.0045, 0.011);
  method->reset({0.0123, -0.0045, 0.009});
  (void)method->step({.p_SD = {0.0123, -0.0045, 0.009}, .dt_s = 1e-3, .time_s = 0.0});
  for (int i = 1; i <= 200; ++i) {
    const MethodOutput felt = method->step({.p_SD = hand, .dt_s = 1e-3, .time_s = 1e-3 * i});
    ASSERT_NEAR(felt.force_n.z(), -1.0, 1e-3) << i;
  }
}

TEST(DeformingMethod, StepsWithoutHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  const auto method = make_deforming(breathing_ball());
  ASSERT_TRUE(method);
  WanderingHand hand(3);
  const AllocationGuard guard;
  method->reset(hand.p);
  double most_n = 0.0;
  for (int i = 0; i < 3000; ++i) most_n = std::max(most_n, method->step({.p_SD = hand.next(1e-3), .time_s = 1e-3 * i}).force_n.norm());
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(most_n, 1.0);
}

TEST(DeformingMethod, SaysWhatItDoesNotFeel) {
  const TouchScene scene = breathing_ball();
  for (const char* name : {"smooth", "sweep", "reference"}) {
    const auto made = make_method({.name = name}, scene);
    ASSERT_FALSE(made) << name;
    EXPECT_NE(made.error().what.find("choose proxy"), std::string::npos) << made.error().what;
  }
  EXPECT_FALSE(make_method({.probe_radius_m = 0.001}, scene));
  EXPECT_FALSE(make_method({.shading = 0.5}, scene));
  TouchScene crossing = scene;
  TriangleMesh two = made::sphere(0.03, 8);
  const TriangleMesh other = made::sphere(0.031, 7);
  const auto shift = static_cast<std::uint32_t>(two.vertices.size());
  for (const Vec3& v : other.vertices) two.vertices.push_back(v + Vec3(0.01, 0, 0));
  for (const Triangle& t : other.triangles) two.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  crossing.objects[0].deformation = std::make_shared<const MeshDeformation>(
      std::vector{morph_target_of(two, [](const Vec3& p) { return p; })}, std::vector<MorphKey>{{0.0, {0.0}}, {1.0, {0.1}}}, false);
  crossing.objects[0].mesh = made::shared(std::move(two));
  EXPECT_FALSE(make_method({}, crossing));
}

TEST(DeformingMethod, SaysHowItDeforms) {
  const std::string text = make_deforming(breathing_ball())->describe();
  EXPECT_NE(text.find("deforms for 0.4 s, repeated: 762 vertices move"), std::string::npos) << text;
}

}  // namespace
}  // namespace hapton
