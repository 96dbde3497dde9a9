#include "core/collision/triangle_pair.h"

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_int.hpp>
#include <random>
#include <vector>

#include "bench/haptons/extended_pair.h"
#include "core/math/orient3d.h"

namespace hapton {
namespace {

class Random {
 public:
  explicit Random(std::uint64_t seed) : random_(seed) {}
  double real(double scale) { return std::uniform_real_distribution<double>(-scale, scale)(random_); }
  Vec3 point(double scale) { return {real(scale), real(scale), real(scale)}; }
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  Vec3 grid_point(int n) {
    return {static_cast<double>(integer(-n, n)), static_cast<double>(integer(-n, n)), static_cast<double>(integer(-n, n))};
  }

 private:
  std::mt19937_64 random_;
};

TrianglePair random_pair(Random& random, double scale, const Vec3& place) {
  TrianglePair pair;
  for (Vec3& p : pair.a) p = place + random.point(scale);
  for (Vec3& p : pair.b) p = place + random.point(scale);
  return pair;
}

// --- The exact twin, in rational numbers: two triangles meet if an edge of one, end points included, meets the other ------------

using Exact = boost::multiprecision::cpp_rational;
using ExactPoint = std::array<Exact, 3>;

ExactPoint exact(const Vec3& p) { return {Exact(p.x()), Exact(p.y()), Exact(p.z())}; }
ExactPoint minus(const ExactPoint& a, const ExactPoint& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Exact dot(const ExactPoint& a, const ExactPoint& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
ExactPoint cross(const ExactPoint& a, const ExactPoint& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
bool is_zero(const ExactPoint& a) { return a[0] == 0 && a[1] == 0 && a[2] == 0; }

using ExactCorners = std::array<ExactPoint, 3>;
ExactCorners exact(const std::array<Vec3, 3>& t) { return {exact(t[0]), exact(t[1]), exact(t[2])}; }
ExactPoint normal_of(const ExactCorners& t) { return cross(minus(t[1], t[0]), minus(t[2], t[0])); }

bool covers(const ExactCorners& t, const ExactPoint& n, const ExactPoint& x) {
  for (int i = 0; i < 3; ++i) {
    if (dot(n, cross(minus(t[(i + 1) % 3], t[i]), minus(x, t[i]))) < 0) return false;
  }
  return true;
}

// Segment p + s (q - p) against segment r + t (v - r) in one plane with normal n.
bool segments_meet(const ExactPoint& p, const ExactPoint& q, const ExactPoint& r, const ExactPoint& v, const ExactPoint& n) {
  const auto side = [&](const ExactPoint& a, const ExactPoint& b, const ExactPoint& c) { return dot(n, cross(minus(b, a), minus(c, a))); };
  return side(p, q, r) * side(p, q, v) < 0 && side(r, v, p) * side(r, v, q) < 0;
}

bool edge_meets(const ExactPoint& p, const ExactPoint& q, const ExactCorners& t) {
  const ExactPoint n = normal_of(t);
  const Exact p_height = dot(n, minus(p, t[0]));
  const Exact q_height = dot(n, minus(q, t[0]));
  if (p_height * q_height > 0) return false;
  if (p_height == 0 && q_height == 0) {
    if (covers(t, n, p) || covers(t, n, q)) return true;
    for (int i = 0; i < 3; ++i) {
      if (segments_meet(p, q, t[i], t[(i + 1) % 3], n)) return true;
      // Is this corner of t on the segment?
      const ExactPoint from_p = minus(t[i], p);
      const ExactPoint edge = minus(q, p);
      if (is_zero(cross(from_p, edge)) && dot(from_p, edge) >= 0 && dot(from_p, edge) <= dot(edge, edge)) return true;
    }
    return false;
  }
  const Exact s = p_height / (p_height - q_height);
  const ExactPoint edge = minus(q, p);
  return covers(t, n, {p[0] + s * edge[0], p[1] + s * edge[1], p[2] + s * edge[2]});
}

bool meet_exactly(const TrianglePair& pair) {
  const ExactCorners a = exact(pair.a);
  const ExactCorners b = exact(pair.b);
  if (is_zero(normal_of(a)) || is_zero(normal_of(b))) return false;
  for (int i = 0; i < 3; ++i) {
    if (edge_meets(a[i], a[(i + 1) % 3], b) || edge_meets(b[i], b[(i + 1) % 3], a)) return true;
  }
  return false;
}

// The largest of the distances by which a point lies off a triangle's plane and beyond its edges.
double outside_by(const std::array<Vec3, 3>& t, const Vec3& p) {
  const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
  double worst = std::fabs(n.dot(p - t[0]));
  for (int i = 0; i < 3; ++i) {
    const Vec3 edge = t[(i + 1) % 3] - t[i];
    worst = std::max(worst, -n.cross(edge).normalized().dot(p - t[i]));
  }
  return worst;
}

// ---------------------------------------------------------------------------------------------------------------------------------

TEST(IntersectTriangles, LocatesTheSegment) {
  const TrianglePair pair = {{Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)}, {Vec3(1, 1, -1), Vec3(1, 1, 1), Vec3(-5, 1, 0)}};
  const TriangleContact contact = intersect_triangles(pair);
  ASSERT_TRUE(contact.meets);
  EXPECT_FALSE(contact.coplanar);
  const Vec3 direction = (pair.a[1] - pair.a[0]).cross(pair.a[2] - pair.a[0]).cross((pair.b[1] - pair.b[0]).cross(pair.b[2] - pair.b[0]));
  EXPECT_GT((contact.end - contact.begin).dot(direction), 0.0);
  const Vec3 left = contact.begin.x() < contact.end.x() ? contact.begin : contact.end;
  const Vec3 right = contact.begin.x() < contact.end.x() ? contact.end : contact.begin;
  EXPECT_NEAR((left - Vec3(0, 1, 0)).norm(), 0.0, 1e-15);
  EXPECT_NEAR((right - Vec3(1, 1, 0)).norm(), 0.0, 1e-15);
}

// Every kind of contact on a coarse grid: shared corners, edges in planes, coplanar pairs, needles.
TEST(IntersectTriangles, DecidesAsRationalsDoOnAGrid) {
  Random random(11);
  int meeting = 0;
  int coplanar = 0;
  int touching = 0;
  for (int i = 0; i < 6000; ++i) {
    const int n = random.integer(1, 3);
    TrianglePair pair;
    for (Vec3& p : pair.a) p = random.grid_point(n);
    for (Vec3& p : pair.b) p = random.grid_point(n);
    if (i % 4 == 0) {
      for (int k = 0; k < 3; ++k) pair.a[k].z() = pair.b[k].z() = 1.0;
    }
    const TriangleContact contact = intersect_triangles(pair);
    ASSERT_EQ(contact.meets, meet_exactly(pair)) << i;
    if (!contact.meets) continue;
    ++meeting;
    coplanar += contact.coplanar ? 1 : 0;
    touching += contact.begin == contact.end ? 1 : 0;
    for (const Vec3& p : {contact.begin, contact.end}) {
      ASSERT_LT(outside_by(pair.a, p), 1e-13) << i;
      ASSERT_LT(outside_by(pair.b, p), 1e-13) << i;
    }
  }
  EXPECT_GT(meeting, 1000);
  EXPECT_GT(coplanar, 300);
  EXPECT_GT(touching, 100);
}

// Near misses and near contacts far from the origin, where rounding would decide in plain doubles.
TEST(IntersectTriangles, DecidesAsRationalsDoNearTheLimit) {
  Random random(12);
  for (int i = 0; i < 1500; ++i) {
    const Vec3 place = random.point(1e3);
    TrianglePair pair = random_pair(random, 1.0, place);
    // Moves a corner of b onto a's plane, or an edge of b through an edge of a, as exactly as doubles allow.
    const double s = random.real(0.5) + 0.5;
    const Vec3 on_edge = pair.a[0] + s * (pair.a[1] - pair.a[0]);
    if (i % 2 == 0) {
      pair.b[0] = on_edge + (random.real(0.25) + 0.25) * (pair.a[2] - on_edge);
    } else {
      pair.b[1] = pair.b[0] + (random.real(0.5) + 1.5) * (on_edge - pair.b[0]);
    }
    ASSERT_EQ(intersect_triangles(pair).meets, meet_exactly(pair)) << i;
  }
}

TEST(IntersectTriangles, IsTheSameInEveryOrder) {
  Random random(13);
  for (int i = 0; i < 2000; ++i) {
    const TrianglePair pair = random_pair(random, 1.0, Vec3::Zero());
    const TriangleContact contact = intersect_triangles(pair);
    const TrianglePair swapped = {pair.b, pair.a};
    const TrianglePair turned = {{pair.a[2], pair.a[0], pair.a[1]}, {pair.b[1], pair.b[0], pair.b[2]}};
    for (const TrianglePair& other : {swapped, turned}) {
      const TriangleContact same = intersect_triangles(other);
      ASSERT_EQ(same.meets, contact.meets);
      ASSERT_LT(std::min((same.begin - contact.begin).norm(), (same.begin - contact.end).norm()), 1e-9);
      ASSERT_LT(std::min((same.end - contact.begin).norm(), (same.end - contact.end).norm()), 1e-9);
    }
  }
}

// At every scale and position, and also for planes that are parallel to within 1e-12.
TEST(IntersectTriangles, LocatesWithinItsBound) {
  Random random(14);
  int compared = 0;
  for (int i = 0; i < 20000; ++i) {
    const double scale = std::ldexp(1.0, random.integer(-40, 40));
    TrianglePair pair = random_pair(random, scale, random.point(scale * std::ldexp(1.0, random.integer(-5, 5))));
    if (i % 3 == 0) {  // b nearly in a's plane
      const double height_factor = std::pow(10.0, -random.integer(1, 12));
      const Vec3 n = (pair.a[1] - pair.a[0]).cross(pair.a[2] - pair.a[0]).normalized();
      for (Vec3& p : pair.b) p -= (1.0 - height_factor) * n.dot(p - pair.a[0]) * n;
    }
    const ExtendedContact exact = intersect_extended(pair);
    const TriangleContact contact = intersect_triangles(pair);
    if (!contact.meets || exact.count != 2) continue;
    ++compared;
    double magnitude = 0.0;
    for (int k = 0; k < 3; ++k) magnitude = std::max({magnitude, pair.a[k].cwiseAbs().maxCoeff(), pair.b[k].cwiseAbs().maxCoeff()});
    const double longest = 2.0 * std::sqrt(3.0) * scale;
    // The error of extended precision itself is about 2^-64 / angle: far below this bound for angles down to 1e-12.
    ASSERT_LT(location_error(contact, exact), 0x1p-18 * longest + 0x1p-50 * magnitude) << i;
  }
  EXPECT_GT(compared, 4000);
}

TEST(IntersectTriangles, IgnoresDegenerateTriangles) {
  const std::array<Vec3, 3> face = {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)};
  EXPECT_FALSE(intersect_triangles({face, {Vec3(1, 1, -1), Vec3(1, 1, 1), Vec3(1, 1, 0)}}).meets);
  EXPECT_FALSE(intersect_triangles({face, {Vec3(1, 1, 0), Vec3(1, 1, 0), Vec3(1, 1, 0)}}).meets);
  EXPECT_FALSE(intersect_triangles({{Vec3(1, 1, 0), Vec3(2, 1, 0), Vec3(3, 1, 0)}, face}).meets);
}

// --- Eight at once ---------------------------------------------------------------------------------------------------------------

struct Tally {
  int meeting = 0;
  int apart = 0;
  int undecided = 0;
};

// A decided lane must agree with the exact decision, and its error, measured in extended precision, must not exceed the error that it
// states.
Tally count_decisions(const std::vector<TrianglePair>& pairs) {
  Tally tally;
  for (std::size_t first = 0; first + 8 <= pairs.size(); first += 8) {
    TrianglePairs8 packed;
    pack_8(&pairs[first], packed);
    TriangleContacts8 found;
    intersect_8(packed, found);
    EXPECT_EQ(found.meets & found.undecided, 0);
    for (int lane = 0; lane < 8; ++lane) {
      const TrianglePair& pair = pairs[first + lane];
      if ((found.undecided >> lane & 1) != 0) {
        ++tally.undecided;
        continue;
      }
      const bool meets = (found.meets >> lane & 1) != 0;
      EXPECT_EQ(meets, intersect_triangles(pair).meets) << first + lane;
      ++(meets ? tally.meeting : tally.apart);
      if (!meets) continue;
      const ExtendedContact exact = intersect_extended(pair);
      EXPECT_EQ(exact.count, 2);
      TriangleContact contact;
      contact.begin = pair.a[0] + Vec3(found.begin[0][lane], found.begin[1][lane], found.begin[2][lane]);
      contact.end = pair.a[0] + Vec3(found.end[0][lane], found.end[1][lane], found.end[2][lane]);
      const double error = location_error(contact, exact);
      EXPECT_LE(error, static_cast<double>(found.error[lane]));
      EXPECT_LE(static_cast<double>(found.error[lane]), 1e-3 * size_of(pair));
    }
  }
  return tally;
}

TEST(Intersect8, IsRightWhereItIsCertain) {
  Random random(21);
  std::vector<TrianglePair> pairs;
  for (int i = 0; i < 80000; ++i) pairs.push_back(random_pair(random, 1.0, Vec3::Zero()));
  const Tally tally = count_decisions(pairs);
  EXPECT_GT(tally.meeting, 10000);
  EXPECT_GT(tally.apart, 30000);
  EXPECT_LT(tally.undecided, 2000);  // close cases are rare among random pairs
}

TEST(Intersect8, IsRightAtEveryScaleAndPlace) {
  Random random(22);
  std::vector<TrianglePair> pairs;
  for (int i = 0; i < 40000; ++i) {
    const double scale = std::ldexp(1.0, random.integer(-20, 20));
    pairs.push_back(random_pair(random, scale, random.point(1e6 * scale)));
  }
  EXPECT_LT(count_decisions(pairs).undecided, 1000);
}

TEST(Intersect8, IsRightForUnequalSizes) {
  Random random(23);
  std::vector<TrianglePair> pairs;
  for (int i = 0; i < 40000; ++i) {
    TrianglePair pair = random_pair(random, 1.0, Vec3::Zero());
    const double small = std::ldexp(1.0, -random.integer(0, 24));
    const Vec3 target = (pair.a[0] + pair.a[1] + pair.a[2]) / 3.0;
    for (Vec3& p : pair.b) p = target + small * p;
    if (i % 2 != 0) std::swap(pair.a, pair.b);
    pairs.push_back(pair);
  }
  const Tally tally = count_decisions(pairs);
  EXPECT_GT(tally.meeting, 2000);
}

// Shallow angles, shallow depths, needles: cases that single precision must report as undecided.
TEST(Intersect8, LeavesCloseCasesUndecided) {
  Random random(24);
  std::vector<TrianglePair> pairs;
  for (int i = 0; i < 80000; ++i) {
    TrianglePair pair = random_pair(random, 1.0, Vec3::Zero());
    const double deviation = std::pow(10.0, -random.integer(1, 9));
    const Vec3 n = (pair.a[1] - pair.a[0]).cross(pair.a[2] - pair.a[0]).normalized();
    if (i % 4 == 0) {  // b nearly in a's plane
      for (Vec3& p : pair.b) p -= (1.0 - deviation) * n.dot(p - pair.a[0]) * n;
    } else if (i % 4 == 1) {  // a corner of b just over or under a's plane
      pair.b[0] -= (n.dot(pair.b[0] - pair.a[0]) - random.real(deviation)) * n;
    } else if (i % 4 == 2) {  // an edge of b past an edge of a
      const Vec3 on_edge = pair.a[0] + (random.real(0.5) + 0.5) * (pair.a[1] - pair.a[0]);
      pair.b[1] = pair.b[0] + 1.5 * (on_edge + random.point(deviation) - pair.b[0]);
    } else {  // a needle
      pair.b[2] = pair.b[0] + (random.real(0.5) + 0.5) * (pair.b[1] - pair.b[0]) + random.point(deviation);
    }
    pairs.push_back(pair);
  }
  const Tally tally = count_decisions(pairs);
  EXPECT_GT(tally.meeting, 5000);
  EXPECT_GT(tally.undecided, 5000);
}

TEST(PackPair, StoresCornersRelativeToTheFirstAndKeepsTheOtherLanes) {
  Random random(26);
  const TrianglePair pair = random_pair(random, 1.0, Vec3(5.0, -3.0, 2.0));
  for (int lane = 0; lane < 8; ++lane) {
    TrianglePairs8 packed = {};
    pack_pair(pair, lane, packed);
    for (int other = 0; other < 8; ++other) {
      for (int corner = 0; corner < 3; ++corner) {
        for (int axis = 0; axis < 3; ++axis) {
          const bool is_own = other == lane;
          EXPECT_EQ(packed.a[corner][axis][other], is_own ? static_cast<float>(pair.a[corner][axis] - pair.a[0][axis]) : 0.0F);
          EXPECT_EQ(packed.b[corner][axis][other], is_own ? static_cast<float>(pair.b[corner][axis] - pair.a[0][axis]) : 0.0F);
        }
      }
    }
  }
}

TEST(Intersect8, LeavesDegenerateLanesUndecided) {
  TrianglePairs8 packed;
  const TrianglePair identical = {{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}};
  const TrianglePair point = {{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, {Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, 0)}};
  for (int lane = 0; lane < 8; ++lane) pack_pair(lane % 2 == 0 ? identical : point, lane, packed);
  TriangleContacts8 found;
  intersect_8(packed, found);
  EXPECT_EQ(found.undecided, 0xFF);
  EXPECT_EQ(found.meets, 0);
}

TEST(IntersectPairs, AgreesWithTheTestOfEachPairAlone) {
  Random random(25);
  std::vector<TrianglePair> pairs;
  for (int i = 0; i < 4003; ++i) {
    TrianglePair pair = random_pair(random, 1.0, random.point(10.0));
    if (i % 5 == 0) pair.b[0] = pair.a[1];
    pairs.push_back(pair);
  }
  std::vector<TriangleContact> contacts(pairs.size());
  const std::size_t fallbacks = intersect_pairs(pairs, contacts);
  // Every fifth pair shares a corner, which single precision cannot decide.
  EXPECT_GE(fallbacks, pairs.size() / 5);
  EXPECT_LT(fallbacks, pairs.size() / 4);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const TriangleContact one = intersect_triangles(pairs[i]);
    ASSERT_EQ(contacts[i].meets, one.meets) << i;
    if (!one.meets) continue;
    ASSERT_LT((contacts[i].begin - one.begin).norm(), 1e-3 * size_of(pairs[i]));
    ASSERT_LT((contacts[i].end - one.end).norm(), 1e-3 * size_of(pairs[i]));
  }
}

}  // namespace
}  // namespace hapton
