#include "core/collision/surface_adjacency.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "core/geometry/closest_point.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

constexpr double kMargin = 1e-9;

std::array<Vec3, 3> corners(const TriangleMesh& mesh, std::size_t t) { return {mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)}; }

SurfaceAdjacency adjacency_of(const TriangleMesh& mesh, std::size_t* tested_pairs = nullptr) {
  std::vector<Box> boxes;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Box box;
    for (int k = 0; k < 3; ++k) box.grow(mesh.corner(t, k));
    boxes.push_back(box);
  }
  SurfaceAdjacency adjacency(mesh.vertices.size(), mesh.triangles);
  const std::size_t count = adjacency.find_walkable(mesh.vertices, mesh.triangles, WideBvh(boxes), kMargin);
  if (tested_pairs != nullptr) *tested_pairs = count;
  return adjacency;
}

// Crossing an edge and crossing it back leads to the same side of the same triangle.
void expect_edges_lead_back(const TriangleMesh& mesh, const SurfaceAdjacency& adjacency) {
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const SurfaceAdjacency::Adjacent there = adjacency.adjacent(t, k);
      if (!there.exists) continue;
      const SurfaceAdjacency::Adjacent back = adjacency.adjacent(there.triangle, there.edge);
      EXPECT_TRUE(back.exists);
      EXPECT_EQ(back.triangle, t);
      EXPECT_EQ(back.edge, k);
      EXPECT_EQ(back.flips, there.flips);
    }
  }
}

TEST(SurfaceAdjacency, AClosedSurfaceIsWalkableAndKeepsItsSide) {
  for (const TriangleMesh& mesh : {make_icosphere(0.5, 3), make_box(Vec3(0.6, 0.5, 0.4), 3), make_torus(0.35, 0.15, 40, 20),
                                   make_bumpy_sphere(0.5, 0.2, 5000, 3), make_gutter(1.0, 0.5, 0.01, 4), make_thin_wall(1.0, 0.01, 4)}) {
    const SurfaceAdjacency adjacency = adjacency_of(mesh);
    EXPECT_EQ(adjacency.walkable_count(), mesh.triangles.size());
    expect_edges_lead_back(mesh, adjacency);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) {
        EXPECT_TRUE(adjacency.adjacent(t, k).exists);
        EXPECT_FALSE(adjacency.adjacent(t, k).flips);
        EXPECT_NE(adjacency.adjacent(t, k).triangle, t);
      }
    }
  }
}

TEST(SurfaceAdjacency, ABoundaryEdgeLeadsToTheBackOfItsOwnTriangle) {
  const TriangleMesh sheet = make_plane_grid(1.0, 4);
  const SurfaceAdjacency adjacency = adjacency_of(sheet);
  EXPECT_EQ(adjacency.walkable_count(), sheet.triangles.size());
  expect_edges_lead_back(sheet, adjacency);
  int boundary_edges = 0;
  for (std::uint32_t t = 0; t < sheet.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const SurfaceAdjacency::Adjacent adjacent = adjacency.adjacent(t, k);
      if (adjacent.triangle != t) continue;
      EXPECT_TRUE(adjacent.flips);
      EXPECT_EQ(adjacent.edge, k);
      ++boundary_edges;
    }
  }
  EXPECT_EQ(boundary_edges, 16);  // four sides of four cells
}

TEST(SurfaceAdjacency, AFlippedTriangleIsReachedOnItsBack) {
  TriangleMesh ball = make_icosphere(0.5, 2);
  std::swap(ball.triangles[7][1], ball.triangles[7][2]);
  const SurfaceAdjacency adjacency = adjacency_of(ball);
  EXPECT_EQ(adjacency.walkable_count(), ball.triangles.size());
  expect_edges_lead_back(ball, adjacency);
  for (int k = 0; k < 3; ++k) EXPECT_TRUE(adjacency.adjacent(7, k).flips);
}

TEST(SurfaceAdjacency, AnEdgeOfThreeTrianglesHasNoNeighbours) {
  TriangleMesh mesh = make_box(Vec3::Constant(0.5), 1);
  const Triangle first = mesh.triangles[0];
  mesh.vertices.emplace_back(1.0, 1.0, 1.0);
  mesh.triangles.push_back({first[0], first[1], static_cast<std::uint32_t>(mesh.vertices.size() - 1)});
  const SurfaceAdjacency adjacency = adjacency_of(mesh);
  EXPECT_FALSE(adjacency.adjacent(0, 0).exists);
  EXPECT_FALSE(adjacency.is_walkable(0));
  EXPECT_LT(adjacency.walkable_count(), mesh.triangles.size());
}

TEST(SurfaceAdjacency, TwoCopiesOfATriangleAreNotWalkable) {
  TriangleMesh ball = make_icosphere(0.5, 2);
  ball.triangles.push_back(ball.triangles[5]);
  const SurfaceAdjacency adjacency = adjacency_of(ball);
  EXPECT_FALSE(adjacency.is_walkable(5));
  EXPECT_FALSE(adjacency.is_walkable(static_cast<std::uint32_t>(ball.triangles.size() - 1)));
}

TEST(SurfaceAdjacency, TwoConesThatShareTheirTipAreNotWalkableThere) {
  const TriangleMesh cone{.vertices = {{0, 0, 0}, {1, 0, 1}, {0, 1, 1}, {-1, -1, 1}},
                          .triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}}};
  TriangleMesh both = cone;
  for (int k = 1; k < 4; ++k) both.vertices.emplace_back(-cone.vertices[k]);
  for (const Triangle& t : cone.triangles) {
    const auto mirrored = [](std::uint32_t v) { return v == 0 ? 0U : v + 3; };
    both.triangles.push_back({mirrored(t[0]), mirrored(t[2]), mirrored(t[1])});
  }
  const SurfaceAdjacency adjacency = adjacency_of(both);
  // The fourth triangle of each cone is its base, away from the tip.
  for (std::uint32_t t = 0; t < both.triangles.size(); ++t) EXPECT_EQ(adjacency.is_walkable(t), t % 4 == 3) << t;
}

// A circuit of one fan, over front and back, has two steps: as many as triangles meet at the vertex, but they are not one closed fan.
TEST(SurfaceAdjacency, TwoOpenFansThatShareAVertexAreNotWalkable) {
  const TriangleMesh mesh{.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, .triangles = {{0, 1, 2}, {0, 3, 4}}};
  EXPECT_EQ(adjacency_of(mesh).walkable_count(), 0U);
}

// Expected: a triangle is walkable if it is apart from every triangle that shares no vertex with it. The test compares every pair.
TEST(SurfaceAdjacency, WhereSurfacesMeetNothingIsWalkable) {
  const TriangleMesh mesh = joined(make_icosphere(0.3, 3), scaled_and_moved(make_icosphere(0.3, 3), 1.0, Vec3(0.31, 0.07, 0.02)));
  const SurfaceAdjacency adjacency = adjacency_of(mesh);
  std::vector<bool> meets(mesh.triangles.size(), false);
  for (std::size_t s = 0; s < mesh.triangles.size(); ++s) {
    for (std::size_t t = 0; t < s; ++t) {
      const bool shares_vertex = std::any_of(mesh.triangles[s].begin(), mesh.triangles[s].end(), [&](std::uint32_t v) {
        return std::find(mesh.triangles[t].begin(), mesh.triangles[t].end(), v) != mesh.triangles[t].end();
      });
      if (shares_vertex || are_apart(corners(mesh, s), corners(mesh, t), kMargin)) continue;
      meets[s] = true;
      meets[t] = true;
    }
  }
  EXPECT_GT(std::count(meets.begin(), meets.end(), true), 50);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) EXPECT_EQ(adjacency.is_walkable(t), !meets[t]) << t;
}

TEST(SurfaceAdjacency, ACrackNarrowerThanTheMarginIsNotWalkableAWiderOneIs) {
  for (const double width : {0.1 * kMargin, 10.0 * kMargin}) {
    const TriangleMesh left = make_plane_grid(0.5, 2);
    const TriangleMesh mesh = joined(left, scaled_and_moved(left, 1.0, Vec3(0.5 + width, 0.0, 0.0)));
    EXPECT_EQ(adjacency_of(mesh).walkable_count() == mesh.triangles.size(), width > kMargin);
  }
}

TEST(SurfaceAdjacency, AVertexOfTooManyTrianglesIsNotWalkable) {
  EXPECT_EQ(adjacency_of(make_cylinder(0.5, 0.4, SurfaceAdjacency::kMaxValence - 2, 2)).walkable_count(),
            make_cylinder(0.5, 0.4, SurfaceAdjacency::kMaxValence - 2, 2).triangles.size());
  const TriangleMesh wheel = make_cylinder(0.5, 0.4, SurfaceAdjacency::kMaxValence + 2, 2);
  EXPECT_LT(adjacency_of(wheel).walkable_count(), wheel.triangles.size());
}

// --- Brute-force twin: every triangle against every other, without the tree and without the shortcut for even fans -------------------

bool has_vertex(const Triangle& t, std::uint32_t v) { return std::find(t.begin(), t.end(), v) != t.end(); }
bool has_repeated_vertex(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

// Whether the triangles at a vertex are connected by edges that at most two of them share.
bool is_one_fan(const TriangleMesh& mesh, std::uint32_t vertex) {
  std::vector<std::uint32_t> at_vertex;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (has_vertex(mesh.triangles[t], vertex) && !has_repeated_vertex(mesh.triangles[t])) at_vertex.push_back(t);
  }
  if (at_vertex.empty() || at_vertex.size() > static_cast<std::size_t>(SurfaceAdjacency::kMaxValence)) return false;
  std::vector<std::uint32_t> reached = {at_vertex[0]};
  for (std::size_t i = 0; i < reached.size(); ++i) {
    for (const std::uint32_t v : mesh.triangles[reached[i]]) {
      if (v == vertex) continue;
      std::vector<std::uint32_t> at_edge;
      for (const std::uint32_t t : at_vertex) {
        if (has_vertex(mesh.triangles[t], v)) at_edge.push_back(t);
      }
      if (at_edge.size() > 2) return false;
      for (const std::uint32_t t : at_edge) {
        if (std::find(reached.begin(), reached.end(), t) == reached.end()) reached.push_back(t);
      }
    }
  }
  return reached.size() == at_vertex.size();
}

void expect_as_brute_force(const TriangleMesh& mesh, const char* name) {
  std::vector<bool> one_fan(mesh.vertices.size());
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) one_fan[v] = is_one_fan(mesh, v);
  std::vector<bool> walkable(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = mesh.triangles[t];
    const auto [p, q, r] = corners(mesh, t);
    const double longest = std::max({(q - p).norm(), (r - q).norm(), (p - r).norm()});
    walkable[t] = !has_repeated_vertex(mesh.triangles[t]) && one_fan[a] && one_fan[b] && one_fan[c] &&
                  (q - p).cross(r - p).norm() >= SurfaceAdjacency::kMinHeight * longest;
  }
  for (std::size_t s = 0; s < mesh.triangles.size(); ++s) {
    for (std::size_t t = 0; t < s; ++t) {
      if (is_pair_walkable(mesh.vertices, mesh.triangles[s], mesh.triangles[t], kMargin)) continue;
      walkable[s] = false;
      walkable[t] = false;
    }
  }
  const SurfaceAdjacency adjacency = adjacency_of(mesh);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) ASSERT_EQ(adjacency.is_walkable(t), walkable[t]) << name << ": triangle " << t;
}

// A fan that goes round its vertex `turns` times. The vertices of its rim lie `lift` above and `lift` below it in turn. Every
// `flipped_every`-th triangle is flipped; 0: none.
TriangleMesh make_fan(int triangles, int turns, double lift, int flipped_every) {
  TriangleMesh mesh{.vertices = {Vec3::Zero()}, .triangles = {}};
  for (int i = 0; i < triangles; ++i) {
    const double angle = 2.0 * 3.14159265358979 * turns * i / triangles + 0.1;
    mesh.vertices.emplace_back(0.4 * std::cos(angle), 0.4 * std::sin(angle), (i % 2 == 0 ? lift : -lift));
    const auto here = static_cast<std::uint32_t>(i + 1);
    const auto next = static_cast<std::uint32_t>((i + 1) % triangles + 1);
    mesh.triangles.push_back(flipped_every > 0 && i % flipped_every == 0 ? Triangle{0, next, here} : Triangle{0, here, next});
  }
  return mesh;
}

TEST(SurfaceAdjacency, WalkableTrianglesAgreeWithBruteForce) {
  const TriangleMesh ball = make_icosphere(0.3, 2);
  const TriangleMesh box = make_box(Vec3(0.3, 0.2, 0.1), 2);
  expect_as_brute_force(ball, "sphere");
  expect_as_brute_force(make_bumpy_sphere(0.4, 0.6, 1000, 5), "bumpy");
  expect_as_brute_force(joined(ball, scaled_and_moved(ball, 1.0, Vec3(0.21, 0.07, 0.02))), "two spheres that intersect");
  expect_as_brute_force(joined(box, scaled_and_moved(box, 1.0, Vec3(0.3, 0.0, 0.0))), "two boxes that touch");
  expect_as_brute_force(joined(box, scaled_and_moved(box, 0.5, Vec3(0.05, 0.05, 0.02))), "a box in a box");
  expect_as_brute_force(joined(ball, ball), "a sphere twice");
  for (const int triangles : {3, 4, 7, 12, 24, 128, 129}) {
    for (const int turns : {1, 2, 3}) {
      for (const double lift : {0.0, 0.02, 0.3, 3.0}) expect_as_brute_force(make_fan(triangles, turns, lift, 0), "fan");
      expect_as_brute_force(make_fan(triangles, turns, 0.05, 2), "fan of both windings");
    }
  }
  TriangleMesh mixed = ball;
  for (std::size_t t = 0; t < mixed.triangles.size(); t += 3) std::swap(mixed.triangles[t][0], mixed.triangles[t][1]);
  expect_as_brute_force(mixed, "mixed winding");
  TriangleMesh repeated = ball;
  for (std::uint32_t v = 0; v < 20; ++v) repeated.triangles.push_back({v, v, (v * 7 + 1) % 40});
  expect_as_brute_force(repeated, "triangles of two corners");
}

// Pleats so steep that no fan is even: the normals are more than 60 degrees from the axis of the fan.
TEST(SurfaceAdjacency, FewPairsAreTestedWhereThousandsOfTrianglesMeet) {
  for (const double lift : {0.02, 0.3, 3.0}) {
    std::size_t tested_pairs = 0;
    const TriangleMesh mesh = make_fan(4000, 1, lift, 0);
    EXPECT_EQ(adjacency_of(mesh, &tested_pairs).walkable_count(), mesh.triangles.size());
    EXPECT_LT(tested_pairs, 8 * mesh.triangles.size()) << "lift " << lift;
  }
}

// The triangles beside a thin one are nearer to each other than kMinAngle, although the fan is flat and goes round once.
TEST(SurfaceAdjacency, BesideAThinTriangleNothingIsWalkable) {
  for (const double factor : {0.5, 2.0}) {
    TriangleMesh mesh = make_fan(7, 1, 0.0, 0);
    const double angle = std::atan2(mesh.vertices[1].y(), mesh.vertices[1].x()) + factor * SurfaceAdjacency::kMinAngle;
    mesh.vertices[2] = 0.4 * Vec3(std::cos(angle), std::sin(angle), 0.0);
    expect_as_brute_force(mesh, "thin");
    const SurfaceAdjacency adjacency = adjacency_of(mesh);
    for (const std::uint32_t neighbour : {1U, 6U}) EXPECT_EQ(adjacency.is_walkable(neighbour), factor > 1.0) << factor;
  }
}

// Large fans that go once or twice round: some triangles are folded onto others, moved, or repeat a vertex; some fans meet a sphere.
TEST(SurfaceAdjacency, WalkableTrianglesAgreeWithBruteForceInLargeFans) {
  std::mt19937_64 random(240);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int round = 0; round < 24; ++round) {
    TriangleMesh mesh = make_fan(90 + 7 * round, 1 + round % 2, round % 3 == 0 ? 0.4 : 0.01, round % 5 == 4 ? 3 : 0);
    const double noise = std::pow(10.0, -round % 8);
    for (std::size_t v = 1; v < mesh.vertices.size(); ++v) {
      Vec3& p = mesh.vertices[v];
      if (round % 4 == 1) p *= 0.2 + unit(random);
      if (round % 4 == 2 && unit(random) < 0.1) p = mesh.vertices[1 + random() % (v > 1 ? v - 1 : 1)] * (1.0 + noise * unit(random));
      if (round % 4 == 3) p += noise * Vec3(unit(random), unit(random), unit(random));
    }
    if (round % 6 == 5) mesh.triangles.push_back({0, 0, 5});
    if (round % 7 == 6) mesh = joined(mesh, scaled_and_moved(make_icosphere(0.1, 1), 1.0, Vec3(0.3, 0.0, 0.0)));
    expect_as_brute_force(mesh, "large fan, seed 240");
  }
}

// Eighty triangles around a tip at the origin, counter-clockwise as seen from above. The vertices of the rim are at height z, except the
// first one, which is at first_z. The tip is corner t % 3 of triangle t.
TriangleMesh fan_with_rim_at(double z, double first_z) {
  constexpr std::uint32_t kCount = 80;
  static_assert(kCount > SurfaceAdjacency::kLargeFan);
  TriangleMesh fan;
  fan.vertices.emplace_back(Vec3::Zero());
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kCount;
    fan.vertices.emplace_back(0.5 * std::cos(angle), 0.5 * std::sin(angle), i == 0 ? first_z : z);
    Triangle triangle = {0, 1 + i, 1 + (i + 1) % kCount};
    std::rotate(triangle.begin(), triangle.begin() + (3 - i % 3) % 3, triangle.end());
    fan.triangles.push_back(triangle);
  }
  return fan;
}

TEST(SurfaceAdjacency, ALargeFanIsConvexFromASideWhereNoFaceRisesAboveAnother) {
  struct Case {
    double z, first_z;
    bool convex_from_front, convex_from_back;
  };
  for (const Case& one : {Case{0.0, 0.0, true, true}, Case{-0.1, -0.1, true, false}, Case{0.1, 0.1, false, true},
                          Case{0.0, 0x1p-52, true, true}, Case{0.0, -0x1p-52, true, true}, Case{0.0, 0x1p-40, false, false},
                          Case{0.0, -0x1p-40, false, false}, Case{-0.1, 0.1, false, false}}) {
    const TriangleMesh fan = fan_with_rim_at(one.z, one.first_z);
    const SurfaceAdjacency adjacency = adjacency_of(fan);
    EXPECT_TRUE(adjacency.has_large_fans());
    for (std::uint32_t t = 0; t < fan.triangles.size(); ++t) {
      EXPECT_TRUE(adjacency.is_in_large_fan(t));
      ASSERT_EQ(adjacency.convex_fan_corner(t, false), one.convex_from_front ? static_cast<int>(t % 3) : -1) << one.z << " " << one.first_z;
      ASSERT_EQ(adjacency.convex_fan_corner(t, true), one.convex_from_back ? static_cast<int>(t % 3) : -1) << one.z << " " << one.first_z;
    }
  }
  const SurfaceAdjacency sphere = adjacency_of(make_icosphere(0.5, 1));
  EXPECT_FALSE(sphere.has_large_fans());
  EXPECT_EQ(sphere.convex_fan_corner(0, false), -1);
}

TEST(SurfaceAdjacency, LargeFansMayShareTrianglesAndTouchANonManifoldEdge) {
  for (const bool has_fin : {false, true}) {
    TriangleMesh mesh;
    constexpr std::uint32_t kRimVertices = 80;
    mesh.vertices = {{0.5, 0.0, 0.0}, {0.0, 0.0, 0.0}};  // middles of two discs; each is on the rim of the other one
    for (std::uint32_t i = 1; i < kRimVertices; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / kRimVertices;
      mesh.vertices.emplace_back(0.5 * std::cos(angle), 0.5 * std::sin(angle), 0.0);
    }
    const auto rim_vertex = [](std::uint32_t i) { return i % kRimVertices == 0 ? 0U : 1U + i % kRimVertices; };
    for (std::uint32_t i = 0; i < kRimVertices; ++i) mesh.triangles.push_back({1, rim_vertex(i), rim_vertex(i + 1)});
    const auto second_rim = static_cast<std::uint32_t>(mesh.vertices.size());
    for (std::uint32_t i = 0; i < kRimVertices; ++i) {
      const double angle = std::numbers::pi * (-0.45 + 0.9 * i / (kRimVertices - 1));
      mesh.vertices.emplace_back(0.5 + 0.3 * std::cos(angle), 0.3 * std::sin(angle), 0.0);
    }
    for (std::uint32_t i = 0; i + 1 < kRimVertices; ++i) mesh.triangles.push_back({0, second_rim + i, second_rim + i + 1});
    mesh.triangles.push_back({0, second_rim + kRimVertices - 1, rim_vertex(1)});
    mesh.triangles.push_back({0, rim_vertex(kRimVertices - 1), second_rim});
    if (has_fin) {  // at a rim edge of the first disc: no neighbour there, though the fan is even
      mesh.vertices.emplace_back(0.5, 0.05, 0.3);
      mesh.triangles.push_back({0, rim_vertex(1), static_cast<std::uint32_t>(mesh.vertices.size()) - 1});
    }
    expect_as_brute_force(mesh, has_fin ? "two discs and a fin" : "two discs");
  }
}

// Random triangles over few vertices: edges of many triangles, folded pairs, copies, pairs of every kind.
TEST(SurfaceAdjacency, WalkableTrianglesAgreeWithBruteForceInASoup) {
  std::mt19937_64 random(77);
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  for (int round = 0; round < 60; ++round) {
    TriangleMesh soup;
    const std::uint32_t vertices = round % 2 == 0 ? 12 : 300;
    for (std::uint32_t v = 0; v < vertices; ++v) soup.vertices.emplace_back(place(random), place(random), place(random) * (round % 3));
    for (int t = 0; t < 40; ++t) {
      soup.triangles.push_back({static_cast<std::uint32_t>(random() % vertices), static_cast<std::uint32_t>(random() % vertices),
                                static_cast<std::uint32_t>(random() % vertices)});
    }
    if (round % 4 == 0) soup = joined(make_icosphere(0.4, 1), soup);
    expect_as_brute_force(soup, "soup, seed 77");
  }
}

// Compares with the distances of points sampled densely on the first triangle from the second.
TEST(AreApart, IsTrueOnlyWhereTheDistanceIsAboveTheMargin) {
  std::mt19937_64 random(41);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  const auto draw = [&] { return Vec3(place(random), place(random), place(random)); };
  int apart_count = 0;
  for (int i = 0; i < 400; ++i) {
    const std::array<Vec3, 3> a = {draw(), draw(), draw()};
    const std::array<Vec3, 3> b = {draw(), draw(), draw()};
    const double margin = 0.2;
    double sampled_distance = 1e9;
    for (int u = 0; u <= 24; ++u) {
      for (int v = 0; u + v <= 24; ++v) {
        const Vec3 p = a[0] + u / 24.0 * (a[1] - a[0]) + v / 24.0 * (a[2] - a[0]);
        sampled_distance = std::min(sampled_distance, closest_point(b[0], b[1], b[2], p).distance);
      }
    }
    const bool is_apart = are_apart(a, b, margin);
    if (is_apart) {
      EXPECT_GT(sampled_distance, margin) << i;
    } else {
      EXPECT_LT(sampled_distance, margin + 0.1) << i;  // 0.1: for the distance between samples
    }
    apart_count += is_apart ? 1 : 0;
  }
  EXPECT_GT(apart_count, 50);
  EXPECT_LT(apart_count, 350);
}

}  // namespace
}  // namespace hapton
