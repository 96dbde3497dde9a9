#include "core/collision/sweep_line.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

TrianglePlane plane_of(const TriangleMesh& mesh, std::size_t t) {
  return *compute_triangle_plane(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
}

const TrianglePlane kTriangleInXy = *compute_triangle_plane({0, 0, 0}, {4, 0, 0}, {0, 4, 0});

TEST(SweepLine, FindsPointDepthAndSideFromAbove) {
  SweepCollision hit;
  ASSERT_EQ(compute_collision({{1, 1, 1}, {1.5, 1, -1}}, kTriangleInXy, hit), SweepOutcome::collision);
  EXPECT_EQ(hit.t, 0.5);
  EXPECT_EQ(hit.point, Vec3(1.25, 1, 0));
  EXPECT_EQ(hit.normal, Vec3(0, 0, 1));
  EXPECT_EQ(hit.depth, 1.0);
  EXPECT_FALSE(hit.from_behind);
}

TEST(SweepLine, FromBelowTheNormalTurnsRound) {
  SweepCollision hit;
  ASSERT_EQ(compute_collision({{1, 1, -1}, {1, 1, 3}}, kTriangleInXy, hit), SweepOutcome::collision);
  EXPECT_EQ(hit.point, Vec3(1, 1, 0));
  EXPECT_EQ(hit.normal, Vec3(0, 0, -1));
  EXPECT_EQ(hit.depth, 3.0);
  EXPECT_TRUE(hit.from_behind);
}

TEST(SweepLine, EachStepEndsAsTheMemoSays) {
  SweepCollision hit;
  EXPECT_EQ(compute_collision({{1, 1, 1}, {2, 2, 1}}, kTriangleInXy, hit), SweepOutcome::parallel);
  EXPECT_EQ(compute_collision({{1, 1, 0}, {2, 1, 0}}, kTriangleInXy, hit), SweepOutcome::parallel);
  EXPECT_EQ(compute_collision({{1, 1, 1}, {1, 1, 1}}, kTriangleInXy, hit), SweepOutcome::parallel);  // a line of length zero
  EXPECT_EQ(compute_collision({{1, 1, 3}, {1, 1, 1}}, kTriangleInXy, hit), SweepOutcome::out_of_length);
  EXPECT_EQ(compute_collision({{1, 1, -1}, {1, 1, -3}}, kTriangleInXy, hit), SweepOutcome::out_of_length);
  EXPECT_EQ(compute_collision({{3, 3, 1}, {3, 3, -1}}, kTriangleInXy, hit), SweepOutcome::out_of_triangle);
}

TEST(SweepLine, TwoLinesThatMeetOnThePlaneCollideOnce) {
  for (const double direction : {1.0, -1.0}) {
    const Vec3 far(1, 1, direction);
    const Vec3 on(1, 1, 0);
    const Vec3 beyond(1, 1, -direction);
    SweepCollision hit;
    const int first = compute_collision({far, on}, kTriangleInXy, hit) == SweepOutcome::collision ? 1 : 0;
    const int second = compute_collision({on, beyond}, kTriangleInXy, hit) == SweepOutcome::collision ? 1 : 0;
    EXPECT_EQ(first + second, 1) << direction;
  }
}

// Lines aimed exactly at edges and vertices of a closed mesh, from outside to its middle: none may slip through, at any scale and position.
TEST(SweepLine, NoLineSlipsBetweenNeighbours) {
  constexpr std::uint64_t kSeed = 5;
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int lines_with_two_hits = 0;
  for (const double scale : {1e-6, 1.0, 1e6}) {
    for (const Vec3& shift : {Vec3(0, 0, 0), Vec3(3.1, -2.7, 1.3)}) {
      TriangleMesh mesh = made::sphere(1.0, 9, 0.1);
      for (Vec3& v : mesh.vertices) {
        v = scale * (v + shift);
      }
      std::vector<TrianglePlane> planes;
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        planes.push_back(plane_of(mesh, t));
      }
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
          const double share = unit(random) < 0.3 ? 0.0 : unit(random);
          const Vec3 target = mesh.corner(t, k) + share * (mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k));
          const Vec3 middle = scale * (shift + 0.3 * Vec3(unit(random), unit(random), unit(random)));
          const Vec3 outside = target + (0.1 + unit(random)) * (target - middle);
          int hits = 0;
          for (const TrianglePlane& plane : planes) {
            SweepCollision hit;
            hits += compute_collision({outside, middle}, plane, hit) == SweepOutcome::collision ? 1 : 0;
          }
          ASSERT_GE(hits, 1) << "triangle " << t << " edge " << k << " scale " << scale;
          lines_with_two_hits += hits >= 2 ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GT(lines_with_two_hits, 1000);  // the lines did meet edges
}

// Compares with signed volumes in extended precision, which use neither plane nor projection.
TEST(SweepLine, AgreesWithSignedVolumes) {
  constexpr std::uint64_t kSeed = 17;
  RecordProperty("seed", std::to_string(kSeed));
  const TriangleMesh mesh = made::soup(kSeed, 300, 1.0, 1.0);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(-1.5, 1.5);
  using Wide = Eigen::Matrix<long double, 3, 1>;
  const auto volume = [](const Wide& a, const Wide& b, const Wide& c, const Wide& d) { return (b - a).cross(c - a).dot(d - a); };
  int hits = 0;
  int decided = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto plane = compute_triangle_plane(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
    if (!plane) {
      continue;
    }
    const Wide a = mesh.corner(t, 0).cast<long double>();
    const Wide b = mesh.corner(t, 1).cast<long double>();
    const Wide c = mesh.corner(t, 2).cast<long double>();
    const Vec3 middle = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3.0;
    for (int i = 0; i < 200; ++i) {
      const SweepLine line = {middle + Vec3(unit(random), unit(random), unit(random)),
                              middle + Vec3(unit(random), unit(random), unit(random))};
      const Wide p = line.last.cast<long double>();
      const Wide q = line.current.cast<long double>();
      const std::array<long double, 5> volumes = {volume(a, b, c, p), volume(a, b, c, q), volume(p, q, a, b), volume(p, q, b, c),
                                                  volume(p, q, c, a)};
      if (std::any_of(volumes.begin(), volumes.end(), [](long double v) { return std::abs(v) < 1e-12L; })) {
        continue;
      }
      const bool same_sign = (volumes[2] > 0) == (volumes[3] > 0) && (volumes[3] > 0) == (volumes[4] > 0);
      const bool expected = (volumes[0] > 0) != (volumes[1] > 0) && same_sign;
      SweepCollision hit;
      ASSERT_EQ(compute_collision(line, *plane, hit) == SweepOutcome::collision, expected) << "triangle " << t << " line " << i;
      ++decided;
      if (expected) {
        ++hits;
        EXPECT_NEAR(hit.t, static_cast<double>(volumes[0] / (volumes[0] - volumes[1])), 1e-9);
        EXPECT_NEAR(plane->height_of(hit.point), 0.0, 1e-14);
        EXPECT_EQ(hit.depth, std::abs(plane->height_of(line.current)));
      }
    }
  }
  EXPECT_GT(hits, 2000);
  EXPECT_GT(decided, 40000);
}

}  // namespace
}  // namespace hapton
