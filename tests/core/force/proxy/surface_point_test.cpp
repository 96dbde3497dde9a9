#include "core/force/proxy/surface_point.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/surface_stage.h"

namespace hapton {
namespace {

using On = SurfacePoint::On;

// Two triangles with a common edge along x. The first extends to -y, with its front up; the second to +y, turned up by the angle.
TriangleMesh make_dihedral(double angle_rad, bool flip_second = false) {
  TriangleMesh mesh;
  mesh.vertices = {{-0.5, 0, 0}, {0.5, 0, 0}, {0, -1, 0}, {0, std::cos(angle_rad), std::sin(angle_rad)}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}};
  if (flip_second) std::swap(mesh.triangles[1][1], mesh.triangles[1][2]);
  return mesh;
}

// A sheet with a fin on an edge in its middle: an edge of three triangles.
TriangleMesh make_finned_sheet() {
  TriangleMesh sheet = make_plane_grid(1.0, 4);
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  for (std::uint32_t v = 0; v < sheet.vertices.size(); ++v) {
    if (sheet.vertices[v].isApprox(Vec3(0.25, 0.0, 0.0), 1e-9)) a = v;
    if (sheet.vertices[v].isApprox(Vec3(0.25, 0.25, 0.0), 1e-9)) b = v;
  }
  sheet.vertices.emplace_back(0.25, 0.1, 0.3);
  sheet.triangles.push_back({a, b, static_cast<std::uint32_t>(sheet.vertices.size() - 1)});
  return sheet;
}

TEST(SurfacePoint, LandsOnTheFrontOnlyOfAOneSidedMaterial) {
  SurfaceStage stage(make_box(Vec3::Constant(1.0), 2), false);
  SurfacePoint& point = stage.point;
  EXPECT_FALSE(point.is_on_surface());
  EXPECT_FALSE(point.land(3, true, stage.middle(3)));
  EXPECT_FALSE(point.is_on_surface());
  EXPECT_FALSE(point.land_on_edge(3, true, 0, stage.on_edge(3, 0, 0.5)));
  EXPECT_FALSE(point.is_on_surface());
  ASSERT_TRUE(point.land(5, false, stage.middle(5)));
  EXPECT_FALSE(point.land(3, true, stage.middle(3)));
  EXPECT_TRUE(point.is_on_surface());  // nothing changed
  EXPECT_EQ(point.a().id, 5U);
  EXPECT_EQ(point.point(), stage.middle(5));
  point.leave();
  EXPECT_FALSE(point.is_on_surface());
}

TEST(SurfacePoint, LandsOnEitherSideOfATwoSidedMaterial) {
  SurfaceStage stage(make_box(Vec3::Constant(1.0), 2));
  for (std::uint32_t t = 0; t < stage.count(); ++t) {
    const Vec3 outwards = stage.middle(t) - stage.local(0, 0, 0);
    ASSERT_TRUE(stage.point.land(t, false, stage.middle(t)));
    EXPECT_EQ(stage.point.on(), On::face);
    EXPECT_GT(stage.point.a().normal().dot(outwards), 0.0);
    EXPECT_GT(stage.point.a().height(stage.middle(t) + outwards), 0.0);
    ASSERT_TRUE(stage.point.land(t, true, stage.middle(t)));
    EXPECT_TRUE(stage.point.a().is_back());
    EXPECT_LT(stage.point.a().normal().dot(outwards), 0.0);
    EXPECT_LT(stage.point.a().height(stage.middle(t) + outwards), 0.0);
  }
}

TEST(SurfacePoint, DoesNotLandOnNorBesideWhatIsNotWalkable) {
  SurfaceStage stage(make_finned_sheet());
  int unwalkable = 0;
  int edges_beside = 0;
  for (std::uint32_t t = 0; t < stage.count(); ++t) {
    const bool walkable = stage.geometry.is_walkable(t);
    unwalkable += walkable ? 0 : 1;
    EXPECT_EQ(stage.point.land(t, false, stage.middle(t)), walkable) << t;
    EXPECT_EQ(stage.point.land(t, true, stage.middle(t)), walkable) << t;
    for (int k = 0; k < 3; ++k) {
      stage.point.leave();
      const TouchGeometry::Adjacent across = stage.geometry.adjacent(t, k);
      const bool both_walkable = walkable && across.exists && stage.geometry.is_walkable(across.id);
      EXPECT_EQ(stage.point.land_on_edge(t, false, k, stage.on_edge(t, k, 0.5)), both_walkable) << t << " edge " << k;
      EXPECT_EQ(stage.point.is_on_surface(), both_walkable);
      if (!walkable || both_walkable) continue;
      ++edges_beside;
      ASSERT_TRUE(stage.point.land(t, false, stage.middle(t)));
      const Vec3 p = stage.on_edge(t, k, 0.25);
      EXPECT_FALSE(stage.point.reach_edge(k, p));  // it stays on the face, just before the edge
      EXPECT_EQ(stage.point.on(), On::face);
      EXPECT_EQ(stage.point.a().id, t);
      expect_near(stage.point.point(), p);
    }
  }
  EXPECT_GE(unwalkable, 3);
  EXPECT_GE(edges_beside, 3);
}

// Finds by bisection where the segment from p to q leaves the triangle. A point is inside if it is left of all three edges.
double find_leaving_time(const ContactTriangle& face, const Vec3& p, const Vec3& q) {
  const auto is_inside = [&](const Vec3& at) {
    for (int k = 0; k < 3; ++k) {
      if (!(face.normal().dot(face.edge(k).cross(at - face.corner(k))) > 0.0)) return false;
    }
    return true;
  };
  double low = 0.0;
  double high = 1.0;
  for (int i = 0; i < 60; ++i) (is_inside(p + 0.5 * (low + high) * (q - p)) ? low : high) = 0.5 * (low + high);
  return is_inside(q) ? 2.0 : high;
}

int nearest_edge(const ContactTriangle& face, const Vec3& p) {
  int best = 0;
  const auto off = [&](int k) { return (p - face.corner(k)).cross(face.edge(k)).norm() / face.length(k); };
  for (int k = 1; k < 3; ++k) best = off(k) < off(best) ? k : best;
  return best;
}

TEST(SurfacePoint, FindsTheExitThatBisectionFinds) {
  std::mt19937_64 random = make_random(11);
  std::uniform_real_distribution<double> share(0.05, 1.0);
  int exits = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    TriangleMesh mesh;
    mesh.vertices = {random_vector(random), random_vector(random), random_vector(random)};
    mesh.triangles = {{0, 1, 2}};
    SurfaceStage stage(mesh);
    const double u = share(random), v = share(random), w = share(random);
    const TouchGeometry& in = stage.geometry;
    const Vec3 p = (u * in.corner(0, 0) + v * in.corner(0, 1) + w * in.corner(0, 2)) / (u + v + w);
    if (!stage.point.land(0, trial % 2 == 1, p)) continue;  // a needle
    const ContactTriangle& face = stage.point.a().shape;
    const Vec3 off = 0.5 * random_vector(random);
    const Vec3 goal = p + off - face.normal().dot(off) * face.normal();
    const double time = find_leaving_time(face, p, goal);
    const SurfacePoint::Exit exit = stage.point.find_exit(goal);
    ASSERT_EQ(exit.edge >= 0, time <= 1.0) << trial;
    if (exit.edge < 0) continue;
    ++exits;
    ASSERT_NEAR(exit.time, time, 1e-9) << trial;
    const Vec3 out = p + time * (goal - p);
    if (nearest_edge(face, out) == exit.edge) continue;  // otherwise it is near a corner, and on both edges
    ASSERT_LT((out - face.corner(exit.edge)).cross(face.edge(exit.edge)).norm(), 1e-9 * face.length(exit.edge)) << trial;
  }
  EXPECT_GT(exits, 600);
}

// A point that came from a vertex can only leave over the opposite edge. A point on an edge leaves over that edge at once.
TEST(SurfacePoint, FindsTheExitFromAVertexAndFromAnEdge) {
  SurfaceStage stage(make_saddle(2, 0.4, 8));
  const Vec3 apex = stage.local(0, 0, 0);
  for (std::uint32_t t = 0; t < stage.count(); ++t) {
    ASSERT_TRUE(stage.stand_at_vertex(apex));
    SurfacePoint& point = stage.point;
    const Vec3 device = apex + 2.0 * (stage.middle(t) - apex);
    const SurfacePoint::Descent way = point.find_steepest(device - apex, 0.0);
    ASSERT_NE(way.facet, nullptr);
    ASSERT_TRUE(way.over_face);
    ASSERT_EQ(way.facet->id, t);
    ASSERT_EQ(point.descend_along(way, device), SurfaceNext::again);
    ASSERT_EQ(point.on(), On::face);
    expect_near(point.point(), apex);
    EXPECT_EQ(point.find_exit(stage.middle(t)).edge, -1);
    const SurfacePoint::Exit exit = point.find_exit(device);
    EXPECT_EQ(exit.edge, (point.corner() + 1) % 3);
    EXPECT_NEAR(exit.time, 0.75, 1e-12);  // the middle is 2/3 of the way to that edge

    ASSERT_TRUE(point.land_on_edge(t, false, point.corner(), stage.on_edge(t, point.corner(), 0.3)));
    const Vec3 back = point.point();
    point.cross_edge();
    const SurfacePoint::Exit returned = point.find_exit(back + 0.3 * (back - (apex + stage.middle(point.a().id)) / 2.0));
    EXPECT_EQ(returned.edge, point.entry_edge());
    EXPECT_LT(returned.time, 1e-12);
  }
}

TEST(SurfacePoint, EveryEdgeOfAClosedMeshJoinsTwoFaces) {
  SurfaceStage stage(make_bumpy_sphere(0.5, 0.2, 1000, 3));
  SurfacePoint& point = stage.point;
  for (std::uint32_t t = 0; t < stage.count(); ++t) {
    for (int k = 0; k < 3; ++k) {
      ASSERT_TRUE(point.land(t, false, stage.middle(t)));
      ASSERT_TRUE(point.reach_edge(k, stage.on_edge(t, k, 0.3) + 1e-3 * point.a().normal()));
      ASSERT_EQ(point.on(), On::edge);
      expect_near(point.point(), stage.on_edge(t, k, 0.3));
      EXPECT_TRUE(point.has_left_a());
      EXPECT_EQ(point.edge(), k);
      const Vec3 at = point.point();
      const std::uint32_t beyond = point.b().id;
      const int other = point.other_edge();
      ASSERT_NE(beyond, t);
      EXPECT_EQ(point.b().shape.corner(other), point.a().shape.corner((k + 1) % 3));
      EXPECT_EQ(point.b().shape.corner((other + 1) % 3), point.a().shape.corner(k));
      point.move_on_edge(0.75);
      expect_near(point.point(), stage.on_edge(t, k, 0.75));
      point.balance_on_edge();
      EXPECT_FALSE(point.has_left_a());
      point.return_from_edge();
      EXPECT_EQ(point.on(), On::face);
      EXPECT_EQ(point.a().id, t);
      EXPECT_EQ(point.entry_edge(), k);
      ASSERT_TRUE(point.reach_edge(k, at));
      point.cross_edge();
      EXPECT_EQ(point.on(), On::face);
      EXPECT_EQ(point.a().id, beyond);
      EXPECT_EQ(point.entry_edge(), other);
      expect_near(point.point(), at);
    }
  }
}

TEST(SurfacePoint, WithinTheSnapDistanceOfAnEndItReachesTheVertex) {
  SurfaceStage stage(make_box(Vec3::Constant(1.0), 2));
  const ContactTriangle face(stage.geometry.corner(0, 0), stage.geometry.corner(0, 1), stage.geometry.corner(0, 2));
  for (int k = 0; k < 3; ++k) {
    for (const int end : {0, 1}) {
      const Vec3 inwards = (end == 0 ? 1.0 : -1.0) / face.length(k) * face.edge(k);
      const Vec3& vertex = face.corner((k + end) % 3);
      ASSERT_TRUE(stage.point.land(0, false, stage.middle(0)));
      ASSERT_TRUE(stage.point.reach_edge(k, vertex + 0.25 * SurfacePoint::kSnap * inwards));
      EXPECT_EQ(stage.point.on(), On::vertex);
      EXPECT_EQ(stage.point.point(), vertex);
      ASSERT_TRUE(stage.point.land(0, false, stage.middle(0)));
      ASSERT_TRUE(stage.point.reach_edge(k, vertex + 64.0 * SurfacePoint::kSnap * inwards));
      EXPECT_EQ(stage.point.on(), On::edge);
    }
  }
}

// Angles in the plane perpendicular to the edge: the first face is at 180 degrees and the second at `angle`. For the front, the angles
// between them are free.
TEST(SurfacePoint, AnEdgeIsConvexAndFreeAsItsDihedralSays) {
  for (const bool flip : {false, true}) {
    for (const double angle : {-3.0, -2.0, -1.0, -0.1, -1e-3, -1e-6, 1e-6, 1e-3, 0.1, 1.0, 2.0, 3.0}) {
      SurfaceStage stage(make_dihedral(angle, flip));
      for (const bool back : {false, true}) {
        ASSERT_TRUE(stage.point.land_on_edge(0, back, 2, stage.on_edge(0, 2, 0.5))) << angle;
        EXPECT_EQ(stage.point.b().id, 1U);
        EXPECT_EQ(stage.point.b().is_back(), back != flip);
        EXPECT_EQ(stage.point.is_convex(), back ? angle > 0.0 : angle < 0.0) << angle << (back ? " back" : " front");
        for (int i = 0; i < 100; ++i) {
          const double at = -std::numbers::pi + 2.0 * std::numbers::pi * (i + 0.5) / 100.0;
          if (std::fabs(at - angle) < 1e-4) continue;
          const Vec3 device = stage.local(0.1, 0.01 * std::cos(at), 0.01 * std::sin(at));
          EXPECT_EQ(stage.point.is_free_over_edge(device), (at > angle) != back) << angle << ", " << at;
        }
      }
    }
  }
}

TEST(SurfacePoint, ABoundaryEdgeIsConvexAndLeadsToTheBack) {
  SurfaceStage stage(make_plane_grid(1.0, 2));
  SurfaceStage one_sided(make_plane_grid(1.0, 2), false);
  int boundaries = 0;
  for (std::uint32_t t = 0; t < stage.count(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 p = stage.on_edge(t, k, 0.5);
      ASSERT_TRUE(stage.point.land_on_edge(t, false, k, p));
      if (stage.point.b().id != t) continue;
      ++boundaries;
      EXPECT_TRUE(stage.point.b().is_back());
      EXPECT_TRUE(stage.point.is_convex());
      EXPECT_FALSE(one_sided.point.land_on_edge(t, false, k, p));  // its back holds nothing
      ASSERT_TRUE(one_sided.point.land(t, false, one_sided.middle(t)));
      EXPECT_FALSE(one_sided.point.load_adjacent(k));
      EXPECT_FALSE(one_sided.point.reach_edge(k, p));
    }
  }
  EXPECT_EQ(boundaries, 8);
}

TEST(SurfacePoint, ReleasedItIsWhereTheDeviceComesThrough) {
  SurfaceStage stage(make_box(Vec3::Constant(1.0), 1));
  ASSERT_TRUE(stage.point.land(0, false, stage.middle(0)));
  const Vec3 normal = stage.point.a().normal();
  const Vec3 p = 0.5 * (stage.middle(0) + stage.geometry.corner(0, 0));
  EXPECT_EQ(stage.point.release(p + SurfacePoint::kClear * normal, p + normal), SurfaceNext::released);
  EXPECT_EQ(stage.point.on(), On::face);
  expect_near(stage.point.point(), p);
}

// A gutter of 90 degrees along z, its bottom at y = 0.2. At the bottom the device may come out in front of one wall and continue behind the
// other.
TEST(SurfacePoint, ReleasedAtAConcaveEdgeItMayGoOn) {
  SurfaceStage stage(make_gutter(1.0, 0.3, 0.5 * std::numbers::pi, 1));
  const Vec3 bottom = stage.local(0, 0.2, 0.1);
  const Vec3 left = stage.local(-1, 1, 0) - stage.local(0, 0, 0);
  int walls = 0;
  for (std::uint32_t t = 0; t < stage.count(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = stage.geometry.to_scene(stage.geometry.corner(t, k));
      const Vec3 b = stage.geometry.to_scene(stage.geometry.corner(t, (k + 1) % 3));
      if (!(std::hypot(a.x(), a.y() - 0.2) < 1e-9 && std::hypot(b.x(), b.y() - 0.2) < 1e-9)) continue;
      ++walls;
      ASSERT_TRUE(stage.point.land(t, false, stage.middle(t)));
      const Vec3 normal = stage.point.a().normal();
      const Vec3 up_the_wall = normal.dot(left) > 0.0 ? Vec3(-left.x(), left.y(), 0) : left;
      EXPECT_EQ(stage.point.release(bottom, bottom + normal + 0.1 * up_the_wall), SurfaceNext::released);
      ASSERT_TRUE(stage.point.land(t, false, stage.middle(t)));
      EXPECT_EQ(stage.point.release(bottom, bottom + normal - 0.1 * up_the_wall), SurfaceNext::again);
      EXPECT_EQ(stage.point.on(), On::edge);
      EXPECT_FALSE(stage.point.has_left_a());
      expect_near(stage.point.point(), bottom);
      ASSERT_TRUE(stage.point.land(t, false, stage.middle(t)));
      EXPECT_EQ(stage.point.release(stage.geometry.corner(t, k), bottom), SurfaceNext::descend);
      EXPECT_EQ(stage.point.on(), On::vertex);
    }
  }
  EXPECT_EQ(walls, 2);
}

TEST(SurfacePoint, InsideIsOffEveryEdge) {
  constexpr double kOff = 1e-6;
  SurfaceStage stage(make_bumpy_sphere(0.5, 0.2, 300, 5));
  for (std::uint32_t t = 0; t < stage.count(); ++t) {
    ASSERT_TRUE(stage.point.land(t, false, stage.middle(t)));
    ASSERT_TRUE(stage.point.reach_vertex(static_cast<int>(t % 3)));
    const Vec3 inside = stage.point.inside(kOff);
    EXPECT_NEAR((inside - stage.point.point()).norm(), kOff, 1e-12);
    const ContactTriangle& face = stage.point.a().shape;
    for (int k = 0; k < 3; ++k) EXPECT_GT(face.inside(k, inside), 0.0);
    EXPECT_NEAR(face.normal().dot(inside - face.corner(0)), 0.0, 1e-14);
  }
}

// The lifted point is above every face that the point is on, and so on the free side of all of them.
TEST(SurfacePoint, LiftedItIsEquallyHighOverEveryFaceItIsOn) {
  constexpr double kHeight = 1e-6;
  SurfaceStage stage(make_bumpy_sphere(0.5, 0.2, 1000, 3));
  SurfacePoint& point = stage.point;
  for (std::uint32_t t = 0; t < stage.count(); ++t) {
    const bool back = t % 2 == 1;
    ASSERT_TRUE(point.land(t, back, stage.middle(t)));
    EXPECT_NEAR(point.a().height(point.lifted(kHeight)), kHeight, 1e-14);
    const int k = static_cast<int>(t % 3);
    ASSERT_TRUE(point.reach_edge(k, stage.on_edge(t, k, 0.4)));
    EXPECT_NEAR(point.a().height(point.lifted(kHeight)), kHeight, 1e-14);
    EXPECT_NEAR(point.b().height(point.lifted(kHeight)), kHeight, 1e-14);
    ASSERT_TRUE(point.reach_vertex(k));
    const Vec3 lift = point.lifted(kHeight) - point.point();
    double least = 1.0;
    for (const SurfacePoint::FanFacet& facet : point.fan()) least = std::min(least, facet.normal.dot(lift));
    EXPECT_NEAR(least, kHeight, 1e-14);  // no higher than it must be
    EXPECT_TRUE(point.is_before_fan(point.point() + lift));
  }
}

TEST(SurfacePoint, LiftedOffAFaceItClearsTheWallBeyondANearConcaveEdge) {
  constexpr double kHeight = 1e-6;
  SurfaceStage stage(make_dihedral(2.5));
  const Vec3 wall(0, -std::sin(2.5), std::cos(2.5));
  for (const double off : {0.0, 0.3e-6, 1e-6, 3e-6, 1e-4}) {
    ASSERT_TRUE(stage.point.land(0, false, stage.local(0, 0, 0) + Vec3(0, -off, 0)));
    const Vec3 lifted = stage.point.lifted(kHeight) - stage.local(0, 0, 0);
    EXPECT_GE(lifted.z(), kHeight * (1.0 - 1e-9)) << off;
    EXPECT_GE(wall.dot(lifted), kHeight * (1.0 - 1e-9)) << off;
    // No higher than necessary: straight up where that clears the wall, otherwise at the same height above it.
    const bool clears = off * std::sin(2.5) + kHeight * std::cos(2.5) >= kHeight;
    EXPECT_NEAR(clears ? lifted.y() + off : wall.dot(lifted) - kHeight, 0.0, 1e-14) << off;
  }
}

Vec3 sum_of(const std::array<SurfacePoint::Contact, 3>& contacts, int count) {
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < count; ++i) sum += contacts[i].multiplier * contacts[i].normal;
  return sum;
}

TEST(SurfacePoint, MultipliersOfContactsAreThoseThatPlacedTheDevice) {
  std::mt19937_64 random = make_random(41);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::array<SurfacePoint::Contact, 3> contacts;
  for (int trial = 0; trial < 200; ++trial) {
    SurfaceStage stage(make_dihedral(0.01 + 3.0 * share(random)));
    ASSERT_TRUE(stage.point.land(0, false, stage.middle(0)));
    const double depth = share(random);
    ASSERT_EQ(stage.point.find_contacts(stage.middle(0) - depth * stage.point.a().normal(), contacts), 1);
    EXPECT_EQ(contacts[0].triangle, 0U);
    EXPECT_NEAR(contacts[0].multiplier, depth, 1e-14);

    ASSERT_TRUE(stage.point.land_on_edge(0, false, 2, stage.on_edge(0, 2, share(random))));
    const double of_a = share(random), of_b = share(random);
    const Vec3 device = stage.point.point() - of_a * stage.point.a().normal() - of_b * stage.point.b().normal();
    ASSERT_EQ(stage.point.find_contacts(device, contacts), 2);
    EXPECT_EQ(contacts[0].triangle, stage.point.a().id);
    EXPECT_EQ(contacts[1].triangle, stage.point.b().id);
    EXPECT_NEAR(contacts[0].multiplier, of_a, 1e-10);
    EXPECT_NEAR(contacts[1].multiplier, of_b, 1e-10);
    expect_near(sum_of(contacts, 2), stage.point.point() - device, 1e-11);  // nearly flat, the two normals are hard to tell apart
  }
}

TEST(SurfacePoint, MultipliersAtTheBottomOfAPitSumUpToThePull) {
  std::mt19937_64 random = make_random(43);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  SurfaceStage stage(make_pit(1.0, 0.5));
  ASSERT_TRUE(stage.stand_at_vertex(stage.local(0, 0, 0)));
  std::array<SurfacePoint::Contact, 3> contacts;
  for (int trial = 0; trial < 500; ++trial) {
    Vec3 device = stage.point.point();
    for (const SurfacePoint::FanFacet& facet : stage.point.fan()) device -= share(random) * facet.normal;
    ASSERT_EQ(stage.point.find_steepest(device - stage.point.point(), 1e-12).facet, nullptr);  // the vertex is a local minimum
    const int count = stage.point.find_contacts(device, contacts);
    ASSERT_GE(count, 1);
    expect_near(sum_of(contacts, count), stage.point.point() - device);
    for (int i = 0; i < count; ++i) EXPECT_GE(contacts[i].multiplier, 0.0);
  }
}

}  // namespace
}  // namespace hapton
