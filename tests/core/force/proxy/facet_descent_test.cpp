#include "core/force/proxy/facet_descent.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <set>
#include <vector>

#include "core/force/reference/reference_method.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

// The proxy's values.
constexpr double kContactOffset = 0x1p-30;
constexpr double kMargin = 512.0 * kContactOffset;
constexpr double kSame = 1e-7;
constexpr double kTolerance = 0x1p-10 * kContactOffset;

// A point held by surfaces, and which ones.
struct State {
  Vec3 at = Vec3::Zero();
  std::vector<std::uint32_t> triangles;
  std::vector<Vec3> normals;
};

// A mesh, the descent over it, and the reference to compare with. All positions local.
class Ground {
 public:
  explicit Ground(TriangleMesh mesh, double radius = 0.25)
      : radius_(radius), mesh_(std::make_shared<TriangleMesh>(std::move(mesh))), geometry_({mesh_.get()}) {
    TouchScene scene;
    scene.objects.push_back({mesh_, {}});
    reference_ = std::move(ReferenceMethod::make_reference(MethodSettings(), scene).value());
  }

  const TouchGeometry& geometry() const { return geometry_; }
  const FacetDescent& descent() const { return descent_; }

  // Over a point of a triangle given by its barycentric coordinates, on the side that the vertex order shows or the other.
  State state_on(std::uint32_t triangle, const Vec3& shares, double side = 1.0) {
    const ContactTriangle face(geometry_.corner(triangle, 0), geometry_.corner(triangle, 1), geometry_.corner(triangle, 2));
    const Vec3 on = shares[0] * face.corner(0) + shares[1] * face.corner(1) + shares[2] * face.corner(2);
    return {on + side * kContactOffset * face.normal(), {triangle}, {side * face.normal()}};
  }

  // Over p, on the triangle nearest to it, on p's side.
  State state_over(const Vec3& p) {
    std::uint32_t nearest = 0;
    geometry_.visit_nearest(p, std::numeric_limits<double>::infinity(), [&](std::uint32_t t, double bound) {
      const double d = geometry_.separation(t, p).distance;
      if (d * d < bound) nearest = t;
      return std::min(bound, d * d);
    });
    const Separation s = geometry_.separation(nearest, p);
    EXPECT_EQ(s.feature, Feature::face);
    return {s.nearest + kContactOffset * s.normal, {nearest}, {s.normal}};
  }

  bool run(const State& from, const Vec3& device) {
    double radius = radius_;
    while (!cache_.rebuild(geometry_, Box{from.at.array() - radius, from.at.array() + radius})) radius *= 0.8;
    std::vector<FacetDescent::Constraint> held(from.triangles.size());
    for (std::size_t i = 0; i < held.size(); ++i) held[i] = {cache_.slot_of(from.triangles[i]), from.normals[i], 0.0};
    return descent_.run(from.at, held, device);
  }

  // Pre: the last run succeeded.
  State end() const {
    State state;
    state.at = descent_.end();
    for (const FacetDescent::Constraint& constraint : descent_.constraints()) {
      state.triangles.push_back(cache_.triangle_at(constraint.slot));
      state.normals.push_back(constraint.normal);
    }
    return state;
  }

  void expect_minimum(const Vec3& device) {
    const State at = end();
    Vec3 total = Vec3::Zero();
    for (std::size_t i = 0; i < at.triangles.size(); ++i) {
      const FacetDescent::Constraint& constraint = descent_.constraints()[i];
      EXPECT_GT(constraint.multiplier, 0.0);
      EXPECT_NEAR(constraint.normal.norm(), 1.0, 1e-15);
      total += constraint.multiplier * constraint.normal;
      const Separation s = geometry_.separation(at.triangles[i], at.at);
      EXPECT_EQ(s.feature, Feature::face);
      EXPECT_NEAR(s.distance, kContactOffset, kTolerance);
      EXPECT_GT(s.normal.dot(constraint.normal), 0.999999) << "held from the wrong side";
    }
    EXPECT_LE((at.at - device - total).norm(), 1e-14);
    for (std::uint32_t t = 0; t < geometry_.triangle_count(); ++t) {
      EXPECT_GE(geometry_.separation(t, at.at).distance, kContactOffset - kTolerance) << "triangle " << t;
    }
  }

  // Each triangle on the path shares an edge with another one, from the initial constraints to the final ones.
  void expect_connected(const State& from) {
    const auto faces = descent_.faces();
    std::set<std::uint32_t> left(faces.begin(), faces.end());
    std::vector<std::uint32_t> reached = {cache_.slot_of(from.triangles[0])};
    EXPECT_EQ(left.erase(reached[0]), 1U);
    for (std::size_t i = 0; i < reached.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t beyond = cache_.adjacent(reached[i], k).slot;
        if (left.erase(beyond) > 0) reached.push_back(beyond);
      }
    }
    EXPECT_TRUE(left.empty());
    for (const FacetDescent::Constraint& constraint : descent_.constraints())
      EXPECT_NE(std::find(faces.begin(), faces.end(), constraint.slot), faces.end());
  }

  // Distance from where the reference settles, starting at the same point and following the device in equal sub-steps.
  double away_from_reference(const State& from, const Vec3& device, int parts = 1) {
    Vec3 proxy_m = geometry_.to_scene(from.at);
    for (int part = 1; part <= parts; ++part) {
      const Vec3 there = from.at + (device - from.at) * (static_cast<double>(part) / parts);
      proxy_m = reference_->settle_from(proxy_m, geometry_.to_scene(there)).p_SP;
    }
    return (geometry_.to_local(proxy_m) - descent_.end()).norm();
  }

 private:
  double radius_;
  std::shared_ptr<TriangleMesh> mesh_;
  TouchGeometry geometry_;
  TriangleCache cache_;
  FacetDescent descent_{cache_, kContactOffset, kMargin};
  std::unique_ptr<ReferenceMethod> reference_;
};

// Numbers of descents: tried; succeeded; ended at a concave edge; met one; within the jump limit; ended elsewhere than the reference, in
// one step (it may pass over a shallow hollow) and in any number of sub-steps.
struct Tally {
  std::size_t runs = 0, succeeded = 0, in_concave_edges = 0, over_concave_edges = 0, within_jumps = 0, elsewhere = 0;
};

// Descents of a few steps each, from anywhere on the mesh and either side; the device is up to `radius` away along the surface, and as
// deep.
Tally wander(Ground& ground, double radius, int starts, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::uniform_real_distribution<double> part(0.05, 1.0);
  Tally tally;
  for (int i = 0; i < starts; ++i) {
    const Vec3 shares(part(random), part(random), part(random));
    State state = ground.state_on(static_cast<std::uint32_t>(random() % ground.geometry().triangle_count()), shares / shares.sum(),
                                  i % 2 == 0 ? 1 : -1);
    for (int leg = 0; leg < 4; ++leg) {
      Vec3 normal = Vec3::Zero();
      for (const Vec3& n : state.normals) normal += n;
      const Vec3 device = state.at + radius * (Vec3(unit(random), unit(random), unit(random)) - part(random) * normal.normalized());
      ++tally.runs;
      if (!ground.run(state, device)) break;
      ++tally.succeeded;
      ground.expect_minimum(device);
      ground.expect_connected(state);
      EXPECT_LE((ground.descent().end() - device).norm(), (state.at - device).norm() + kContactOffset);
      const State end = ground.end();
      tally.in_concave_edges += end.triangles.size() == 2 ? 1 : 0;
      tally.over_concave_edges += ground.descent().met_concave_edge() ? 1 : 0;
      EXPECT_LE(ground.away_from_reference(end, device), kSame) << "the reference does not stay there";
      if (ground.away_from_reference(state, device) > kSame) {
        ++tally.within_jumps;
        tally.elsewhere +=
            ground.away_from_reference(state, device, 8) > kSame && ground.away_from_reference(state, device, 64) > kSame ? 1 : 0;
      }
      state = end;
    }
  }
  return tally;
}

TriangleMesh with_some_turned_over(TriangleMesh mesh, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (Triangle& t : mesh.triangles) {
    std::rotate(t.begin(), t.begin() + static_cast<int>(random() % 3), t.end());
    if (random() % 2 == 0) std::swap(t[0], t[1]);
  }
  return mesh;
}

// z = bend (x^2 - y^2) over a square.
TriangleMesh make_saddle(double side, double bend, int cells) {
  TriangleMesh mesh = make_plane_grid(side, cells);
  for (Vec3& v : mesh.vertices) v.z() = bend * (v.x() * v.x() - v.y() * v.y());
  return mesh;
}

// Faces of random slopes at the origin that go round it `times` times.
TriangleMesh make_fan(int faces, int times, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::uniform_real_distribution<double> width(0.1, 0.9);
  std::vector<double> widths(static_cast<std::size_t>(faces));
  for (double& w : widths) w = width(random);
  const double all = std::accumulate(widths.begin(), widths.end(), 0.0);
  const double steep = 1.5 * std::fabs(unit(random));
  double angle = std::numbers::pi * unit(random);
  TriangleMesh mesh{{Vec3::Zero()}, {}};
  for (std::uint32_t i = 0; i < widths.size(); ++i) {
    mesh.vertices.push_back(0.5 * Vec3(std::cos(angle), std::sin(angle), steep * unit(random)));
    mesh.triangles.push_back({0, i + 1, (i + 1) % static_cast<std::uint32_t>(faces) + 1});
    angle += widths[i] / all * 2.0 * std::numbers::pi * times;
  }
  return mesh;
}

TEST(FacetDescent, OnASphereItEndsWhereTheReferenceDoes) {
  constexpr unsigned kSeed = 801;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  Ground ground(make_icosphere(0.4, 4), 0.15);
  const Tally tally = wander(ground, 0.05, 500, kSeed);
  EXPECT_GT(tally.succeeded, tally.runs / 2);
  EXPECT_GT(tally.in_concave_edges, 50U) << "from inside";
  EXPECT_LT(tally.within_jumps, tally.succeeded / 100);
  EXPECT_EQ(tally.elsewhere, 0U);
}

TEST(FacetDescent, OnABumpySphereItEndsWhereTheReferenceDoes) {
  constexpr unsigned kSeed = 802;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  const TriangleMesh mesh = make_bumpy_sphere(0.4, 0.1, 5000, 17);
  for (const TriangleMesh& oriented : {mesh, flipped(mesh), with_some_turned_over(mesh, kSeed)}) {
    Ground ground(oriented, 0.15);
    const Tally tally = wander(ground, 0.03, 300, kSeed);
    EXPECT_GT(tally.succeeded, tally.runs / 2);
    EXPECT_GT(tally.in_concave_edges, 25U);
    EXPECT_GT(tally.over_concave_edges, tally.in_concave_edges);
    EXPECT_LT(tally.within_jumps, tally.succeeded / 100);
    EXPECT_EQ(tally.elsewhere, 0U);
  }
}

TEST(FacetDescent, OverASaddleItEndsWhereTheReferenceDoes) {
  constexpr unsigned kSeed = 803;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  for (const double bend : {0.3, 1.0}) {
    Ground ground(make_saddle(1.0, bend, 40), 0.12);
    const Tally tally = wander(ground, 0.04, 1000, kSeed);
    EXPECT_GT(tally.succeeded, tally.runs / 4);
    EXPECT_GT(tally.over_concave_edges, 25U);
    EXPECT_LT(tally.within_jumps, tally.succeeded / 100);
    EXPECT_EQ(tally.elsewhere, 0U);
  }
}

// Two slopes down to the line x = 0, z = 0, in either orientation, divided along the concave edge or not.
TEST(FacetDescent, DownAGrooveItSettlesInTheConcaveEdge) {
  for (const int cells : {2, 10}) {
    TriangleMesh groove = make_plane_grid(1.0, cells);
    for (Vec3& v : groove.vertices) v.z() = 0.5 * std::fabs(v.x());
    for (const TriangleMesh& oriented : {groove, flipped(groove), with_some_turned_over(groove, 5)}) {
      Ground ground(oriented, 1.0);
      const Vec3 from = ground.geometry().to_local({0.13, 0.02, 0.2});
      const Vec3 device = ground.geometry().to_local({0.03, 0.07, -0.2});
      const State start = ground.state_over(from);
      ASSERT_TRUE(ground.run(start, device));
      EXPECT_TRUE(ground.descent().met_concave_edge());
      ASSERT_EQ(ground.descent().constraints().size(), 2U);
      ground.expect_minimum(device);
      ground.expect_connected(start);
      const Vec3 rest = ground.geometry().to_scene(ground.descent().end());
      EXPECT_NEAR((rest - Vec3(0.0, 0.07, 0.0)).norm(), 0.0, 1e-8);

      // Along the concave edge, and out of it again up the other slope.
      const State in_concave_edge = ground.end();
      const Vec3 along = ground.geometry().to_local({-0.02, 0.16, -0.1});
      ASSERT_TRUE(ground.run(in_concave_edge, along));
      EXPECT_EQ(ground.descent().constraints().size(), 2U);
      ground.expect_minimum(along);
      const Vec3 up = ground.geometry().to_local({-0.15, 0.17, 0.03});
      ASSERT_TRUE(ground.run(in_concave_edge, up));
      EXPECT_EQ(ground.descent().constraints().size(), 1U);
      ground.expect_minimum(up);
      EXPECT_NEAR((ground.geometry().to_scene(ground.descent().end()) - Vec3(-0.132, 0.17, 0.066)).norm(), 0.0, 1e-8)
          << "closest point on z = -x / 2";
    }
  }
}

// With the device deeper than the wall is thick, the proxy stays on its side.
TEST(FacetDescent, AThinWallHoldsFromEitherSide) {
  Ground ground(make_thin_wall(1.0, 0.004, 10), 0.3);
  for (const double side : {1.0, -1.0}) {
    const State start = ground.state_over(ground.geometry().to_local({0.02, 0.03, side * 0.01}));
    const Vec3 device = ground.geometry().to_local({0.17, -0.06, side * -0.1});
    ASSERT_TRUE(ground.run(start, device));
    ground.expect_minimum(device);
    EXPECT_NEAR((ground.geometry().to_scene(ground.descent().end()) - Vec3(0.17, -0.06, side * 0.002)).norm(), 0.0, 1e-8);
    EXPECT_FALSE(ground.descent().met_concave_edge());
  }
}

TEST(FacetDescent, ASheetNearThePathIsLeftToTheGeneralMethod) {
  for (const double margins : {-0.9, -0.1, 0.1, 0.9, -3.0, 3.0}) {
    const TriangleMesh sheet = make_plane_grid(1.0, 4);
    TriangleMesh small = make_plane_grid(0.02, 1);
    for (Vec3& v : small.vertices) v += Vec3(0.02, 0.01, kContactOffset + margins * kMargin);
    Ground ground(joined(sheet, small), 1.0);
    const State start = ground.state_over(ground.geometry().to_local({-0.1, -0.05, 0.01}));
    EXPECT_EQ(ground.run(start, ground.geometry().to_local({0.1, 0.05, -0.1})), std::fabs(margins) > 1.0) << margins << " margins off";
    EXPECT_TRUE(ground.run(start, ground.geometry().to_local({-0.21, 0.07, -0.1}))) << "elsewhere it does not matter";
  }
}

TEST(FacetDescent, BoundariesAreLeftToTheGeneralMethod) {
  Ground ground(make_plane_grid(1.0, 4), 1.0);
  const State start = ground.state_over(ground.geometry().to_local({0.4, 0.03, 0.01}));
  EXPECT_TRUE(ground.run(start, ground.geometry().to_local({0.49, 0.05, -0.1})));
  EXPECT_FALSE(ground.run(start, ground.geometry().to_local({0.51, 0.05, -0.1})));
  EXPECT_FALSE(ground.run(start, ground.geometry().to_local({0.5 - 0.5 * kMargin, 0.05, -0.1}))) << "at rest exactly on the boundary";
}

TEST(FacetDescent, EdgesOfThreeFacesAreLeftToOthers) {
  TriangleMesh mesh = make_plane_grid(1.0, 2);
  const auto at = [&](const Vec3& p) {
    return static_cast<std::uint32_t>(
        std::find_if(mesh.vertices.begin(), mesh.vertices.end(), [&](const Vec3& v) { return (v - p).norm() < 1e-9; }) -
        mesh.vertices.begin());
  };
  const std::uint32_t from = at({0, 0, 0});
  const std::uint32_t to = at({0, 0.5, 0});
  ASSERT_LT(std::max(from, to), mesh.vertices.size());
  const TriangleMesh without = mesh;
  mesh.vertices.emplace_back(0.0, 0.25, -0.3);  // below, out of the path
  mesh.triangles.push_back({from, to, static_cast<std::uint32_t>(mesh.vertices.size() - 1)});
  Ground succeeded(without, 1.0);
  Ground finned(mesh, 1.0);
  for (Ground* ground : {&succeeded, &finned}) {
    const State start = ground->state_over(ground->geometry().to_local({-0.04, 0.3, 0.01}));
    EXPECT_EQ(ground->run(start, ground->geometry().to_local({0.04, 0.32, -0.1})), ground == &succeeded);
    EXPECT_TRUE(ground->run(start, ground->geometry().to_local({-0.1, 0.32, -0.1})));
  }
}

TEST(FacetDescent, MinimaAtAVertexAreLeftToTheGeneralMethod) {
  Ground ground(make_pit(1.0, 0.2), 1.0);
  const State start = ground.state_over(ground.geometry().to_local({0.11, 0.02, 0.5}));
  EXPECT_TRUE(ground.run(start, start.at + Vec3(0.02, 0.01, -0.03)));
  EXPECT_FALSE(ground.run(start, ground.geometry().to_local({0.0, 0.0, -0.2})));
}

TEST(FacetDescent, SharpEdgesAreLeftToOthers) {
  Ground ground(make_box({0.5, 0.5, 0.5}, 2), 1.0);
  const State start = ground.state_over(ground.geometry().to_local({0.1, 0.03, 0.3}));
  EXPECT_TRUE(ground.run(start, ground.geometry().to_local({0.2, 0.03, 0.2})));
  EXPECT_FALSE(ground.run(start, ground.geometry().to_local({0.26, 0.03, 0.2})));
}

// From each face of many a fan straight over its vertex.
TEST(FacetDescent, RoundACornerItEndsWhereTheReferenceDoes) {
  constexpr unsigned kSeed = 804;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> depth(0.02, 0.4);
  std::size_t runs = 0;
  std::size_t succeeded = 0;
  for (int i = 0; i < 300; ++i) {
    const TriangleMesh mesh = make_fan(4 + i % 7, 1, random);
    Ground ground(mesh, 2.0);
    for (const Triangle& t : mesh.triangles) {
      const Vec3 on = 0.2 * (mesh.vertices[t[1]] + mesh.vertices[t[2]]);
      const Vec3 normal = mesh.vertices[t[1]].cross(mesh.vertices[t[2]]).normalized();
      const State start = ground.state_over(ground.geometry().to_local(on + 1e-6 * normal));
      const Vec3 device = ground.geometry().to_local(-depth(random) * on - depth(random) * normal);
      ++runs;
      if (!ground.run(start, device)) continue;
      ++succeeded;
      EXPECT_EQ(ground.descent().faces().size(), mesh.triangles.size());
      EXPECT_TRUE(ground.descent().met_concave_edge());
      ground.expect_minimum(device);
      ground.expect_connected(start);
      const bool agrees = ground.away_from_reference(start, device) <= kSame || ground.away_from_reference(start, device, 8) <= kSame;
      EXPECT_TRUE(agrees) << "fan " << i;
    }
  }
  EXPECT_GT(succeeded, runs / 8) << "of " << runs;
}

// From a slope down to the middle of a saddle, where a valley leads down on both sides, or on one.
TEST(FacetDescent, AVertexWithSeveralDescentsIsLeftToTheGeneralMethod) {
  for (const bool has_two : {true, false}) {
    TriangleMesh mesh;
    mesh.vertices = {
        {0, 0, 0}, {0.5, -0.2, 0.1}, {0.5, 0.2, 0.1}, {0, 0.5, -0.2}, {-0.5, 0.2, 0.1}, {-0.5, -0.2, 0.1}, {0, -0.5, has_two ? -0.2 : 0.1}};
    for (std::uint32_t i = 1; i <= 6; ++i) mesh.triangles.push_back({0, i, i % 6 + 1});
    Ground ground(mesh, 1.0);
    const State start = ground.state_over(ground.geometry().to_local({0.2, 0.0, 0.06}));
    const Vec3 device = ground.geometry().to_local({0.0, 0.0, -0.3});
    ASSERT_EQ(ground.run(start, device), !has_two);
    if (has_two) continue;
    EXPECT_TRUE(ground.descent().met_concave_edge());
    ground.expect_minimum(device);
    ground.expect_connected(start);
    EXPECT_LE(ground.away_from_reference(start, device), kSame);
  }
}

TEST(FacetDescent, ADeviceOutsideIsLeftToOthers) {
  Ground ground(make_icosphere(0.4, 3), 0.3);
  const State start = ground.state_over(ground.geometry().to_local({0.3, 0.31, 0.32}));
  EXPECT_FALSE(ground.run(start, start.at + 0.01 * start.normals[0]));
  EXPECT_TRUE(ground.run(start, start.at - 0.01 * start.normals[0]));
}

TEST(FacetDescent, APointNotHeldByNeighboursIsLeftToTheGeneralMethod) {
  Ground ground(make_icosphere(0.4, 3), 0.3);
  State start = ground.state_over(ground.geometry().to_local({0.3, 0.31, 0.32}));
  const Vec3 device = start.at - 0.01 * start.normals[0];
  ASSERT_TRUE(ground.run(start, device));
  State nobody = start;
  nobody.triangles.clear();
  EXPECT_FALSE(ground.run(nobody, device));
  State far_away = start;
  far_away.triangles[0] = ground.state_over(ground.geometry().to_local({-0.3, -0.31, -0.32})).triangles[0];
  EXPECT_FALSE(ground.run(far_away, device)) << "not in the triangle cache";
  const State beside = ground.state_over(start.at + Vec3(0.05, -0.05, 0.05));
  State two = start;
  two.triangles.push_back(beside.triangles[0]);
  two.normals.push_back(beside.normals[0]);
  ASSERT_NE(two.triangles[0], two.triangles[1]);
  EXPECT_FALSE(ground.run(two, device)) << "no concave edge between them";
}

TEST(FacetDescent, LeavesStepsBeyondItsMarginToTheSweep) {
  const TriangleMesh mesh = make_icosphere(0.4, 4);
  Ground wide(mesh, 0.2);
  Ground narrow(mesh, 0.05);
  for (Ground* ground : {&wide, &narrow}) {
    const State start = ground->state_over(ground->geometry().to_local({0.3, 0.31, 0.32}));
    const Vec3 device = start.at - 0.05 * start.normals[0] + 0.1 * start.normals[0].unitOrthogonal();
    EXPECT_EQ(ground->run(start, device), ground == &wide);
  }
}

TEST(FacetDescent, TakesNothingFromTheHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "allocations cannot be counted in this build";
  const TriangleMesh mesh = make_icosphere(0.4, 4);
  const TouchGeometry geometry({&mesh});
  TriangleCache cache;
  const Vec3 top = geometry.to_local({0.003, 0.002, 0.4});
  ASSERT_TRUE(cache.rebuild(geometry, Box{top.array() - 0.1, top.array() + 0.1}));
  std::uint32_t slot = 0;
  while (cache.shape(slot).separation(top).feature != Feature::face || cache.shape(slot).separation(top).distance > 0.01) ++slot;
  const Separation s = cache.shape(slot).separation(top);
  const std::array<FacetDescent::Constraint, 1> held = {{{slot, cache.shape(slot).normal(), 0.0}}};
  const AllocationGuard guard;
  FacetDescent descent(cache, kContactOffset, kMargin);
  const bool succeeded = descent.run(s.nearest + kContactOffset * cache.shape(slot).normal(), held, top + Vec3(0.05, 0.03, -0.04));
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_TRUE(succeeded);
  EXPECT_GT(descent.faces().size(), 2U);
}

// A fan that goes round its vertex twice intersects itself: a descent from the vertex must not end below its start.
TEST(FacetDescent, AFanThatGoesRoundTwiceIsLeftToOthers) {
  TriangleMesh mesh;
  mesh.vertices = {{0.0, 0.0, 0.0},
                   {0.44663, 0.22477, -0.23528},
                   {-0.26565, 0.42359, 0.20865},
                   {-0.44281, 0.23220, 0.45982},
                   {-0.42542, -0.26272, 0.45924},
                   {0.47612, -0.15266, -0.23994},
                   {0.03458, 0.49880, -0.19229},
                   {-0.24644, -0.43505, 0.41096}};
  for (std::uint32_t i = 1; i <= 7; ++i) mesh.triangles.push_back({0, i, i % 7 + 1});
  Ground ground(mesh, 2.0);
  const Vec3 on = 0.2 * (mesh.vertices[1] + mesh.vertices[2]);
  const Vec3 normal = mesh.vertices[1].cross(mesh.vertices[2]).normalized();
  const State start = ground.state_over(ground.geometry().to_local(on + 1e-6 * normal));
  bool leads_to_corner = false;
  for (const double depth : {0.1, 0.15, 0.191, 0.2, 0.25}) {
    const Vec3 device = -0.125 * on - depth * normal;
    EXPECT_FALSE(ground.run(start, ground.geometry().to_local(device))) << "depth " << depth;
    leads_to_corner |= ground.descent().faces().size() == 7;
  }
  EXPECT_TRUE(leads_to_corner) << "it never came there";
}

}  // namespace
}  // namespace hapton
