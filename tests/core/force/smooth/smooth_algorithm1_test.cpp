// Algorithm 1 of the FDH paper is compared with a literal transcription of the pseudocode of the paper: independent code, which keeps the
// divisions and the order of the paper.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "core/force/smooth/smooth_force.h"
#include "core/force/smooth/smooth_scene.h"
#include "core/geometry/closest_point.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kStiffnessNPerM = 800.0;

std::vector<SetTriangle> one_sided_set_of(const TriangleMesh& mesh) {
  TouchScene scene;
  scene.objects.push_back({made::shared(mesh), {.stiffness_n_per_m = kStiffnessNPerM, .two_sided = false}});
  const auto built = SmoothScene::build(scene, {});
  std::vector<SetTriangle> all;
  built->for_each([&all](const SetTriangle& t) { all.push_back(t); });
  return all;
}

struct Transcribed {
  Vec3 force = Vec3::Zero();
  double maxforce = 0.0;
  int vcps = 0;
  int hidden = 0;
};

struct Vcp {
  const SetTriangle* T;
  Vec3 D;
  Vec3 s;
};

// "nearestpoint(edge(T, i), P)"
Vec3 nearestpoint(const Vec3& a, const Vec3& b, const Vec3& P) {
  const double t = (P - a).dot(b - a) / (b - a).dot(b - a);
  return t <= 0.0 ? a : t >= 1.0 ? b : Vec3(a + t * (b - a));
}

// "interpolation(T, i, B)": interpolates the vertex normals linearly.
Vec3 interpolation(const Vec3& a, const Vec3& b, const Vec3& na, const Vec3& nb, const Vec3& B) {
  const double t = (B - a).norm() / (b - a).norm();
  return ((1.0 - t) * na + t * nb).normalized();
}

// Whether the open line from D to P passes through a triangle: by barycentric coordinates, unlike StraightLine.
bool passes_through(const Vec3& D, const Vec3& P, const SetTriangle& T) {
  const Vec3 n = (T.corner[1] - T.corner[0]).cross(T.corner[2] - T.corner[0]);
  const double from = n.dot(D - T.corner[0]);
  const double to = n.dot(P - T.corner[0]);
  if (from == to) return false;
  const double at = from / (from - to);
  if (!(at > 1e-6 && at < 1.0 - 1e-6)) return false;
  const Vec3 X = D + at * (P - D);
  for (int k = 0; k < 3; ++k) {
    if (n.cross(T.corner[(k + 1) % 3] - T.corner[k]).dot(X - T.corner[k]) < 0.0) return false;
  }
  return true;
}

// One triangle's part of the loop, in the paper's order. Faces only: degenerate triangles have no plane of their own.
bool find_transcribed_vcp(const SetTriangle& T, const Vec3& P, double RADIUS, double layer, Vcp& vcp) {
  const Vec3 normal = (T.corner[1] - T.corner[0]).cross(T.corner[2] - T.corner[0]).normalized();
  const double height = normal.dot(P - T.corner[0]);
  const double d = std::copysign(closest_point(T.corner[0], T.corner[1], T.corner[2], P).distance, height);  // distance(P, T)
  if (!(d > 0.0 && d < RADIUS)) return false;
  std::array<Vec3, 3> ni;
  std::array<double, 3> di;
  for (int i = 0; i < 3; ++i) {
    const Vec3& a = T.corner[i];
    const Vec3& b = T.corner[(i + 1) % 3];
    const Vec3 B = nearestpoint(a, b, P);
    ni[i] = interpolation(a, b, T.normal[i], T.normal[(i + 1) % 3], B);
    di[i] = ni[i].cross(b - a).normalized().dot(P - B);  // R = plane(B, n_i, edge(T, i)); distance(P, R)
  }
  if (!(di[0] >= 0.0 && di[1] >= 0.0 && di[2] >= 0.0)) return false;
  const Vec3 n = ni[0] / di[0] + ni[1] / di[1] + ni[2] / di[2];
  const Vec3 D = P - (height / n.dot(normal)) * n;  // intersection(n, T)
  const Vec3 DP = P - D;
  if (!(DP.norm() < RADIUS)) return false;
  vcp = {&T, D, std::max(0.0, kStiffnessNPerM * (layer - DP.norm())) * DP.normalized()};
  return true;
}

Transcribed algorithm1(const std::vector<SetTriangle>& object, const Vec3& P, double RADIUS, double layer) {
  std::vector<Vcp> vcps;
  for (const SetTriangle& T : object) {
    Vcp vcp;
    if (find_transcribed_vcp(T, P, RADIUS, layer, vcp)) vcps.push_back(vcp);
  }
  Transcribed result;
  result.vcps = static_cast<int>(vcps.size());
  for (const Vcp& vcp : vcps) {
    const bool hidden = std::any_of(vcps.begin(), vcps.end(),  // fig. 3
                                    [&](const Vcp& other) { return other.T != vcp.T && passes_through(vcp.D, P, *other.T); });
    if (hidden) {
      ++result.hidden;
      continue;
    }
    result.force += vcp.s;
    result.maxforce = std::max(result.maxforce, vcp.s.norm());
  }
  if (result.force.norm() > 0.0) result.force = result.force / result.force.norm() * result.maxforce;
  return result;
}

// At 1,500 positions within RADIUS of a surface: force, number of VCPs and number of hidden VCPs are those of the transcription.
void expect_as_transcribed(const TriangleMesh& mesh, double RADIUS, double layer, std::uint64_t seed, int min_hidden) {
  const auto triangles = one_sided_set_of(mesh);
  ASSERT_TRUE(std::all_of(triangles.begin(), triangles.end(), [](const SetTriangle& t) { return t.kind == SurfaceKind::face; }))
      << "degenerate triangles are not in the transcription";
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int positions_with_several_vcps = 0;
  int hidden = 0;
  for (int i = 0; i < 1500; ++i) {
    const SetTriangle& T = triangles[random() % triangles.size()];
    const double u = unit(random);
    const double v = (1.0 - u) * unit(random);
    const Vec3 X = T.corner[0] + u * (T.corner[1] - T.corner[0]) + v * (T.corner[2] - T.corner[0]);
    const Vec3 P = X + RADIUS * (0.02 + 0.95 * unit(random)) * T.face_normal;
    const Transcribed expected = algorithm1(triangles, P, RADIUS, layer);
    SmoothForceSum sum(P, RADIUS);
    for (const SetTriangle& t : triangles) sum.add(t);
    const SmoothForce felt = sum.combine(layer, std::array{Material{.stiffness_n_per_m = kStiffnessNPerM}});
    ASSERT_EQ(felt.over_capacity, 0U);
    EXPECT_EQ(felt.vcps, static_cast<std::uint32_t>(expected.vcps)) << i;
    EXPECT_EQ(felt.hidden, static_cast<std::uint32_t>(expected.hidden)) << i;
    EXPECT_LT((felt.force_n - expected.force).norm(), 1e-9 * kStiffnessNPerM * layer) << i;
    positions_with_several_vcps += felt.vcps > 1 ? 1 : 0;
    hidden += static_cast<int>(felt.hidden);
  }
  EXPECT_GE(hidden, min_hidden);
  if (min_hidden > 0) {
    EXPECT_GT(positions_with_several_vcps, 100);
  }
}

TEST(Algorithm1, IsThePapersOnASphere) { expect_as_transcribed(make_icosphere(0.05, 3), 0.004, 0.004, 201, 0); }

TEST(Algorithm1, IsThePapersOnABumpyBody) { expect_as_transcribed(make_bumpy_sphere(0.05, 0.05, 5000, 3), 0.003, 0.003, 202, 0); }

TEST(Algorithm1, IsThePapersWithALayerInsideRadius) { expect_as_transcribed(make_icosphere(0.05, 3), 0.004, 0.0025, 203, 0); }

// Fig. 3: four sheets, each RADIUS / 4 above the next and rotated, so that most VCPs are hidden under another triangle.
TEST(Algorithm1, IsThePapersOnOverlappingTriangles) {
  TriangleMesh sheets;
  for (int k = 0; k < 4; ++k) {
    TriangleMesh sheet = make_plane_grid(0.05, 5);
    const double angle = 0.37 * k;
    for (Vec3& v : sheet.vertices) {
      v = Vec3(std::cos(angle) * v.x() - std::sin(angle) * v.y(), std::sin(angle) * v.x() + std::cos(angle) * v.y(), 0.001 * k);
    }
    sheets = k == 0 ? sheet : joined(sheets, sheet);
  }
  expect_as_transcribed(sheets, 0.004, 0.004, 204, 500);
}

// Fig. 1: an edge whose faces disagree on the normal has two degenerate triangles, each with two different points; others have none.
// Without them there is no force over the edge; with them the force turns from one face's normal to the other's and keeps its magnitude.
TEST(Algorithm1, DegenerateTrianglesTurnTheForceRoundAnEdge) {
  TriangleMesh roof;
  roof.vertices = {Vec3(-0.02, -0.02, -0.02), Vec3(-0.02, 0.02, -0.02), Vec3(0, -0.02, 0),
                   Vec3(0, 0.02, 0),          Vec3(0.02, -0.02, -0.02), Vec3(0.02, 0.02, -0.02)};
  roof.triangles = {{0, 2, 3}, {0, 3, 1}, {2, 4, 5}, {2, 5, 3}};
  const auto triangles = one_sided_set_of(roof);
  std::map<std::pair<double, double>, int> degenerate_counts;  // by the y of both ends
  for (const SetTriangle& t : triangles) {
    if (t.kind == SurfaceKind::face) continue;
    ASSERT_EQ(t.kind, SurfaceKind::edge_fan);
    double low = t.corner[0].y();
    double high = low;
    for (const Vec3& corner : t.corner) {
      EXPECT_EQ(corner.x(), 0.0) << "only the convex edge has degenerate triangles";
      low = std::min(low, corner.y());
      high = std::max(high, corner.y());
    }
    EXPECT_LT(low, high) << "two different points";
    ++degenerate_counts[{low, high}];
  }
  ASSERT_FALSE(degenerate_counts.empty());
  for (const auto& [edge, count] : degenerate_counts) EXPECT_EQ(count, 2) << edge.first << " .. " << edge.second;

  constexpr double kRadius = 0.004;
  constexpr double kHeight = 0.001;
  Vec3 last = Vec3::Zero();
  bool is_empty_without = false;
  for (int i = 0; i <= 400; ++i) {
    const double angle = 0.785398163 * (2.0 * i / 400.0 - 1.0);  // from one face's normal to the other's
    const Vec3 P(kHeight * std::sin(angle), 0.0013, kHeight * std::cos(angle));
    SmoothForceSum all(P, kRadius);
    SmoothForceSum faces(P, kRadius);
    for (const SetTriangle& t : triangles) {
      all.add(t);
      if (t.kind == SurfaceKind::face) faces.add(t);
    }
    const Vec3 force = all.combine(kRadius, std::array{Material{.stiffness_n_per_m = kStiffnessNPerM}}).force_n;
    is_empty_without =
        is_empty_without || faces.combine(kRadius, std::array{Material{.stiffness_n_per_m = kStiffnessNPerM}}).force_n.isZero(0.0);
    EXPECT_NEAR(force.norm(), kStiffnessNPerM * (kRadius - kHeight), 1e-6 * kStiffnessNPerM * kRadius) << i;
    const Vec3 away(P.x(), 0, P.z());  // direction away from the convex edge
    EXPECT_LT(std::atan2(force.cross(away).norm(), force.dot(away)), 1e-6) << i;
    if (i > 0) {
      EXPECT_LT((force - last).norm(), 0.02 * force.norm()) << "a jump at " << angle;
    }
    last = force;
  }
  EXPECT_TRUE(is_empty_without) << "without degenerate triangles there is a force everywhere: this test proves nothing";
}

}  // namespace
}  // namespace hapton
