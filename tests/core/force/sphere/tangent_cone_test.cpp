#include "core/force/sphere/tangent_cone.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

namespace hapton {
namespace {

Vec3 drawn_direction(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Vec3(normal(random), normal(random), normal(random)).normalized();
}

TangentCone cone_of(const Vec3& apex, const std::vector<ContactTriangle>& triangles) {
  TangentCone cone;
  cone.begin(apex);
  for (const ContactTriangle& triangle : triangles) EXPECT_TRUE(cone.add(triangle, 1e-9));
  return cone;
}

// The corner of a cube that fills x, y, z < 0, each face in two triangles.
std::vector<ContactTriangle> cube_corner() {
  const Vec3 o = Vec3::Zero();
  std::vector<ContactTriangle> triangles;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 u = -Vec3::Unit((axis + 1) % 3);
    const Vec3 v = -Vec3::Unit((axis + 2) % 3);
    triangles.emplace_back(o, u, Vec3(u + v));
    triangles.emplace_back(o, Vec3(u + v), v);
  }
  return triangles;
}

TEST(TangentCone, OfACubesCornerHasThreeEdgesThatOpenOutwardsOrInwards) {
  for (const double side : {1.0, -1.0}) {
    TangentCone cone = cone_of(Vec3::Zero(), cube_corner());
    ASSERT_TRUE(cone.find_boundary(side * Vec3(0.5, 0.6, 0.7).normalized()));
    int edges = 0;
    for (const TangentCone::Piece& piece : cone.boundary()) {
      EXPECT_LE(piece.normal.dot(piece.from), 1e-12);
      if (std::fabs(piece.opening - std::numbers::pi) < 1e-9) continue;  // a diagonal, or where the walk began
      EXPECT_NEAR(piece.opening, side > 0.0 ? 1.5 * std::numbers::pi : 0.5 * std::numbers::pi, 1e-12);
      ++edges;
    }
    EXPECT_EQ(edges, 3);
  }
}

TEST(TangentCone, OfOneTriangleGoesAlongBothItsSides) {
  TangentCone cone = cone_of(Vec3::Zero(), {ContactTriangle(Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY())});
  ASSERT_TRUE(cone.find_boundary(Vec3(0.1, 0.1, 1.0).normalized()));
  bool has_above = false;
  bool has_below = false;
  double opening = 0.0;
  for (const TangentCone::Piece& piece : cone.boundary()) {
    has_above = has_above || piece.normal.z() > 0.5;
    has_below = has_below || piece.normal.z() < -0.5;
    opening = std::max(opening, piece.opening);
  }
  EXPECT_TRUE(has_above && has_below);
  EXPECT_NEAR(opening, 2.0 * std::numbers::pi, 1e-12);
}

// Three large triangles that share no vertex and cross at one point: the boundary is that of the octant that the point is in.
TEST(TangentCone, OfThreeFacesThatCrossIsTheOctantThatThePointIsIn) {
  const Vec3 apex(0.3, -0.2, 0.1);
  std::vector<ContactTriangle> triangles;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 u = Vec3::Unit((axis + 1) % 3);
    const Vec3 v = Vec3::Unit((axis + 2) % 3);
    triangles.emplace_back(apex + 5.0 * u, apex - 4.0 * u + 6.0 * v, apex - 4.0 * u - 7.0 * v);
  }
  for (int octant = 0; octant < 8; ++octant) {
    const Vec3 inside = Vec3(octant & 1 ? 1.0 : -1.0, octant & 2 ? 1.1 : -1.1, octant & 4 ? 0.9 : -0.9).normalized();
    TangentCone cone = cone_of(apex, triangles);
    ASSERT_TRUE(cone.find_boundary(inside)) << octant;
    double turned_rad = 0.0;
    for (const TangentCone::Piece& piece : cone.boundary()) {
      for (int k = 0; k < 3; ++k) {
        EXPECT_GE(piece.to[k] * inside[k], -1e-12) << octant;
        EXPECT_GE(piece.normal[k] * inside[k], -1e-12) << octant;
      }
      turned_rad += std::acos(std::clamp(piece.from.dot(piece.to), -1.0, 1.0));
    }
    EXPECT_NEAR(turned_rad, 1.5 * std::numbers::pi, 1e-6) << octant;
  }
}

// The twin: the steepest of densely sampled directions in the fan. The fan is a single sheet, so it bounds the free directions on both
// sides.
TEST(TangentCone, FindsTheSteepestDirectionOfRandomFans) {
  constexpr std::uint64_t kSeed = 20261121;
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> height(-0.9, 0.9);
  for (int round = 0; round < 300; ++round) {
    const Vec3 apex = drawn_direction(random);
    const int spokes = 4 + static_cast<int>(random() % 9);
    std::vector<Vec3> ends;
    for (int i = 0; i < spokes; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / spokes;
      ends.emplace_back(apex + Vec3(std::cos(angle), std::sin(angle), height(random)));
    }
    std::vector<ContactTriangle> fan;
    for (int i = 0; i < spokes; ++i)
      fan.emplace_back(apex, ends[static_cast<std::size_t>(i)], ends[static_cast<std::size_t>((i + 1) % spokes)]);
    const Vec3 pull = drawn_direction(random);
    double steepest = -1.0;
    for (const ContactTriangle& triangle : fan) {
      for (int k = 0; k <= 1000; ++k) {
        const double share = k / 1000.0;
        steepest = std::max(steepest, ((1.0 - share) * triangle.edge(0) - share * triangle.edge(2)).normalized().dot(pull));
      }
    }
    for (const Vec3& inside : {Vec3(Vec3::UnitZ()), Vec3(-Vec3::UnitZ())}) {
      TangentCone cone = cone_of(apex, fan);
      ASSERT_TRUE(cone.find_boundary(inside)) << round;
      const TangentCone::Steepest best = cone.find_steepest(pull);
      EXPECT_NEAR(best.slope, steepest, 1e-5) << round;
      EXPECT_NEAR(best.direction.dot(pull), best.slope, 1e-15) << round;
      EXPECT_GE(best.slope, steepest - 1e-12) << round;
    }
  }
}

// The pull of a device straight below a face is normal to it, except for rounding. The rounding must not decide the direction.
TEST(TangentCone, SteepestDirectionsLieInTheirPieceWhereThePullIsNormalToIt) {
  constexpr std::uint64_t kSeed = 20261123;
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random(kSeed);
  for (int round = 0; round < 2000; ++round) {
    const Vec3 normal = drawn_direction(random);
    const Vec3 u = normal.cross(drawn_direction(random)).normalized();
    const Vec3 v = normal.cross(u);
    TangentCone cone = cone_of(Vec3::Zero(), {ContactTriangle(5.0 * u, -4.0 * u + 6.0 * v, -4.0 * u - 7.0 * v)});
    ASSERT_TRUE(cone.find_boundary(normal));
    const double off = std::pow(2.0, -40.0 - static_cast<double>(random() % 14));
    const TangentCone::Steepest best = cone.find_steepest(off * u - 0.1 * normal);
    EXPECT_LE(std::fabs(best.direction.dot(normal)), 1e-14) << round;
  }
}

// Two sheets that cross at about 3e-6 rad, and a wall across both. The boundary of the space above them does not lead into the slit between
// them.
TEST(TangentCone, ASlitBetweenSheetsThatCrossIsClosed) {
  for (const double angle : {1.2e-6, 2.7e-6, 6e-6}) {
    const auto sheet = [](double slope) {
      return ContactTriangle(Vec3(8.0, -9.0, 8.0 * slope), Vec3(-9.0, 0.5, -9.0 * slope), Vec3(8.0, 9.5, 8.0 * slope));
    };
    const ContactTriangle wall(Vec3(0.3, 9.0, -8.0), Vec3(-0.2, -0.1, 9.0), Vec3(-0.25, -9.0, -8.0));
    TangentCone cone = cone_of(Vec3::Zero(), {sheet(0.5 * angle), sheet(-0.5 * angle)});
    ASSERT_TRUE(cone.add(wall, 0.1));
    ASSERT_TRUE(cone.find_boundary(Vec3(0.6, 0.1, 0.7).normalized())) << angle;
    for (const TangentCone::Piece& piece : cone.boundary()) {
      EXPECT_GE(piece.to.z(), -1e-5) << angle;
      EXPECT_GE(piece.normal.z(), -0.1) << angle;
      EXPECT_GT(piece.opening, 1e-3) << angle;
    }
  }
}

// A vertex of the NIST assembly (local coordinates). The arc nearest to the direction of the point is nearest at its end, so the walk along
// the boundary begins at an end.
TEST(TangentCone, ClosesWhereItBeganAtTheEndOfAnArc) {
  const Vec3 apex(0.377247445811, 0.224334866022, -0.195035136);
  const Vec3 right(0.378984936243, 0.223001706496, -0.195035136);
  const Vec3 left(0.375914496, 0.226072146739, -0.195035136);
  const Vec3 far(0.212786059674, 0.224334866022, -0.195035136);
  const Vec3 farther(0.2141192192, 0.226072146739, -0.195035136);
  const Vec3 up(0.0, 0.0, 0.023068672);
  TangentCone cone = cone_of(apex, {{right, far, apex},
                                    {apex, far, farther},
                                    {apex, farther, left},
                                    {apex, Vec3(right + up), right},
                                    {Vec3(right + up), apex, Vec3(apex + up)},
                                    {Vec3(left + up), apex, left},
                                    {apex, Vec3(left + up), Vec3(apex + up)}});
  ASSERT_TRUE(cone.find_boundary(Vec3(0.707113, 0.707101, 0.0).normalized()));
  EXPECT_LE(cone.boundary().size(), 10U);
  int edges = 0;
  for (const TangentCone::Piece& piece : cone.boundary()) edges += std::fabs(piece.opening - std::numbers::pi) > 1e-6 ? 1 : 0;
  EXPECT_EQ(edges, 3);
}

// Directions at a vertex of barkour_body_dirty, where two sheets meet at 6.6e-6 rad: the boundary goes into the wedge between them and out
// again.
TEST(TangentCone, AWedgeWithATipIsNotASlit) {
  const std::vector<std::pair<Vec3, Vec3>> arcs = {{{0.92391485, 0.33257945, -0.18913558}, {0.0, 0.84845166, -0.52927289}},
                                                   {{0.0, 0.91376631, 0.40624023}, {0.99395900, 0.06546079, 0.08809308}},
                                                   {{0.99395900, 0.06546079, 0.08809308}, {0.98010665, 0.09923547, -0.17188157}},
                                                   {{0.98010665, 0.09923547, -0.17188157}, {0.92391485, 0.33257945, -0.18913558}},
                                                   {{0.0, -0.41741980, 0.90871377}, {0.0, 0.91376631, 0.40624023}},
                                                   {{0.0, 0.89879413, -0.43837097}, {-0.99996626, -0.00461100, -0.00679895}},
                                                   {{-0.99996626, -0.00461100, -0.00679895}, {-0.00000580, 0.83069180, 0.55673255}},
                                                   {{0.0, -0.97698402, 0.21331253}, {0.0, -0.82116357, 0.57069290}},
                                                   {{0.0, -0.93804699, -0.34650808}, {0.0, -0.97698402, 0.21331253}},
                                                   {{0.0, -0.08398919, 0.99646667}, {0.0, -0.93804699, -0.34650808}},
                                                   {{-0.00000580, 0.83069180, 0.55673255}, {0.0, -0.08398919, 0.99646667}},
                                                   {{0.0, -0.82116357, 0.57069290}, {0.0, -0.41741980, 0.90871377}},
                                                   {{0.0, 0.84845166, -0.52927289}, {0.0, -0.93804699, -0.34650808}},
                                                   {{0.0, -0.93804699, -0.34650808}, {0.0, 0.89879413, -0.43837097}}};
  std::vector<ContactTriangle> triangles;
  for (const auto& [a, b] : arcs) triangles.emplace_back(Vec3::Zero(), a, b);
  TangentCone cone = cone_of(Vec3::Zero(), triangles);
  ASSERT_TRUE(cone.find_boundary(Vec3(0.968926, 0.246824, -0.016160).normalized()));
  const auto narrowest =
      std::min_element(cone.boundary().begin(), cone.boundary().end(), [](const auto& a, const auto& b) { return a.opening < b.opening; });
  EXPECT_NEAR(narrowest->opening, 6.6e-6, 1e-7);
}

// A body below a sheet, with its apex on the sheet. Its upper face lies in the sheet, except for a corner up to 6e-8 above it: less than
// the angle below which directions count as the same. The boundary below the sheet goes along the sheet, not along that face and around to
// the other side.
TEST(TangentCone, AFaceThatRisesAboveASheetByTooLittleToCountStaysBehindIt) {
  const Vec3 o = Vec3::Zero();
  const Vec3 down(0.000471402, 0.0255323, -0.0230239);
  const Vec3 aside(0.0132902, 0.0261019, -0.0114792);
  const Vec3 back(0.0, -0.0246177, -0.0147981);
  for (const double above : {0.0, 1e-9, 1e-8, 4.26326e-8, 6e-8}) {
    const Vec3 corner(0.0160687, 0.0265931, above);
    const Vec3 level(0.0190735, 0.0547409, 0.0);
    TangentCone cone = cone_of(o, {{down, aside, o},
                                   {down, o, back},
                                   {{0.0287414, -0.072056, 0.0}, {-0.0260774, 0.0174666, 0.0}, {-0.00715255, 0.0572205, 0.0}},
                                   {o, aside, corner},
                                   {o, level, {0.0134301, 0.0637876, 0.0}},
                                   {o, corner, level},
                                   {{0.0134301, 0.0637876, 0.0}, {-0.0228882, 0.0736582, 0.0}, o},
                                   {o, {0.0, -0.038147, 0.0}, back},
                                   {o, {-0.00190732, -0.038147, 0.0}, {0.0, -0.038147, 0.0}},
                                   {{-0.0228882, 0.0736582, 0.0}, {-0.00190732, -0.038147, 0.0}, o}});
    // Depending on the depth, the walk begins at the arc of the sheet or at that of the face.
    for (const double depth : {0.2, 0.248, 0.249, 0.3}) {
      ASSERT_TRUE(cone.find_boundary(Vec3(0.221153, 0.943101, -depth).normalized())) << above;
      EXPECT_TRUE(cone.is_around_start()) << above << ", " << depth;
      for (const TangentCone::Piece& piece : cone.boundary()) EXPECT_LT(piece.normal.z(), 0.9) << above << ", " << depth;
    }
  }
}

// Finds steep directions one after the other, from the steepest to the least steep.
TEST(TangentCone, FindsTheNextSteepestDirections) {
  TangentCone cone = cone_of(Vec3::Zero(), cube_corner());
  ASSERT_TRUE(cone.find_boundary(Vec3::Ones().normalized()));
  const Vec3 pull(-0.9, -0.5, 0.3);
  double below = std::numeric_limits<double>::infinity();
  int directions_found = 0;
  for (; directions_found < 100; ++directions_found) {
    const TangentCone::Steepest next = cone.find_steepest(pull, below);
    if (next.piece < 0) break;
    EXPECT_LT(next.slope, below);
    EXPECT_NEAR(next.slope, next.direction.dot(pull), 1e-12);
    below = next.slope;
  }
  EXPECT_GE(directions_found, 3);
  EXPECT_LE(directions_found, 2 * static_cast<int>(cone.boundary().size()));
}

TEST(TangentCone, HasNoBoundaryWithoutTrianglesAndRejectsMoreThanItHolds) {
  TangentCone cone;
  cone.begin(Vec3::Zero());
  EXPECT_FALSE(cone.find_boundary(Vec3::UnitZ()));
  int added = 0;
  const ContactTriangle corner(Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY());
  while (added <= TangentCone::kMaxArcs && cone.add(corner, 1e-9)) ++added;
  EXPECT_EQ(added, TangentCone::kMaxArcs);
}

// A closed fan with an uneven rim separates the directions into two regions. The twin: seen from the apex, the rim is a polygon around z.
TEST(TangentCone, ContainsTheDirectionsOfItsRegionAndNoOthers) {
  const std::uint64_t seed = 7;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int inside = 0;
  int outside = 0;
  for (int run = 0; run < 200; ++run) {
    constexpr int kCorners = 9;
    std::vector<Vec3> ring;
    for (int i = 0; i < kCorners; ++i) {
      const double angle = 2.0 * std::numbers::pi * (i + 0.3 * unit(random)) / kCorners;
      const double radius = 1.5 + 1.2 * unit(random);
      ring.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 1.0);
    }
    const Eigen::Quaterniond turn = Eigen::Quaterniond(unit(random), unit(random), unit(random), unit(random)).normalized();
    std::vector<ContactTriangle> triangles;
    for (int i = 0; i < kCorners; ++i) {
      const auto k = static_cast<std::size_t>(i);
      triangles.emplace_back(Vec3::Zero(), turn * ring[k], turn * ring[(k + 1) % kCorners]);
    }
    // A direction with z > 0 is within the polygon if a ray from the middle of the polygon towards it meets no side before it.
    const auto is_within = [&](const Vec3& d) {
      if (!(d.z() > 0.0)) return false;
      const Eigen::Vector2d p = d.head<2>() / d.z();
      for (std::size_t k = 0; k < kCorners; ++k) {
        const Eigen::Vector2d a = ring[k].head<2>();
        const Eigen::Vector2d b = ring[(k + 1) % kCorners].head<2>();
        const double side = (b - a).x() * (p - a).y() - (b - a).y() * (p - a).x();
        const double from = a.x() * p.y() - a.y() * p.x();
        const double to = p.x() * b.y() - p.y() * b.x();
        if (from >= 0.0 && to >= 0.0) return side > 0.0;
      }
      return false;
    };
    const bool from_within = run % 2 == 0;
    TangentCone cone = cone_of(Vec3::Zero(), triangles);
    ASSERT_TRUE(cone.find_boundary(turn * (from_within ? Vec3(0.0, 0.0, 1.0) : Vec3(0.0, 0.0, -1.0))));
    for (int i = 0; i < 50; ++i) {
      const Vec3 d = drawn_direction(random);
      const bool expected = is_within(d) == from_within;
      EXPECT_EQ(cone.contains(turn * d), expected) << "run " << run << " direction " << d.transpose();
      ++(expected ? inside : outside);
    }
    if (HasFailure()) return;
  }
  EXPECT_GT(inside, 1000);
  EXPECT_GT(outside, 1000);
}

// At a needle about as narrow as the angle below which directions count as the same, the walk once turned back on the wrong side of the
// surface, and a point was placed inside a body.
TEST(TangentCone, GoesPastANeedleOfAMillionthRadian) {
  const Vec3 apex = Vec3::Zero();
  const double unit = 0x1p-31;
  const Vec3 needle(3.486e8, -383.5, -521.8), beside(2.575e8, -521.8, -521.8);
  const Vec3 a(3.486e8, 3.486e8, 1.993e8), b(1.019e8, 3.486e8, 1.019e8), c(-521.8, -280.8, -280.8), d(-521.8, -521.8, -450.9);
  const Vec3 e(-418.5, -521.8, -418.5);
  std::vector<ContactTriangle> fan;
  for (const auto& [p, q] : {std::pair{a, needle}, {b, a}, {c, b}, {needle, beside}, {beside, e}, {e, d}, {d, c}}) {
    fan.emplace_back(apex, Vec3(unit * p), Vec3(unit * q));
  }
  TangentCone cone;
  cone.begin(apex);
  for (const ContactTriangle& triangle : fan) ASSERT_TRUE(cone.add(triangle, 4.0 * unit));
  const Vec3 free = Vec3(-0.27246, 0.077509, -1.2197).normalized();
  ASSERT_TRUE(cone.find_boundary(free));
  EXPECT_TRUE(cone.is_around_start());
  EXPECT_TRUE(cone.contains(free));
  EXPECT_FALSE(cone.contains(-free));
  EXPECT_FALSE(cone.contains(Vec3(-25.812, -14.166, -12.595).normalized()));
}

}  // namespace
}  // namespace hapton
