#include "core/collision/triangle_cache.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "core/collision/swept_sphere.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

// The index lists of a mesh, with the mesh's triangle for each number of the geometry: a reference that searches whole lists.
class IndexLists {
 public:
  IndexLists(const TriangleMesh& mesh, const TouchGeometry& geometry) : mesh_(mesh), of_(mesh.triangles.size()) {
    const auto key = [](const Vec3& a, const Vec3& b, const Vec3& c) {
      std::array<std::int64_t, 9> rounded;
      for (int i = 0; i < 9; ++i) rounded[i] = std::llround((i < 3 ? a : i < 6 ? b : c)[i % 3] * 1e9);
      return rounded;
    };
    std::map<std::array<std::int64_t, 9>, std::uint32_t> by_place;
    for (std::uint32_t t = 0; t < of_.size(); ++t) by_place[key(geometry.corner(t, 0), geometry.corner(t, 1), geometry.corner(t, 2))] = t;
    EXPECT_EQ(by_place.size(), of_.size()) << "two triangles in one place";
    for (std::size_t i = 0; i < of_.size(); ++i) {
      const std::uint32_t t = by_place.at(
          key(geometry.to_local(mesh.corner(i, 0)), geometry.to_local(mesh.corner(i, 1)), geometry.to_local(mesh.corner(i, 2))));
      of_[i] = t;
      index_[t] = i;
    }
  }

  // Number in the geometry, its edge, and whether it runs along it the other way.
  struct Beyond {
    std::uint32_t triangle = 0;
    int edge = 0;
    bool same_orientation = false;
  };
  std::vector<Beyond> adjacent(std::uint32_t triangle, int k) const {
    const Triangle& own = mesh_.triangles[index_.at(triangle)];
    const std::uint32_t from = own[k];
    const std::uint32_t to = own[(k + 1) % 3];
    std::vector<Beyond> found;
    for (std::size_t i = 0; i < of_.size(); ++i) {
      if (of_[i] == triangle) continue;
      for (int edge = 0; edge < 3; ++edge) {
        const std::uint32_t first = mesh_.triangles[i][edge];
        const std::uint32_t second = mesh_.triangles[i][(edge + 1) % 3];
        if ((first == to && second == from) || (first == from && second == to)) found.push_back({of_[i], edge, first == to});
      }
    }
    return found;
  }
  int count_at_vertex(std::uint32_t triangle, int k) const {
    const std::uint32_t vertex = mesh_.triangles[index_.at(triangle)][k];
    return static_cast<int>(std::count_if(mesh_.triangles.begin(), mesh_.triangles.end(),
                                          [&](const Triangle& t) { return std::find(t.begin(), t.end(), vertex) != t.end(); }));
  }

 private:
  const TriangleMesh& mesh_;
  std::vector<std::uint32_t> of_;               // number in the geometry, by triangle of the mesh
  std::map<std::uint32_t, std::size_t> index_;  // the inverse
};

// Cases found by the comparison with the index lists.
struct Seen {
  std::size_t edges = 0, boundary = 0, non_manifold = 0, flipped = 0, corners = 0;
};

Seen compare_with_index_lists(const TriangleMesh& mesh, double half, int regions, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const TouchGeometry geometry({&mesh});
  const IndexLists lists(mesh, geometry);
  TriangleCache near;
  Seen seen;
  for (int i = 0; i < regions; ++i) {
    const auto triangle = static_cast<std::uint32_t>(random() % geometry.triangle_count());
    const Vec3& middle = geometry.corner(triangle, static_cast<int>(random() % 3));
    const Box region{middle.array() - half, middle.array() + half};
    if (!near.rebuild(geometry, region)) continue;
    std::set<std::uint32_t> here;
    for (std::uint32_t slot = 0; slot < static_cast<std::uint32_t>(near.count()); ++slot) {
      const std::uint32_t t = near.triangle_at(slot);
      here.insert(t);
      EXPECT_EQ(near.slot_of(t), slot);
      for (int k = 0; k < 3; ++k) {
        const Vec3& from = geometry.corner(t, k);
        if (region.overlaps(Box::around(from, from))) {
          EXPECT_EQ(near.count_at_vertex(slot, k), lists.count_at_vertex(t, k));
          ++seen.corners;
        }
        if (!region.overlaps(Box::around(from, geometry.corner(t, (k + 1) % 3)))) continue;
        const TriangleCache::Adjacent adjacent = near.adjacent(slot, k);
        const auto expected = lists.adjacent(t, k);
        ++seen.edges;
        seen.boundary += expected.empty() ? 1 : 0;
        seen.non_manifold += expected.size() > 1 ? 1 : 0;
        if (expected.size() != 1) {
          EXPECT_EQ(adjacent.slot, TriangleCache::kNoSlot);
          continue;
        }
        seen.flipped += expected[0].same_orientation ? 0 : 1;
        EXPECT_EQ(adjacent.slot, near.slot_of(expected[0].triangle));
        EXPECT_EQ(adjacent.edge, expected[0].edge);
        EXPECT_EQ(adjacent.same_orientation, expected[0].same_orientation);
      }
    }
    for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t) {
      EXPECT_EQ(near.slot_of(t) == TriangleCache::kNoSlot, !here.contains(t));
    }
  }
  return seen;
}

double distance_of(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
  const auto to_segment = [](const Vec3& point, const Vec3& a, const Vec3& b) {
    const Vec3 ab = b - a;
    const double squared = ab.squaredNorm();
    return (a + (squared > 0.0 ? std::clamp((point - a).dot(ab) / squared, 0.0, 1.0) : 0.0) * ab - point).norm();
  };
  double least = std::min({to_segment(p, r, s), to_segment(q, r, s), to_segment(r, p, q), to_segment(s, p, q)});
  const Vec3 u = q - p;
  const Vec3 v = s - r;
  const Vec3 normal = u.cross(v);
  const double squared = normal.squaredNorm();
  if (squared > 0.0) {
    const double t = (r - p).cross(v).dot(normal) / squared;
    const double w = (r - p).cross(u).dot(normal) / squared;
    if (t >= 0.0 && t <= 1.0 && w >= 0.0 && w <= 1.0) least = std::min(least, (p + t * u - r - w * v).norm());
  }
  return least;
}

// Between a segment and a triangle, in double precision, all cases.
double distance_of(const Vec3& p, const Vec3& q, const TouchGeometry& geometry, std::uint32_t t) {
  const Vec3& a = geometry.corner(t, 0);
  const Vec3& b = geometry.corner(t, 1);
  const Vec3& c = geometry.corner(t, 2);
  const Vec3 normal = (b - a).cross(c - a);
  const double before = normal.dot(p - a);
  const double after = normal.dot(q - a);
  if (before * after < 0.0) {
    const Vec3 on = p + before / (before - after) * (q - p);
    if ((b - a).cross(on - a).dot(normal) >= 0.0 && (c - b).cross(on - b).dot(normal) >= 0.0 && (a - c).cross(on - c).dot(normal) >= 0.0)
      return 0.0;
  }
  return std::min({geometry.separation(t, p).distance, geometry.separation(t, q).distance, distance_of(p, q, a, b), distance_of(p, q, b, c),
                   distance_of(p, q, c, a)});
}

double distance_of(const std::vector<Vec3>& path, const TouchGeometry& geometry, std::uint32_t t) {
  double least = geometry.separation(t, path[0]).distance;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) least = std::min(least, distance_of(path[i], path[i + 1], geometry, t));
  return least;
}

// A path of a point on the surface: from triangle to triangle over their edges, lifted by up to `lift`. `except` has the triangles passed;
// in one of three paths, one of them is missing.
struct Stroll {
  std::vector<Vec3> path;
  std::vector<std::uint32_t> except;  // slots
};
Stroll stroll_over(TriangleCache& near, std::uint32_t slot, double lift, std::mt19937_64& random) {
  std::uniform_real_distribution<double> part(0.05, 0.95);
  const auto inside = [&](const ContactTriangle& face) {
    const double u = part(random);
    const double v = part(random) * (1.0 - u);
    return Vec3(face.corner(0) - u * face.edge(2) + v * face.edge(0) + lift * part(random) * face.normal());
  };
  Stroll stroll{{inside(near.shape(slot))}, {slot}};
  const int edges = static_cast<int>(random() % 6);
  for (int i = 0; i < edges; ++i) {
    const int k = static_cast<int>(random() % 3);
    const TriangleCache::Adjacent adjacent = near.adjacent(slot, k);
    if (adjacent.slot == TriangleCache::kNoSlot) break;
    const ContactTriangle& face = near.shape(slot);
    stroll.path.push_back(face.corner(k) + part(random) * face.edge(k));
    slot = adjacent.slot;
    stroll.except.push_back(slot);
    if (random() % 2 == 0) stroll.path.push_back(inside(near.shape(slot)));
  }
  if (random() % 3 == 0) stroll.except.erase(stroll.except.begin() + static_cast<int>(random() % stroll.except.size()));
  return stroll;
}

// Every triangle that really blocks a motion must be listed, with a time no later than the real one.
TEST(TriangleCache, NeverDropsATriangleThatBlocks) {
  constexpr unsigned kSeed = 2027;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const TriangleMesh mesh = make_bumpy_sphere(0.05, 0.1, 20000, 3);
  const TouchGeometry geometry({&mesh});
  TriangleCache near;
  std::array<TriangleCache::Candidate, TriangleCache::kCapacity> candidates;
  std::size_t blocking = 0;
  std::size_t listed = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto triangle = static_cast<std::uint32_t>(random() % geometry.triangle_count());
    const double contact_offset = 0x1p-30;
    const double rest = (i % 3) * 0.004 + contact_offset;
    const Clearance clearance{.offset = rest, .slop = 0.5 * contact_offset, .tolerance = 0x1p-10 * contact_offset};
    const Vec3 centroid = (geometry.corner(triangle, 0) + geometry.corner(triangle, 1) + geometry.corner(triangle, 2)) / 3.0;
    const Vec3 start = centroid + 0.01 * Vec3(unit(random), unit(random), unit(random));
    const Vec3 motion = 0.008 * Vec3(unit(random), unit(random), unit(random));
    const Box path = Box::around(start, start + motion).inflated(rest);
    if (!near.rebuild(geometry, path.inflated(0.001))) continue;
    ASSERT_TRUE(near.covers(path));
    const int count = near.find_candidates(start, motion, rest, path, candidates);
    listed += static_cast<std::size_t>(count);
    for (int m = 1; m < count; ++m) EXPECT_LE(candidates[0].earliest, candidates[m].earliest);
    for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t) {
      if (geometry.separation(t, start).distance <= rest) continue;
      const double time = time_to_block(TriangleView{geometry, t}, start, motion, 1.0, clearance);
      if (time > 1.0) continue;
      ++blocking;
      const auto at =
          std::find_if(candidates.begin(), candidates.begin() + count, [&](const auto& candidate) { return candidate.triangle == t; });
      ASSERT_NE(at, candidates.begin() + count) << "case " << i << ": triangle " << t << " blocks at " << time << " and was not listed";
      EXPECT_LE(static_cast<double>(at->earliest), time);
      EXPECT_EQ(near.shape(at->slot).corner(0), geometry.corner(t, 0));
    }
    if (i > 300) break;  // brute force over all triangles is slow; 300 cases have thousands of blockers
  }
  EXPECT_GT(blocking, 200U);
  EXPECT_LT(listed, 40 * blocking) << "the filter lets nearly everything through";
}

TEST(TriangleCache, HoldsExactlyWhatOverlapsItsRegion) {
  const TriangleMesh mesh = make_icosphere(0.05, 4);
  const TouchGeometry geometry({&mesh});
  TriangleCache near;
  const Vec3 top = geometry.to_local({0, 0, 0.05});
  ASSERT_TRUE(near.rebuild(geometry, Box{top.array() - 0.05, top.array() + 0.05}));
  std::size_t expected = 0;
  geometry.for_each_overlapping(Box{top.array() - 0.05, top.array() + 0.05}, [&](std::uint32_t) { ++expected; });
  EXPECT_EQ(static_cast<std::size_t>(near.count()), expected);
  EXPECT_GT(expected, 4U);
}

TEST(TriangleCache, SaysWhenThereIsTooMuch) {
  const TriangleMesh mesh = make_icosphere(0.05, 4);
  const TouchGeometry geometry({&mesh});
  TriangleCache near;
  EXPECT_FALSE(near.rebuild(geometry, Box{Vec3::Constant(-2), Vec3::Constant(2)}));
  EXPECT_EQ(near.count(), 0);
  EXPECT_FALSE(near.covers(Box::around(Vec3::Zero(), Vec3::Zero())));
}

TEST(TriangleCache, TimeInsideEndsAtTheRegionsWall) {
  const TriangleMesh mesh = make_icosphere(0.05, 1);
  const TouchGeometry geometry({&mesh});
  TriangleCache near;
  ASSERT_TRUE(near.rebuild(geometry, Box{Vec3::Constant(-0.25), Vec3::Constant(0.25)}));
  EXPECT_DOUBLE_EQ(near.time_inside(Vec3::Zero(), Vec3(0.5, 0, 0), 0.05), 0.4);
  EXPECT_EQ(near.time_inside(Vec3(0.24, 0, 0), Vec3(0.5, 0, 0), 0.05), 0.0);
}

TEST(TriangleCache, ItsEdgesAndCornersAreThoseOfTheIndexLists) {
  constexpr unsigned kSeed = 41;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  const Seen seen = compare_with_index_lists(make_bumpy_sphere(0.05, 0.1, 3000, 3), 0.06, 60, kSeed);
  EXPECT_GT(seen.edges, 5000U);
  EXPECT_GT(seen.corners, 5000U);
  EXPECT_EQ(seen.boundary + seen.non_manifold + seen.flipped, 0U) << "a closed mesh, consistently oriented";
}

TEST(TriangleCache, ABoundaryEdgeHasNoAdjacentTriangle) {
  constexpr unsigned kSeed = 42;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  const Seen seen = compare_with_index_lists(make_plane_grid(0.1, 12), 0.2, 40, kSeed);
  EXPECT_GT(seen.boundary, 20U);
  EXPECT_GT(seen.edges, 10 * seen.boundary);
  // Sheets near each other that share no vertices have a boundary there; nearer than the resolution of touch they would be one.
  const TriangleMesh apart = joined(make_plane_grid(0.1, 6), scaled_and_moved(make_plane_grid(0.1, 6), 1.0, {0.1 + 1e-7, 0.0, 0.0}));
  EXPECT_GT(compare_with_index_lists(apart, 0.2, 40, kSeed).boundary, 20U);
}

TEST(TriangleCache, AnEdgeOfThreeFacesHasNoAdjacentTriangle) {
  constexpr unsigned kSeed = 43;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  TriangleMesh mesh = make_plane_grid(0.1, 8);
  for (std::size_t i = 0; i < 20; ++i) {  // fins
    const Triangle base = mesh.triangles[5 * i];
    mesh.vertices.push_back(0.5 * (mesh.vertices[base[0]] + mesh.vertices[base[1]]) + Vec3(0, 0, 0.01));
    mesh.triangles.push_back({base[i % 2], base[1 - i % 2], static_cast<std::uint32_t>(mesh.vertices.size() - 1)});
  }
  EXPECT_GT(compare_with_index_lists(mesh, 0.2, 40, kSeed).non_manifold, 100U);
}

TEST(TriangleCache, AFlippedNeighbourIsReported) {
  constexpr unsigned kSeed = 44;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  TriangleMesh mesh = make_bumpy_sphere(0.05, 0.1, 1000, 3);
  for (Triangle& t : mesh.triangles) {
    std::rotate(t.begin(), t.begin() + static_cast<int>(random() % 3), t.end());
    if (random() % 2 == 0) std::swap(t[0], t[1]);
  }
  const Seen seen = compare_with_index_lists(mesh, 0.08, 60, kSeed);
  EXPECT_GT(seen.flipped, seen.edges / 4);
  EXPECT_LT(seen.flipped, seen.edges * 3 / 4);
}

// Paths and radii of many sizes, on the surface and off it, beside a triangle so large that its corners are far away.
TEST(TriangleCache, ClearIsSaidOnlyWhereNothingIsNear) {
  constexpr unsigned kSeed = 45;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  TriangleMesh mesh = make_bumpy_sphere(0.05, 0.1, 1000, 5);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {{-0.2, -0.2, 0.01}, {0.2, -0.19, -0.02}, {0.01, 0.2, 0.03}});
  mesh.triangles.push_back({first, first + 1, first + 2});
  const TouchGeometry geometry({&mesh});
  TriangleCache near;
  std::array<std::size_t, 2> clear = {};    // paths over the surface, and tilted paths
  std::array<std::size_t, 2> blocked = {};  // something is nearer than the radius
  std::array<std::size_t, 2> free = {};     // nothing is nearer than twice the radius
  for (int i = 0; i < 6000; ++i) {
    const auto triangle = static_cast<std::uint32_t>(random() % geometry.triangle_count());
    const Vec3 centroid = (geometry.corner(triangle, 0) + geometry.corner(triangle, 1) + geometry.corner(triangle, 2)) / 3.0;
    const Vec3 middle = centroid + 0.01 * Vec3(unit(random), unit(random), unit(random));
    const double half = 0.05;
    if (!near.rebuild(geometry, Box{middle.array() - half, middle.array() + half})) continue;
    const std::uint32_t slot = near.slot_of(triangle);
    ASSERT_NE(slot, TriangleCache::kNoSlot);
    const double radius = std::exp2(-21.0 + 7.0 * (unit(random) + 1.0));
    const bool is_tilted = i % 2 == 1;
    Stroll stroll = stroll_over(near, slot, i % 3 == 0 ? 0.004 : 0x1p-30, random);
    if (is_tilted) {
      for (Vec3& p : stroll.path) p += 0.01 * unit(random) * Vec3(unit(random), unit(random), unit(random));
    }
    Box box;
    for (const Vec3& p : stroll.path) box.grow(p);
    if (!near.covers(box.inflated(radius))) continue;
    double length = 0.0;
    for (std::size_t k = 0; k + 1 < stroll.path.size(); ++k) length += (stroll.path[k + 1] - stroll.path[k]).norm();
    double nearest = std::numeric_limits<double>::infinity();
    for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t) {
      const bool is_excepted = std::any_of(stroll.except.begin(), stroll.except.end(), [&](auto at) { return near.triangle_at(at) == t; });
      if (is_excepted || geometry.separation(t, stroll.path[0]).distance > nearest + length) continue;
      nearest = std::min(nearest, distance_of(stroll.path, geometry, t));
    }
    const bool said = near.is_clear(stroll.path, radius, stroll.except);
    EXPECT_TRUE(!said || nearest >= radius) << "case " << i << ": something is " << nearest << " away, of " << radius;
    clear[is_tilted] += said ? 1 : 0;
    blocked[is_tilted] += nearest < radius ? 1 : 0;
    free[is_tilted] += nearest > 2.0 * radius ? 1 : 0;
  }
  for (const std::size_t kind : {0, 1}) {
    EXPECT_GT(blocked[kind], 100U);
    EXPECT_GT(free[kind], 500U);
    EXPECT_GT(clear[kind], free[kind] / 2) << "in doubt too often to be of use: " << clear[kind] << " of " << free[kind];
  }
}

TEST(TriangleCache, TakesNothingFromTheHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "allocations cannot be counted in this build";
  const TriangleMesh mesh = make_icosphere(0.05, 4);
  const TouchGeometry geometry({&mesh});
  TriangleCache near;
  std::array<TriangleCache::Candidate, TriangleCache::kCapacity> candidates;
  const Vec3 top = geometry.to_local({0, 0, 0.05});
  const AllocationGuard guard;
  ASSERT_TRUE(near.rebuild(geometry, Box{top.array() - 0.05, top.array() + 0.05}));
  near.find_candidates(top, Vec3(0.01, 0, -0.01), 1e-9, Box::around(top, top + Vec3(0.01, 0, -0.01)), candidates);
  const std::array<Vec3, 2> path = {top, top + Vec3(0.01, 0, -0.01)};
  const std::array<std::uint32_t, 1> except = {near.adjacent(near.slot_of(near.triangle_at(0)), 0).slot};
  near.is_clear(path, 1e-9, std::span(except).first(except[0] == TriangleCache::kNoSlot ? 0 : 1));
  near.count_at_vertex(0, 0);
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
