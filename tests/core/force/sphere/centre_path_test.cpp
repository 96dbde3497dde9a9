#include "core/force/sphere/centre_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

namespace hapton {
namespace {

using Guide = CentrePath::Guide;

class CentrePathTest : public testing::Test {
 protected:
  CentrePathTest() { RecordProperty("seed", std::to_string(kSeed)); }
  double unit() { return unit_(random_); }
  double between(double least, double most) { return least + (most - least) * 0.5 * (1.0 + unit()); }
  Vec3 vector() {
    const double x = unit();
    const double y = unit();
    return {x, y, unit()};
  }
  Vec3 direction() { return vector().normalized(); }

  // A piece of a circle of the given radius. guide_kind: 0 no guide, 1 round a line, 2 round a point.
  struct Arc {
    Vec3 middle, axis, out, tangent;
    double radius, angle;
    CentrePath path;
    Vec3 at(double time) const { return middle + radius * (std::cos(angle * time) * out + std::sin(angle * time) * tangent); }
  };
  Arc arc(double radius, double angle, int guide_kind) {
    Arc arc{vector(), direction(), Vec3::Zero(), Vec3::Zero(), radius, angle, {}};
    arc.out = arc.axis.unitOrthogonal();
    arc.tangent = arc.axis.cross(arc.out);
    const double speed = radius * angle;
    arc.path = CentrePath::curved(arc.at(0.0), arc.at(1.0), speed * arc.tangent,
                                  speed * (std::cos(angle) * arc.tangent - std::sin(angle) * arc.out));
    if (guide_kind == 1) arc.path.add_guide({Feature::edge, arc.middle, arc.axis, radius});
    if (guide_kind == 2) arc.path.add_guide({Feature::vertex, arc.middle, Vec3::Zero(), radius});
    return arc;
  }

 private:
  static constexpr std::uint64_t kSeed = 23;
  std::mt19937_64 random_{kSeed};
  std::uniform_real_distribution<double> unit_{-1.0, 1.0};
};

double distance_from_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - a - t * (b - a)).norm();
}

double distance_to_guide(const Guide& guide, const Vec3& p) {
  Vec3 off = p - guide.origin;
  if (guide.part == Feature::face) return guide.direction.dot(off);
  if (guide.part == Feature::edge) off -= guide.direction.dot(off) * guide.direction;
  return off.norm();
}

TEST_F(CentrePathTest, HasItsEndsAndSlopes) {
  for (int i = 0; i < 200; ++i) {
    const Vec3 from = vector();
    const Vec3 to = vector();
    const CentrePath straight = CentrePath::straight(from, to);
    const Vec3 slope_from = vector();
    const Vec3 slope_to = vector();
    const CentrePath curved = CentrePath::curved(from, to, slope_from, slope_to);
    for (const CentrePath* path : {&straight, &curved}) {
      EXPECT_EQ(path->at(0.0), from);
      EXPECT_EQ(path->at(1.0), to);
      EXPECT_EQ(path->start(), from);
      EXPECT_EQ(path->end(), to);
      EXPECT_LT((path->at(0x1p-60) - from).norm(), 1e-15);
      EXPECT_LT((path->at(1.0 - 0x1p-53) - to).norm(), 1e-14);
      for (int k = 1; k < 8; ++k) {
        const double time = k / 8.0;
        const Vec3 difference = (path->at(time + 1e-5) - path->at(time - 1e-5)) / 2e-5;
        EXPECT_LT((path->slope(time) - difference).norm(), 1e-8);
        EXPECT_LE(distance_from_segment(path->at(time), from, to), path->bulge() + 1e-15);
      }
    }
    EXPECT_TRUE(straight.is_straight());
    EXPECT_FALSE(curved.is_straight());
    EXPECT_EQ(straight.bulge(), 0.0);
    EXPECT_LT((curved.slope(0.0) - slope_from).norm(), 1e-15);
    EXPECT_LT((curved.slope(1.0) - slope_to).norm(), 2e-14);
  }
}

TEST_F(CentrePathTest, ACubicIsAsNearToItsArcAsStated) {
  for (const double angle : {0.05, 0.125, 0.25}) {
    const Arc free = arc(0.3, angle, 0);
    const Arc guided = arc(0.3, angle, 1);
    double largest_error = 0.0;
    for (int k = 0; k <= 64; ++k) {
      largest_error = std::max(largest_error, std::fabs((free.path.at(k / 64.0) - free.middle).norm() - 0.3));
      EXPECT_NEAR((guided.path.at(k / 64.0) - guided.middle).norm(), 0.3, 0x1p-51);
      EXPECT_LE(distance_from_segment(guided.path.at(k / 64.0), guided.path.start(), guided.path.end()), guided.path.bulge());
    }
    EXPECT_LE(largest_error, 1.01 * 0.3 * std::pow(angle, 4) / 384.0);
    EXPECT_GE(largest_error, 0.5 * 0.3 * std::pow(angle, 4) / 384.0) << "the bound in the header is too large";
  }
}

TEST_F(CentrePathTest, IsKeptOnItsGuidesToRounding) {
  int checked_paths = 0;
  for (int i = 0; i < 900; ++i) {
    const double offset = between(0.05, 0.4);
    const Vec3 middle = vector();
    std::array<Guide, 2> guides;
    const int count = 1 + (i % 9 < 6 ? 1 : 0);
    Vec3 from = middle + 2.0 * offset * direction();
    for (int g = 0; g < count; ++g) {
      const auto part = static_cast<Feature>((i / 9 + g * (1 + i % 2)) % 3);
      guides[g] = {part, middle + 0.5 * offset * vector(), direction(), offset};
      if (part == Feature::face) guides[g].direction *= guides[g].direction.dot(from - guides[g].origin) < 0.0 ? -1.0 : 1.0;
    }
    const auto normal = [&](int g, const Vec3& p) {
      if (guides[g].part == Feature::face) return guides[g].direction;
      Vec3 off = p - guides[g].origin;
      if (guides[g].part == Feature::edge) off -= guides[g].direction.dot(off) * guides[g].direction;
      return Vec3(off.normalized());
    };
    // Alternating projections converge to a point on all of them, slowly.
    const auto onto = [&](Vec3 p) {
      for (int round = 0; round < 400; ++round) {
        for (int g = 0; g < count; ++g) p += (offset - distance_to_guide(guides[g], p)) * normal(g, p);
      }
      return p;
    };
    from = onto(from);
    Vec3 way = count == 2 ? Vec3(normal(0, from).cross(normal(1, from))) : vector();
    if (count == 2 && way.norm() < 0.3) continue;
    way.normalize();
    const double length = 0.125 * offset;
    const Vec3 to = onto(from + length * way);
    const auto tangent = [&](const Vec3& p) {
      Vec3 t = count == 2 ? Vec3(normal(0, p).cross(normal(1, p)).normalized()) : Vec3(to - from);
      if (count == 1) t = (t - normal(0, p).dot(t) * normal(0, p)).normalized();
      return Vec3(t * (t.dot(way) < 0.0 ? -1.0 : 1.0));
    };
    bool is_on = (to - from).norm() < 2.0 * length && (to - from).norm() > 0.1 * length;
    for (int g = 0; g < count; ++g)
      is_on = is_on && std::max(std::fabs(distance_to_guide(guides[g], from) - offset),
                                std::fabs(distance_to_guide(guides[g], to) - offset)) < 1e-15;
    if (!is_on) continue;
    ++checked_paths;
    const double chord = (to - from).norm();
    CentrePath path = CentrePath::curved(from, to, chord * tangent(from), chord * tangent(to));
    for (int g = 0; g < count; ++g) path.add_guide(guides[g]);
    for (int k = 0; k <= 32; ++k) {
      const double time = k / 32.0;
      const Vec3 p = path.at(time);
      const Vec3 slope = path.slope(time);
      for (int g = 0; g < count; ++g) {
        EXPECT_NEAR(distance_to_guide(guides[g], p), offset, 0x1p-50)
            << static_cast<int>(guides[0].part) << " and " << static_cast<int>(guides[1].part) << " time " << time;
        EXPECT_LE(std::fabs(normal(g, p).dot(slope)), 1e-14 * slope.norm());
      }
      if (k == 0 || k == 32) continue;
      constexpr double kStep = 1e-3;
      const Vec3 ahead = path.at(time + kStep);
      const Vec3 behind = path.at(time - kStep);
      EXPECT_LE(((ahead - behind) / (2.0 * kStep) - slope).norm(), 0x1p-11 * slope.norm());
      EXPECT_LE((ahead + behind - 2.0 * p).norm() / (kStep * kStep), 8.0 * path.bulge() + 1e-9) << "it bends more than it says";
    }
  }
  EXPECT_GT(checked_paths, 400);
}

// Also where the path turns back beyond an end of the chord: its slope is longer than the chord, or points away from it at first.
TEST_F(CentrePathTest, BulgesNoFartherFromItsChordThanItSays) {
  int samples_beyond = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 from = vector();
    const Vec3 along = direction();
    const Vec3 to = from + along;
    const double across = std::pow(10.0, between(-3.0, 0.0));
    const auto slope = [&] { return Vec3(between(-4.0, 8.0) * along + across * vector()); };
    const Vec3 slope_from = slope();
    const CentrePath path = CentrePath::curved(from, to, slope_from, slope());
    double largest_bulge = 0.0;
    for (int k = 1; k < 200; ++k) {
      const Vec3 p = path.at(k / 200.0);
      largest_bulge = std::max(largest_bulge, distance_from_segment(p, from, to));
      samples_beyond += std::fabs(along.dot(p - from) - 0.5) > 0.5 ? 1 : 0;
    }
    ASSERT_LE(largest_bulge, path.bulge() + 1e-15) << i;
  }
  EXPECT_GT(samples_beyond, 1000);
}

// In both directions: the end before the crest may be the higher one, or the end after it.
TEST_F(CentrePathTest, ACrestBetweenTwoEndsBelowThePlaneIsFoundForLongDirectionsToo) {
  for (int i = 0; i < 400; ++i) {
    const Vec3 from = vector();
    const Vec3 along = direction();
    const Vec3 up = along.unitOrthogonal();
    const double height = std::pow(10.0, between(-6.0, -1.0));
    const double drop = (i % 2 == 0 ? 1.0 : -1.0) * 2.0 * height;  // from the first end to the last
    const Vec3 chord = along - drop * up;
    // A parabola above the chord, which is `height` above it in the middle.
    const CentrePath path = CentrePath::curved(from, from + chord, chord + 4.0 * height * up, chord - 4.0 * height * up);
    const double crest = (std::fabs(drop) + std::pow(4.0 * height - std::fabs(drop), 2.0) / (16.0 * height)) - std::fabs(drop);
    const Vec3 highest = i % 2 == 0 ? from : Vec3(from + chord);
    const Vec3 origin = highest + 0.5 * crest * up;
    const double time = path.time_to_cross(origin, up, 0.0, 0.0, 1.0);
    ASSERT_LT(time, 1.0) << i;
    ASSERT_NEAR(up.dot(path.at(time) - origin), 0.0, 1e-14) << i;
    for (const double scale : {0x1p10, 0x1p20}) {
      ASSERT_NEAR(path.time_to_cross(origin, scale * up, 0.0, 0.0, 1.0), time, 1e-9) << i << ", scale " << scale;
      ASSERT_NEAR(path.time_to_cross(origin, scale * up, 0.0, path.prefix(1.0)), time, 1e-9) << i << ", scale " << scale;
    }
  }
}

// The first of many sampled times at which the path is beyond the plane by more than the margin; kNever if there is none.
double sampled_time_to_pass(const CentrePath& path, const Vec3& origin, const Vec3& normal, double margin, double until) {
  constexpr int kSamples = 4000;
  for (int i = 1; i <= kSamples; ++i) {
    if (normal.dot(path.at(until * i / kSamples) - origin) > margin) return until * i / kSamples;
  }
  return kNever;
}

TEST_F(CentrePathTest, TimeToPassIsThatOfDenseSampling) {
  int passed = 0;
  int crests = 0;
  for (int i = 0; i < 400; ++i) {
    const Arc a = arc(between(0.1, 0.5), between(0.02, 0.25), i % 3);
    const CentrePath path = i % 10 == 0 ? CentrePath::straight(a.at(0.0), a.at(1.0)) : a.path;
    const double length = (path.end() - path.start()).norm();
    const double until = i % 5 == 0 ? 0.7 : 1.0;
    // Every other plane is placed so that the path only just crosses it, or only just does not.
    Vec3 normal = direction();
    if (i % 2 == 0) normal = (a.out + 0.02 * vector() + (0.3 * a.angle) * a.tangent).normalized();
    const Vec3 origin = path.start() + between(0.001, 0.2) * length * (i % 2 == 0 ? 0.2 * length : 1.0) * normal;
    const double margin = i % 4 == 0 ? 0x1p-44 : 0.0;
    const double expected = sampled_time_to_pass(path, origin, normal, margin, until);
    const double time = path.time_to_cross(origin, normal, margin, 0.0, until);
    ASSERT_EQ(path.time_to_cross(origin, normal, margin, path.prefix(until)), time) << i;
    if (expected > 1.0) {
      ASSERT_EQ(time, kNever) << i;
      continue;
    }
    ++passed;
    crests += normal.dot(path.at(until) - origin) <= margin ? 1 : 0;
    ASSERT_LE(time, expected + 1e-12) << i;
    ASSERT_GE(time, expected - until / 3999.0) << i;
    ASSERT_NEAR(normal.dot(path.at(time) - origin), margin, 1e-14) << i;
  }
  EXPECT_GT(passed, 80);
  EXPECT_GT(crests, 10) << "of those that come back";
}

TEST_F(CentrePathTest, WhatIsBeyondAlreadyPassesAtOnceOnItsWayUpOnly) {
  const CentrePath path = CentrePath::straight(Vec3::Zero(), Vec3::UnitX());
  EXPECT_EQ(path.time_to_cross(Vec3(-0.5, 0, 0), Vec3::UnitX(), 0.0, 0.0, 1.0), 0.0);
  EXPECT_EQ(path.time_to_cross(Vec3(-0.5, 0, 0), Vec3::UnitX(), 0.0, 0.25, 1.0), 0.25);
  EXPECT_EQ(path.time_to_cross(Vec3(1.5, 0, 0), Vec3(-Vec3::UnitX()), 0.0, 0.0, 1.0), kNever);
  EXPECT_NEAR(path.time_to_cross(Vec3(0.4, 0, 0), Vec3::UnitX(), 0.1, 0.0, 1.0), 0.5, 1e-15);
}

class FindBlock : public CentrePathTest {
 protected:
  static constexpr Clearance kClearance{0.2, 0x1p-40, 0x1p-46};

  ContactTriangle triangle(int i) {
    const Vec3 a = 0.4 * vector();
    const Vec3 b = a + 0.4 * vector();
    return {a, b, i % 8 == 7 ? Vec3(a + 0.4 * (b - a) + 1e-7 * vector()) : Vec3(a + 0.4 * vector())};
  }
  // A position at the given distance from the triangle.
  Vec3 position_at(const ContactTriangle& shape, double distance) {
    for (;;) {
      const Vec3 p = shape.corner(0) + vector();
      const Separation at = shape.separation(p);
      if (at.distance > 0.05) return at.nearest + distance * at.normal;
    }
  }

  // Compares find_block() with the distance at many times. Returns true if the triangle blocks the path.
  static bool expect_block_as_sampled(const CentrePath& path, const ContactTriangle& shape, unsigned guiding, double until) {
    constexpr int kSamples = 2000;
    int tests = 0;
    const CentrePath::Block block = path.find_block(shape, kClearance, guiding, path.prefix(until), tests);
    EXPECT_GE(tests, 1);
    EXPECT_LE(tests, 160);
    const double end = std::min(block.time, until);
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= kSamples; ++i) least = std::min(least, shape.separation(path.at(end * i / kSamples)).distance);
    EXPECT_GE(least, kClearance.offset - kClearance.slop) << "violated before " << end;
    if (block.hits) {
      const Separation at = shape.separation(path.at(block.time));
      EXPECT_LE(at.distance, kClearance.offset + 2.0 * kClearance.tolerance) << "nothing is hit at " << block.time;
      EXPECT_LE(at.normal.dot(path.slope(block.time)), 1e-6 * path.slope(0.0).norm()) << "it leaves there";
    } else {
      EXPECT_TRUE(block.time == kNever || block.time < until);
    }
    return block.time < until;
  }
};

TEST_F(FindBlock, IsThatOfDenseSampling) {
  int blocked = 0;
  int hits = 0;
  int contacts = 0;
  for (int i = 0; i < 1200; ++i) {
    const ContactTriangle shape = triangle(i);
    const double gap = i % 4 == 0 ? 0.0 : i % 4 == 1 ? between(0.0, 1e-12) : i % 4 == 2 ? between(1e-9, 1e-4) : between(0.0, 0.1);
    const Vec3 from = position_at(shape, kClearance.offset + gap);
    const Vec3 way = (i % 3 == 0 ? Vec3(0.3 * vector()) : Vec3(direction() * (0.02 + 2.0 * gap)));
    CentrePath path = CentrePath::straight(from, from + way);
    if (i % 2 == 1) {
      const Vec3 turn = direction() * (0.125 * way.norm());
      path = CentrePath::curved(from, from + way, way + turn, way - turn);
    }
    const double until = i % 5 == 0 ? 0.6 : 1.0;
    blocked += expect_block_as_sampled(path, shape, 0U, until) ? 1 : 0;
    int tests = 0;
    hits += path.find_block(shape, kClearance, 0U, path.prefix(until), tests).hits ? 1 : 0;
    contacts += gap == 0.0 ? 1 : 0;
    if (HasFailure()) FAIL() << "path " << i;
  }
  EXPECT_GT(blocked, 200);
  EXPECT_LT(blocked, 900);
  EXPECT_GE(hits, blocked - 4) << "the search ended undecided";
  EXPECT_GT(contacts, 200);
}

// A path over the triangle's own offset surface grazes it from end to end.
TEST_F(FindBlock, WhatOnlyGrazesPasses) {
  for (int i = 0; i < 300; ++i) {
    const ContactTriangle shape = triangle(0);
    const Vec3 middle = (shape.corner(0) + shape.corner(1) + shape.corner(2)) / 3.0;
    const Vec3 from = middle + kClearance.offset * shape.normal();
    const Vec3 to = from + 0.2 * shape.edge(i % 3);
    int tests = 0;
    const auto block_on = [&](const Vec3& end) {
      const CentrePath path = CentrePath::straight(from, end);
      return path.find_block(shape, kClearance, 0U, path.prefix(1.0), tests);
    };
    EXPECT_EQ(block_on(to).time, kNever);
    // A path that goes down by less than half the slop still grazes; one that goes down by more does not.
    const Vec3 down = -shape.normal();
    EXPECT_EQ(block_on(to + 0.4 * kClearance.slop * down).time, kNever);
    const CentrePath::Block block = block_on(to + 1e-6 * down);
    EXPECT_TRUE(block.hits);
    EXPECT_LT(block.time, 1e-5);
  }
}

// The path begins over the middle of a face, parallel to it, goes down, and comes up again before its end.
TEST_F(FindBlock, APathThatBendsDownAndUpBlocksWhereItComesTooNear) {
  for (int i = 0; i < 300; ++i) {
    const ContactTriangle shape = triangle(0);
    const double gap = 0.3 * kClearance.slop;
    const double dip = i % 3 == 0 ? 0.6 * kClearance.slop : i % 3 == 1 ? 1.5 * kClearance.slop : between(1e-6, 1e-4);
    const Vec3 from = (shape.corner(0) + shape.corner(1) + shape.corner(2)) / 3.0 + (kClearance.offset + gap) * shape.normal();
    const Vec3 along = 0.01 * shape.edge(i % 3);
    // With a = 27 / 4 dip, the height above the start is a (t^3 - t^2): at its lowest, -4 a / 27 = -dip.
    const CentrePath path = CentrePath::curved(from, from + along, along, along + 27.0 / 4.0 * dip * shape.normal());
    int tests = 0;
    const CentrePath::Block block = path.find_block(shape, kClearance, 0U, path.prefix(1.0), tests);
    EXPECT_EQ(block.hits, i % 3 != 0) << "path " << i;
    expect_block_as_sampled(path, shape, 0U, 1.0);
    if (HasFailure()) FAIL() << "path " << i;
  }
}

TEST_F(FindBlock, ACornerThatGuidesThePathNeverBlocks) {
  int over_corner = 0;
  int into_face = 0;
  for (int i = 0; i < 1500; ++i) {
    const ContactTriangle shape = triangle(0);
    const int corner = i % 3;
    const Vec3& origin = shape.corner(corner);
    // The path begins on the sphere round the corner, where the corner is the nearest point of the triangle.
    const Vec3 from = origin + kClearance.offset * direction();
    if (shape.separation(from).nearest != origin) continue;
    const Vec3 out = (from - origin) / kClearance.offset;
    const Vec3 v = vector();
    const Vec3 way = (v - out.dot(v) * out).normalized();
    const double angle = 0.2;
    const Vec3 to = origin + kClearance.offset * (std::cos(angle) * out + std::sin(angle) * way);
    const double speed = kClearance.offset * angle;
    CentrePath path = CentrePath::curved(from, to, speed * way, speed * (std::cos(angle) * way - std::sin(angle) * out));
    path.add_guide({Feature::vertex, origin, Vec3::Zero(), kClearance.offset});
    bool is_corner_nearest = true;
    for (int k = 0; k <= 400; ++k) is_corner_nearest = is_corner_nearest && shape.separation(path.at(k / 400.0)).nearest == origin;
    int tests = 0;
    const CentrePath::Block block = path.find_block(shape, kClearance, 1U << corner, path.prefix(1.0), tests);
    if (is_corner_nearest) {
      ++over_corner;
      EXPECT_EQ(block.time, kNever);
    } else if (shape.separation(to).distance < kClearance.offset - 1e-6) {
      ++into_face;
      EXPECT_TRUE(block.hits);
      expect_block_as_sampled(path, shape, 1U << corner, 1.0);
    }
    if (HasFailure()) FAIL() << "path " << i;
  }
  EXPECT_GT(over_corner, 300);
  EXPECT_GT(into_face, 50);
}

// The path runs along an edge and passes its end at the offset: another edge that begins at that end is already ahead.
TEST_F(FindBlock, WhatBeginsAtACornerThatIsPassedBlocks) {
  int blocked = 0;
  for (int i = 0; i < 600; ++i) {
    // The guiding edge ends at the corner; the sphere moves along it at its offset, towards an edge of the triangle.
    const Vec3 corner = vector();
    const Vec3 along = direction();
    const Vec3 out = along.unitOrthogonal();
    const Vec3 side = along.cross(out);
    const double turn = between(0.1, 1.4);
    const Vec3 edge = std::cos(turn) * along + std::sin(turn) * out;
    const ContactTriangle shape(corner, corner + edge, corner + edge + between(0.2, 1.0) * (along - 0.2 * out) + 0.1 * unit() * side);
    const double length = std::pow(10.0, between(1.0, 3.0)) * kClearance.offset;
    const Vec3 from = corner - between(2.0, 6.0) * kClearance.offset * along + kClearance.offset * out;
    const Vec3 to = from + length * along;
    const Vec3 bend = 1e-13 * length * vector();  // as that of a curve that is straight up to rounding
    CentrePath path = CentrePath::curved(from, to, to - from + bend, to - from - bend);
    path.add_guide({Feature::edge, corner, along, kClearance.offset});
    int tests = 0;
    const CentrePath::Block block = path.find_block(shape, kClearance, 1U, path.prefix(1.0), tests);
    if (length < 12.0 * kClearance.offset || shape.separation(from).distance < 1.01 * kClearance.offset) continue;
    ++blocked;
    ASSERT_TRUE(block.hits) << "path " << i;
    EXPECT_NEAR(shape.separation(path.at(block.time)).distance, kClearance.offset, 2.0 * kClearance.slop) << "path " << i;
  }
  EXPECT_GT(blocked, 300);
}

// The path goes round an edge or a corner. A displaced copy is beside that, at nearly the same distance all along the path.
TEST_F(FindBlock, ACopyBesideWhatGuidesThePathIsDecided) {
  int hits = 0;
  int passes = 0;
  for (int i = 0; i < 1200; ++i) {
    const bool is_corner = i % 3 == 0;
    const Arc roll = arc(kClearance.offset, between(0.02, 0.125), is_corner ? 2 : 1);
    const auto displaced = [&] { return Vec3(std::pow(10.0, between(-15.0, -7.0)) * vector()); };
    const double ahead = i % 2 == 0 ? 0.0 : std::pow(10.0, between(-12.0, -7.0));  // shift of the copy towards where the sphere goes
    const Vec3 beside = roll.middle + (ahead > 0.0 ? Vec3(ahead * (roll.tangent - 0.01 * roll.angle * roll.out)) : displaced());
    // The triangle lies on the other side of the edge, or begins at the corner.
    const Vec3 below = -between(0.2, 1.0) * (std::cos(0.5 * roll.angle) * roll.out + std::sin(0.5 * roll.angle) * roll.tangent);
    const Vec3 along = between(0.2, 1.0) * roll.axis;
    const Vec3 other = is_corner ? Vec3(0.1 * along + 0.5 * below) : Vec3(2.0 * along + (ahead > 0.0 ? Vec3(Vec3::Zero()) : displaced()));
    const ContactTriangle shape(i % 3 == 1 ? Vec3(beside - along) : beside, beside + other, beside + below + unit() * along);
    if (shape.separation(roll.at(0.0)).distance < kClearance.offset) continue;
    int tests = 0;
    const CentrePath::Block block = roll.path.find_block(shape, kClearance, 0U, roll.path.prefix(1.0), tests);
    EXPECT_TRUE(block.hits || block.time == kNever) << "undecided at " << block.time;
    expect_block_as_sampled(roll.path, shape, 0U, 1.0);
    (block.hits ? hits : passes) += 1;
    if (HasFailure()) FAIL() << "path " << i;
  }
  EXPECT_GT(hits, 200);
  EXPECT_GT(passes, 200);
}

// The path goes round an edge or a corner. Beside that is a displaced copy whose triangle leads to where the sphere goes: the sphere first
// stays at its distance from the copy, and then meets the triangle.
TEST_F(FindBlock, WhatGoesOnFromACopyBesideWhatGuidesThePathBlocks) {
  int hits = 0;
  for (int i = 0; i < 1500; ++i) {
    const bool is_corner = i % 3 == 0;
    const Arc roll = arc(kClearance.offset, between(0.05, 0.3), i % 3 == 2 ? 1 : is_corner ? 2 : 1);
    const auto displaced = [&] { return Vec3(std::pow(10.0, between(-16.0, -9.0)) * vector()); };
    // From the angle `turn` on, the triangle is nearer than the copy.
    const double turn = between(0.1, 0.9) * roll.angle;
    const Vec3 ahead = 0.5 * (std::cos(turn) * roll.tangent - std::sin(turn) * roll.out);
    const Vec3 below = -0.5 * roll.out - 0.2 * roll.tangent;
    const Vec3 along = 0.3 * roll.axis;
    const Vec3 copy = roll.middle + displaced();
    const Vec3 corners[] = {i % 3 == 1 ? Vec3(copy - along) : copy,
                            i % 3 == 1 ? Vec3(copy + along + displaced()) : Vec3(copy + below + unit() * along),
                            Vec3(copy + ahead + (is_corner ? unit() : 0.0) * along)};
    const int first = static_cast<int>(between(0.0, 2.99));
    const bool is_turned = unit() < 0.0;
    const ContactTriangle shape(corners[first], corners[(first + (is_turned ? 2 : 1)) % 3], corners[(first + (is_turned ? 1 : 2)) % 3]);
    if (shape.separation(roll.at(0.0)).distance < kClearance.offset) continue;
    int tests = 0;
    hits += roll.path.find_block(shape, kClearance, 0U, roll.path.prefix(1.0), tests).hits ? 1 : 0;
    expect_block_as_sampled(roll.path, shape, 0U, 1.0);
    if (HasFailure()) FAIL() << "path " << i;
  }
  EXPECT_GT(hits, 400);
}

}  // namespace
}  // namespace hapton
