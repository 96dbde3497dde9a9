// Every structure, Hapton's and the peers', gives what brute force gives.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "bench/measure/own_structures.h"
#include "bench/peers/peer_structures.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

std::vector<QueryStructureKind> all_structures() {
  std::vector<QueryStructureKind> kinds = own_structures();
  for (QueryStructureKind& kind : peer_structures()) kinds.push_back(std::move(kind));
  return kinds;
}

std::vector<std::size_t> indices_of_kinds_with(bool QueryStructureKind::*query) {
  std::vector<std::size_t> indices;
  const std::vector<QueryStructureKind> kinds = all_structures();
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    if (kinds[i].*query) indices.push_back(i);
  }
  return indices;
}

std::string name_of(const testing::TestParamInfo<std::size_t>& info) {
  const QueryStructureKind kind = all_structures()[info.param];
  std::string name = kind.full_name() + " " + kind.precision;
  for (char& c : name) c = c == ' ' ? '_' : c;
  return name;
}

class Structures : public testing::TestWithParam<std::size_t> {
 protected:
  Structures() : kind_(all_structures()[GetParam()]) {
    auto brute = own_structures().front().make(mesh_);
    auto made = kind_.make(mesh_);
    EXPECT_TRUE(brute.has_value());
    EXPECT_TRUE(made.has_value());
    brute_ = std::move(*brute);
    structure_ = std::move(*made);
  }

  // A point on the surface, moved off it by up to `max_offset`.
  Vec3 draw_near(double max_offset) {
    std::uniform_int_distribution<std::size_t> triangle(0, mesh_.triangles.size() - 1);
    std::uniform_real_distribution<double> weight(0.05, 1.0);
    const std::size_t t = triangle(random_);
    Vec3 weights(weight(random_), weight(random_), weight(random_));
    weights /= weights.sum();
    const Vec3 on_surface = weights[0] * mesh_.corner(t, 0) + weights[1] * mesh_.corner(t, 1) + weights[2] * mesh_.corner(t, 2);
    const Vec3 normal = (mesh_.corner(t, 1) - mesh_.corner(t, 0)).cross(mesh_.corner(t, 2) - mesh_.corner(t, 0)).normalized();
    return on_surface + std::uniform_real_distribution<double>(-max_offset, max_offset)(random_) * normal;
  }

  static constexpr double kExtent = 0.1;
  TriangleMesh mesh_ = make_bumpy_sphere(0.5 * kExtent, 0.2, 1000, 3);
  QueryStructureKind kind_;
  std::unique_ptr<QueryStructure> brute_;
  std::unique_ptr<QueryStructure> structure_;
  std::mt19937_64 random_{11};
};

constexpr double kTolerance = 1e-5;  // of float, as a share of the size of the mesh

class SegmentQuery : public Structures {};

TEST_P(SegmentQuery, FindsTheFirstHit) {
  int hits = 0;
  int misses = 0;
  for (int i = 0; i < 400; ++i) {
    const double length = i % 4 == 0 ? 0.8 * kExtent : 0.01 * kExtent;
    const Vec3 from = draw_near(0.01 * kExtent);
    const Vec3 to = from + length * Vec3(Vec3(std::sin(i), std::cos(2.0 * i), std::sin(3.0 * i + 1.0)).normalized());
    const double expected = brute_->first_hit(from, to);
    const double found = structure_->first_hit(from, to);
    (std::isfinite(expected) ? hits : misses) += 1;
    // For a segment that ends, or begins, on the surface rounding decides, so it is left out.
    const bool is_on_end = brute_->nearest(from, 1.0) < kTolerance * kExtent || brute_->nearest(to, 1.0) < kTolerance * kExtent;
    if (is_on_end) continue;
    ASSERT_EQ(std::isfinite(found), std::isfinite(expected)) << kind_.full_name() << ", segment " << i;
    if (std::isfinite(expected)) {
      EXPECT_NEAR(found * length, expected * length, kTolerance * kExtent) << kind_.full_name() << ", segment " << i;
    }
  }
  EXPECT_GT(hits, 50);
  EXPECT_GT(misses, 50);
}

class NearestQuery : public Structures {};

TEST_P(NearestQuery, FindsTheNearestTriangle) {
  int points_beyond = 0;
  for (int i = 0; i < 300; ++i) {
    const double radius = 0.025 * kExtent;
    const Vec3 p = draw_near(0.05 * kExtent);
    const double expected = brute_->nearest(p, 1.0);
    if (std::fabs(expected - radius) < kTolerance * kExtent) continue;
    const double found = structure_->nearest(p, radius);
    if (expected > radius) {
      ++points_beyond;
      EXPECT_FALSE(std::isfinite(found)) << kind_.full_name() << ", point " << i;
    } else {
      EXPECT_NEAR(found, expected, kTolerance * kExtent) << kind_.full_name() << ", point " << i;
    }
  }
  EXPECT_GT(points_beyond, 20);
}

TEST(StructureKinds, HaveNamesOfTheirOwn) {
  const std::vector<QueryStructureKind> kinds = all_structures();
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_FALSE(kinds[i].full_name() == kinds[j].full_name() && kinds[i].precision == kinds[j].precision) << kinds[i].full_name();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, SegmentQuery, testing::ValuesIn(indices_of_kinds_with(&QueryStructureKind::segments)), name_of);
INSTANTIATE_TEST_SUITE_P(All, NearestQuery, testing::ValuesIn(indices_of_kinds_with(&QueryStructureKind::nearests)), name_of);

}  // namespace
}  // namespace hapton
