#include "core/geometry/corner_normals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

constexpr double kRadPerDegree = std::numbers::pi / 180.0;

ShadedMesh shade(const TriangleMesh& mesh, double crease_deg, CornerNormalReport& report) {
  std::vector<std::uint32_t> source(mesh.triangles.size());
  std::iota(source.begin(), source.end(), 0U);
  return fill_corner_normals(mesh, source, crease_deg * kRadPerDegree, report);
}

TEST(CornerNormals, OfASphereAreRadialAndShared) {
  const TriangleMesh mesh = make_icosphere(0.05, 3);
  CornerNormalReport report;
  const ShadedMesh shaded = shade(mesh, 40.0, report);
  EXPECT_EQ(report.sharp_edges, 0U);
  EXPECT_EQ(report.normals, mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) EXPECT_LT((shaded.normal(t, k) - mesh.corner(t, k).normalized()).norm(), 0.01);
  }
}

TEST(CornerNormals, OfABoxAreItsFaces) {
  const TriangleMesh mesh = make_box(Vec3(1, 2, 3), 3);
  CornerNormalReport report;
  const ShadedMesh shaded = shade(mesh, 40.0, report);
  EXPECT_EQ(report.sharp_edges, 12U * 3U);   // edges of three segments each
  EXPECT_EQ(report.creased, 8U + 12U * 2U);  // corners, and two vertices within each edge
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 face = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).normalized();
    for (int k = 0; k < 3; ++k) EXPECT_LT((shaded.normal(t, k) - face).norm(), 1e-12);
  }
  CornerNormalReport rounded_report;
  const ShadedMesh rounded = shade(mesh, 180.0, rounded_report);
  EXPECT_EQ(rounded_report.sharp_edges, 0U);
  EXPECT_EQ(rounded_report.normals, mesh.vertices.size());
}

// A box with authored normals as of a rounded one: the normal at each corner points away from the box's middle.
TriangleMesh rounded_box() {
  TriangleMesh mesh = make_box(Vec3(1, 1, 1), 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<Eigen::Vector3f, 3> normals;
    for (int k = 0; k < 3; ++k) normals[k] = 7.0F * mesh.corner(t, k).cast<float>();
    mesh.authored_normals.push_back(normals);
  }
  return mesh;
}

TEST(CornerNormals, AuthoredOnesReplaceComputedOnes) {
  const TriangleMesh mesh = rounded_box();
  CornerNormalReport report;
  ShadedMesh shaded = shade(mesh, 40.0, report);
  const std::size_t computed = shaded.normals.size();
  const AuthoredNormalReport authored = use_authored_normals(mesh, shaded);
  EXPECT_EQ(authored.given, 36U);  // three for each of 12 triangles
  EXPECT_EQ(authored.used, 36U);
  EXPECT_EQ(shaded.normals.size(), computed + 8U) << "equal ones at a vertex are one";
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) EXPECT_LT((shaded.normal(t, k) - mesh.corner(t, k).normalized()).norm(), 1e-6);
  }
  EXPECT_EQ(repair_corner_normals(shaded).repaired(), 0U);
}

TEST(CornerNormals, AuthoredOnesThatAreNotValidFallBackToComputedOnes) {
  TriangleMesh mesh = rounded_box();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  mesh.authored_normals[0] = {Eigen::Vector3f::Zero(), Eigen::Vector3f(nan, 0, 1), -mesh.authored_normals[0][2]};
  CornerNormalReport report;
  const ShadedMesh computed = shade(mesh, 40.0, report);
  ShadedMesh shaded = computed;
  const AuthoredNormalReport authored = use_authored_normals(mesh, shaded);
  EXPECT_EQ(authored.given, 35U);
  EXPECT_EQ(authored.used, 33U);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(shaded.normal(0, k), computed.normal(0, k));
  EXPECT_NE(shaded.normal(1, 0), computed.normal(1, 0));
  EXPECT_NE(authored.describe().find("33 used"), std::string::npos) << authored.describe();
}

// A file may contain such a mesh. A search among all of its normals would use up the time limit of the test.
TEST(CornerNormals, AnyNumberOfAuthoredOnesMayMeetAtOneVertex) {
  constexpr std::uint32_t kCount = 1'000'000;
  TriangleMesh mesh;
  mesh.vertices.emplace_back(0.0, 0.0, 0.1);
  for (std::uint32_t t = 0; t < kCount; ++t) {
    const double angle = 2.0 * std::numbers::pi * t / kCount;
    mesh.vertices.emplace_back(std::cos(angle), std::sin(angle), 0.0);
    mesh.triangles.push_back({0, 1 + t, 1 + (t + 1) % kCount});
    const Eigen::Vector3f normal(1e-6F * static_cast<float>(t / 2), 0.0F, 1.0F);
    mesh.authored_normals.push_back({normal, Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()});
  }
  CornerNormalReport report;
  ShadedMesh shaded = shade(mesh, 40.0, report);
  const std::size_t computed = shaded.normals.size();
  EXPECT_EQ(use_authored_normals(mesh, shaded).used, kCount);
  EXPECT_EQ(shaded.normals.size(), computed + kCount / 2) << "equal ones are shared";
  for (const std::size_t t : {0UL, 500'000UL, 999'998UL}) {
    EXPECT_EQ(shaded.corner_normals[t][0], computed + t / 2);
    EXPECT_EQ(shaded.corner_normals[t + 1][0], computed + t / 2);
  }
}

TEST(CornerNormals, EqualAuthoredOnesOfTwoVerticesAreNotShared) {
  TriangleMesh mesh = rounded_box();
  for (auto& normals : mesh.authored_normals) normals.fill(Eigen::Vector3f(0.6F, 0.64F, 0.48F));
  CornerNormalReport report;
  ShadedMesh shaded = shade(mesh, 40.0, report);
  const std::size_t computed = shaded.normals.size();
  EXPECT_EQ(use_authored_normals(mesh, shaded).used, 18U) << "of the three sides that they leave";
  EXPECT_EQ(shaded.normals.size(), computed + 7);  // the vertices of these sides
}

TEST(CornerNormals, AMeshWithoutAuthoredOnesKeepsTheComputedOnes) {
  const TriangleMesh mesh = make_box(Vec3(1, 1, 1), 1);
  CornerNormalReport report;
  ShadedMesh shaded = shade(mesh, 40.0, report);
  const std::size_t before = shaded.normals.size();
  EXPECT_EQ(use_authored_normals(mesh, shaded).given, 0U);
  EXPECT_EQ(shaded.normals.size(), before);
  EXPECT_EQ(count_authored_normals(mesh).describe(), "none");
}

TEST(CornerNormals, AuthoredOnesOfAFlippedMeshPointTheOppositeWay) {
  const TriangleMesh turned = flipped(rounded_box());
  EXPECT_EQ(count_authored_normals(turned).used, 36U);
  const TriangleMesh both = joined(make_box(Vec3(3, 3, 3), 1), rounded_box());
  ASSERT_TRUE(both.has_authored_normals());
  EXPECT_EQ(count_authored_normals(both).given, 36U);
  EXPECT_EQ(count_authored_normals(both).used, 36U);
}

// Such neighbours have no common outer side, whatever the crease angle is.
TEST(CornerNormals, InconsistentlyOrientedNeighboursShareNone) {
  TriangleMesh sheet;
  sheet.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0)};
  sheet.triangles = {{0, 1, 2}, {0, 3, 2}};
  CornerNormalReport report;
  const ShadedMesh shaded = shade(sheet, 180.0, report);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(shaded.normal(0, k), Vec3(0, 0, 1));
    EXPECT_EQ(shaded.normal(1, k), Vec3(0, 0, -1));
  }
}

// The weight of a face in the normal is its angle at the corner, not its number of triangles.
TEST(CornerNormals, DoNotDependOnHowAFaceIsCut) {
  CornerNormalReport report;
  const ShadedMesh shaded = shade(make_box(Vec3(1, 1, 1)), 180.0, report);
  for (std::size_t t = 0; t < shaded.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) EXPECT_LT((shaded.normal(t, k) - shaded.corner(t, k).normalized()).norm(), 1e-12);
  }
}

TEST(CornerNormals, FollowMovedVertices) {
  TriangleMesh mesh = make_icosphere(0.05, 2);
  CornerNormalReport report;
  ShadedMesh moved = shade(mesh, 40.0, report);
  for (Vec3& v : mesh.vertices) v = Vec3(v.x(), 1.3 * v.y(), v.z()) + Vec3(1, 2, 3);
  moved.vertices = mesh.vertices;
  update_corner_normals(moved, moved.triangles.size());
  const ShadedMesh rebuilt = shade(mesh, 40.0, report);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) EXPECT_LT((moved.normal(t, k) - rebuilt.normal(t, k)).norm(), 1e-12);
  }
}

TEST(CornerNormals, OfMovedVerticesHaveLengthOneAlsoWhereFacesAreOppositeOrHaveNoArea) {
  TriangleMesh sheet;
  sheet.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0)};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  CornerNormalReport report;
  ShadedMesh moved = shade(sheet, 180.0, report);
  moved.vertices[3] = moved.vertices[1];  // the sheet is folded: its two faces lie on each other
  update_corner_normals(moved, 2);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(moved.normal(0, k), Vec3(0, 0, 1));
  EXPECT_EQ(moved.normal(1, 2), Vec3(0, 0, -1));
  for (Vec3& v : moved.vertices) v = Vec3(1, 2, 3);
  update_corner_normals(moved, 2);
  for (const Vec3& n : moved.normals) EXPECT_EQ(n.norm(), 1.0);
}

TEST(CheckCornerNormals, RepairsWhatPointsAway) {
  const TriangleMesh mesh = make_icosphere(1.0, 1);
  CornerNormalReport report;
  ShadedMesh shaded = shade(mesh, 40.0, report);
  EXPECT_EQ(repair_corner_normals(shaded).repaired(), 0U);
  shaded.normals[shaded.corner_normals[0][0]] *= -1.0;
  shaded.normals[shaded.corner_normals[0][1]] = Vec3(0, std::numeric_limits<double>::quiet_NaN(), 0);
  const NormalCheckReport found = repair_corner_normals(shaded);
  EXPECT_GT(found.turned_away, 4U);
  EXPECT_GT(found.not_unit, 4U);
  EXPECT_EQ(repair_corner_normals(shaded).repaired(), 0U);
  for (std::size_t t = 0; t < shaded.triangles.size(); ++t) {
    const Vec3 face = (shaded.corner(t, 1) - shaded.corner(t, 0)).cross(shaded.corner(t, 2) - shaded.corner(t, 0)).normalized();
    for (int k = 0; k < 3; ++k) EXPECT_GT(shaded.normal(t, k).dot(face), 0.08);
  }
}

}  // namespace
}  // namespace hapton
