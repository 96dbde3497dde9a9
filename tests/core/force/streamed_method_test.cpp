#include "core/force/streamed_method.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "core/geometry/winding_number.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"
#include "tests/support/settled_twin.h"
#include "tests/support/wandering_hand.h"

namespace hapton {
namespace {

constexpr double kSpringNPerM = 1000.0;
constexpr double kMaxSpeed = 0.25;  // m/s

using Shape = std::vector<Vec3>;

template <class Map>
Shape map_vertices(const TriangleMesh& mesh, const Map& map) {
  Shape shape;
  for (const Vec3& p : mesh.vertices) shape.push_back(map(p));
  return shape;
}

std::unique_ptr<StreamedMethod> make_streamed(std::shared_ptr<const TriangleMesh> mesh, double reach_m, const Material& material = {}) {
  auto made = StreamedMethod::make({}, std::move(mesh), material, reach_m);
  EXPECT_TRUE(made) << (made ? "" : made.error().what);
  return made ? std::move(*made) : nullptr;
}

void offer_shape(StreamedMethod& method, const Shape& shape, double duration_s) {
  auto stage = method.stager().make(method.current_stage().to, shape);
  ASSERT_TRUE(stage) << stage.error().what;
  (void)method.offer(std::move(*stage), duration_s);
}

// A bumpy ball and random shapes of it: wider, longer and with a dent.
struct RandomBallShapes {
  std::shared_ptr<const TriangleMesh> mesh = made::shared(made::sphere(0.03, 20, 0.05));
  std::mt19937_64 random;
  explicit RandomBallShapes(std::uint64_t seed) : random(seed) {}
  Shape next() {
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const double wide = 0.15 * unit(random);
    const double longer = 0.3 * unit(random);
    const double dent = 0.3 * unit(random);
    return map_vertices(*mesh, [&](const Vec3& p) {
      const double r = (p - Vec3(0, 0.02, 0.02)).norm() / 0.015;
      return Vec3((1.0 + wide - dent * std::pow(std::max(0.0, 1.0 - r * r), 2)) * p + Vec3(0, 0, longer * p.z()));
    });
  }
};

double longest_of(const MorphTarget& target) {
  double longest_m = 0.0;
  for (const Vec3& displacement : target.displacements) longest_m = std::max(longest_m, displacement.norm());
  return longest_m;
}

// How far the surface may have moved since the last step decides whether the probe is taken along in the step in which contact begins. A
// stage knows this distance; for keyframes, the distances that their targets move are added up.
enum class TravelBound : std::uint8_t { of_stage, of_keyframes };

// The twin has the same shapes at the same times, as keyframes that are known beforehand.
void expect_the_force_of_keyframes(std::uint64_t seed, std::size_t shape_count, double interval_s, const Material& material,
                                   TravelBound bound = TravelBound::of_stage) {
  SCOPED_TRACE(testing::Message() << "seed " << seed << ", " << shape_count << " shapes");
  RandomBallShapes ball(seed);
  std::vector<Shape> shapes;
  std::vector<MorphTarget> targets;
  std::vector<MorphKey> keys = {{0.0, std::vector<double>(shape_count, 0.0)}};
  for (std::size_t f = 0; f < shape_count; ++f) {
    shapes.push_back(ball.next());
    targets.emplace_back();
    for (std::uint32_t v = 0; v < ball.mesh->vertices.size(); ++v) {
      targets.back().vertices.push_back(v);
      targets.back().displacements.push_back(shapes.back()[v] - ball.mesh->vertices[v]);
    }
    keys.push_back({interval_s * static_cast<double>(f + 1), std::vector<double>(shape_count, 0.0)});
    keys.back().weights[f] = 1.0;
  }
  TouchScene scene;
  scene.objects.push_back(
      {.mesh = ball.mesh, .material = material, .deformation = std::make_shared<const MeshDeformation>(targets, keys, false)});
  auto keyframed = make_method({}, scene);
  ASSERT_TRUE(keyframed) << keyframed.error().what;
  const auto streamed = make_streamed(ball.mesh, 0.02, material);
  ASSERT_TRUE(streamed);
  WanderingHand hand(seed);
  (*keyframed)->reset(hand.p);
  streamed->reset(hand.p);
  int contact_steps = 0;
  std::size_t offered_shapes = 0;
  for (int i = 0; i < 1500; ++i) {
    if (offered_shapes < shapes.size() && streamed->serial() == offered_shapes) {
      auto stage = streamed->stager().make(streamed->current_stage().to, shapes[offered_shapes]);
      ASSERT_TRUE(stage) << stage.error().what;
      if (bound == TravelBound::of_keyframes) {
        (*stage)->most_m = longest_of(targets[offered_shapes]) + (offered_shapes > 0 ? longest_of(targets[offered_shapes - 1]) : 0.0);
      }
      (void)streamed->offer_at(std::move(*stage), interval_s * static_cast<double>(offered_shapes), interval_s);
      ++offered_shapes;
    }
    const Vec3& p_SD = hand.next(1e-3);
    const MethodInput input{.p_SD = p_SD, .dt_s = 1e-3, .time_s = 1e-3 * i};
    const MethodOutput expected = (*keyframed)->step(input);
    const MethodOutput felt = streamed->step(input);
    ASSERT_LT((felt.force_n - expected.force_n).norm(), 1e-5 * (1.0 + expected.force_n.norm())) << "step " << i;
    ASSERT_LT((felt.p_SP - expected.p_SP).norm(), 1e-8) << "step " << i;
    contact_steps += felt.contact ? 1 : 0;
  }
  EXPECT_EQ(offered_shapes, shapes.size());
  EXPECT_GT(contact_steps, 300);
}

TEST(StreamedMethod, GivesTheForceOfTheSameShapesAsKeyframes) {
  for (const std::uint64_t seed : {1, 2, 3}) expect_the_force_of_keyframes(seed, MeshDeformation::kMaxTargets, 0.08, {});
}

// With one shape only: with several targets, the bound of how far the surface may move is wider, so the probe may be taken along in the
// step in which contact begins, which changes friction and damping in that step.
TEST(StreamedMethod, GivesTheForceOfAKeyframeUnderFrictionAndDamping) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    expect_the_force_of_keyframes(seed, 1, 1.2, {.damping_ns_per_m = 1.0, .friction_static = 0.4, .friction_dynamic = 0.3});
  }
}

// With several shapes the forces agree if a stage is given the wider bound of the keyframes. Otherwise the forces in the steps in which
// contact begins differ by some hundredths of a newton: the probe is taken along in only one of the two methods, so its motion along the
// surface in that step differs, and with it friction and damping.
TEST(StreamedMethod, GivesTheForceOfKeyframesUnderFrictionAndDampingWithTheirBound) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    expect_the_force_of_keyframes(seed, MeshDeformation::kMaxTargets, 0.08,
                                  {.damping_ns_per_m = 1.0, .friction_static = 0.4, .friction_dynamic = 0.3}, TravelBound::of_keyframes);
  }
}

// Another twin: the reference, on all triangles of the mesh as it is at that time.
TEST(StreamedMethod, IsWhereTheReferenceStaysOnTheMeshOfThatTime) {
  RandomBallShapes ball(5);
  SCOPED_TRACE("seed 5");
  const auto method = make_streamed(ball.mesh, 0.02);
  ASSERT_TRUE(method);
  WanderingHand hand(5);
  method->reset(hand.p);
  int contact_steps = 0;
  for (int i = 0; i < 2500; ++i) {
    if (i % 37 == 0) offer_shape(*method, ball.next(), 0.03);
    const Vec3& p_SD = hand.next(1e-3);
    const MethodOutput felt = method->step({.p_SD = p_SD, .dt_s = 1e-3, .time_s = 1e-3 * i});
    ASSERT_NO_FATAL_FAILURE(expect_settled({.vertices = method->vertices(), .triangles = ball.mesh->triangles}, p_SD, felt, i % 10 == 0))
        << "step " << i;
    contact_steps += felt.contact ? 1 : 0;
  }
  EXPECT_GT(contact_steps, 700);
}

// Shapes that jump, at any interval and due at once: while the hand holds still, the force changes by at most stiffness times 0.25 m/s.
TEST(StreamedMethod, NoShapeMakesTheForceJump) {
  for (const int interval : {1, 5, 33, 250}) {
    const auto mesh = made::shared(made::sheet(0.03, 0.0, 8));
    const auto method = make_streamed(mesh, 0.02);
    ASSERT_TRUE(method);
    const Vec3 hand(0.0123, -0.0045, -0.001);
    method->reset({0.0123, -0.0045, 0.001});
    std::mt19937_64 random(11);
    SCOPED_TRACE(testing::Message() << "seed 11, a shape every " << interval << " steps");
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    double last_n = 1.0;
    double most_n = 0.0;
    for (int i = 0; i < 1500; ++i) {
      if (i % interval == 0) {
        const double height_m = 0.01 * unit(random);
        offer_shape(*method, map_vertices(*mesh, [&](const Vec3& p) { return Vec3(p + Vec3(0, 0, height_m)); }), 0.0);
      }
      const MethodOutput felt = method->step({.p_SD = hand, .dt_s = 1e-3, .time_s = 1e-3 * i});
      if (i > 0) {
        ASSERT_LE(std::fabs(felt.force_n.norm() - last_n), kSpringNPerM * kMaxSpeed * 1e-3 * (1.0 + 1e-6) + 1e-6) << "step " << i;
      }
      last_n = felt.force_n.norm();
      most_n = std::max(most_n, last_n);
    }
    EXPECT_GT(most_n, 2.0);
  }
}

// In a gap in the samples one stage ends and another begins: the surface does not pass through the hand unnoticed.
TEST(StreamedMethod, AGapInTheSamplesLosesNoContact) {
  const auto mesh = made::shared(made::sheet(0.03, 0.0, 12));
  for (const double gap_s : {0.01, 0.05, 0.2, 2.0}) {
    const auto method = make_streamed(mesh, 0.03);
    ASSERT_TRUE(method);
    const auto at = [&](double height) { return map_vertices(*mesh, [&](const Vec3& p) { return Vec3(p + Vec3(0, 0, height)); }); };
    const Vec3 hand(0.0123, -0.0045, 0.004);
    method->reset(hand);
    offer_shape(*method, at(0.008), 0.05);
    (void)method->step({.p_SD = hand, .dt_s = 1e-3, .time_s = 0.0});
    offer_shape(*method, at(0.016), 0.05);
    const MethodOutput felt = method->step({.p_SD = hand, .dt_s = gap_s, .time_s = gap_s});
    EXPECT_NEAR(felt.force_n.z(), kSpringNPerM * std::max(0.0, std::min(0.016, 0.16 * gap_s) - 0.004), 1e-3) << gap_s;
  }
}

// While the hand is far away, nothing is computed, but the shapes go on; when the hand then reaches the surface, contact begins at once.
TEST(StreamedMethod, ShapesGoOnWhileTheHandIsFarAway) {
  RandomBallShapes ball(6);
  SCOPED_TRACE("seed 6");
  const auto method = make_streamed(ball.mesh, 0.02);
  ASSERT_TRUE(method);
  method->reset({0, 0, 0.2});
  double most_n = 0.0;
  for (int i = 0; i <= 3000; ++i) {
    if (i % 40 == 0) offer_shape(*method, ball.next(), 0.03);
    const double z = i < 2000 ? 0.2 : 0.2 - 0.175 * (i - 2000) / 1000.0;
    const Vec3 p(0.001, 0.0005, z);
    const MethodOutput felt = method->step({.p_SD = p, .dt_s = 1e-3, .time_s = 1e-3 * i});
    const TriangleMesh shape{.vertices = method->vertices(), .triangles = ball.mesh->triangles};
    const double winding = i % 5 == 0 ? compute_winding_number(shape, p) : 0.5;
    if (winding > 0.999) {
      ASSERT_TRUE(felt.contact) << i;
    } else if (winding < 1e-3) {
      ASSERT_FALSE(felt.contact) << i;
    }
    most_n = std::max(most_n, felt.force_n.norm());
  }
  EXPECT_GT(method->serial(), 60U);
  EXPECT_GT(most_n, 3.0);
}

TEST(StreamedMethod, StepsAndTakesShapesWithoutHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  RandomBallShapes ball(3);
  SCOPED_TRACE("seed 3");
  const auto method = make_streamed(ball.mesh, 0.02);
  ASSERT_TRUE(method);
  std::vector<std::unique_ptr<ShapeStage>> stages;
  Shape from = ball.mesh->vertices;
  for (int s = 0; s < 10; ++s) {
    const Shape to = ball.next();
    auto stage = method->stager().make(from, to);
    ASSERT_TRUE(stage) << stage.error().what;
    stages.push_back(std::move(*stage));
    from = to;
  }
  std::vector<StreamedGeometry::Released> released(stages.size());
  WanderingHand hand(3);
  const AllocationGuard guard;
  method->reset(hand.p);
  double most_n = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const std::size_t next = method->serial();
    if (next < stages.size() && stages[next] != nullptr) released[next] = method->offer(std::move(stages[next]), 0.05);
    most_n = std::max(most_n, method->step({.p_SD = hand.next(1e-3), .time_s = 1e-3 * i}).force_n.norm());
  }
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_EQ(method->serial(), stages.size());
  EXPECT_GT(most_n, 1.0);
}

TEST(StreamedMethod, SaysWhatItCannotTake) {
  const auto mesh = made::shared(made::sheet(0.03, 0.0, 4));
  EXPECT_FALSE(StreamedMethod::make({}, mesh, {}, 0.0));
  EXPECT_FALSE(StreamedMethod::make({}, mesh, {}, std::nan("")));
  EXPECT_FALSE(StreamedMethod::make({}, nullptr, {}, 0.01));
  EXPECT_FALSE(StreamedMethod::make({}, made::shared(TriangleMesh()), {}, 0.01));
  EXPECT_FALSE(StreamedMethod::make({.probe_radius_m = 0.001}, mesh, {}, 0.01));
  EXPECT_FALSE(StreamedMethod::make({.shading = 0.5}, mesh, {}, 0.01));
  const auto method = make_streamed(mesh, 0.01);
  EXPECT_NE(method->describe().find("a program gives its shapes: 25 vertices"), std::string::npos) << method->describe();
}

}  // namespace
}  // namespace hapton
