#include "core/sculpt/carved_field.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

using testing::HasSubstr;

constexpr double kVoxelM = 0.002;

CarvedField make_clay_ball(double radius_m = 0.03, double voxel_m = kVoxelM) {
  auto field = CarvedField::make(make_icosphere(radius_m, 5), voxel_m);
  EXPECT_TRUE(field.has_value()) << field.error().what;
  return std::move(*field);
}

std::vector<float> values_of(const CarvedField& field) { return {field.values().begin(), field.values().end()}; }

std::vector<Carve> random_carves(std::uint64_t seed, int count) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> place(-0.035, 0.035), length(-0.004, 0.004), radius(0.002, 0.008);
  const auto draw_vector = [&](auto& distribution) { return Vec3(distribution(random), distribution(random), distribution(random)); };
  std::vector<Carve> carves;
  for (int i = 0; i < count; ++i) {
    const Vec3 from = draw_vector(place);
    carves.push_back({from, i % 5 == 0 ? from : Vec3(from + draw_vector(length)), radius(random)});
  }
  return carves;
}

double distance_to_capsule(const Carve& carve, const Vec3& p) {
  const Vec3 along = carve.to_m - carve.from_m;
  const double share = along.isZero(0.0) ? 0.0 : std::clamp((p - carve.from_m).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - carve.from_m - share * along).norm() - carve.radius_m;
}

template <class Visit>
void for_each_node_of(const CarvedField& field, Visit&& visit) {
  for (int z = 0; z < field.nodes()[2]; ++z) {
    for (int y = 0; y < field.nodes()[1]; ++y) {
      for (int x = 0; x < field.nodes()[0]; ++x) visit(x, y, z, field.grid().index(x, y, z));
    }
  }
}

TEST(CarvedField, OfABallIsItsDistance) {
  const CarvedField field = make_clay_ball();
  EXPECT_EQ(field.nodes()[0] % 8, 0);
  EXPECT_EQ(field.values().size(), field.grid().size());
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> place(-0.036, 0.036);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p(place(random), place(random), place(random));
    const double exact_distance = p.norm() - 0.03;
    // The tolerance is for the flat faces of the icosphere and for interpolation. Nodes near the band's end are left out: the values stop
    // there.
    if (std::abs(exact_distance) > field.band_m() - 2.0 * kVoxelM) continue;
    EXPECT_NEAR(field.value(p), exact_distance, 0.05 * kVoxelM) << p.transpose();
    EXPECT_NEAR((field.gradient(p) - p.normalized()).norm(), 0.0, 0.1) << p.transpose();
  }
}

TEST(CarvedField, ValueIsContinuousAtTheEdgeOfTheGridAndBoundsTheDistanceOutside) {
  const CarvedField field = make_clay_ball();
  const Vec3 low = field.origin_m(), high = field.grid().node(field.nodes()[0] - 1, field.nodes()[1] - 1, field.nodes()[2] - 1);
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  for (int i = 0; i < 500; ++i) {
    Vec3 p = low + Vec3(share(random), share(random), share(random)).cwiseProduct(high - low);
    const int axis = i % 3;
    p[axis] = i % 2 == 0 ? low[axis] : high[axis];
    EXPECT_NEAR(field.value(p), field.band_m(), 1e-6 * kVoxelM);
    const Vec3 outside = p + (i % 2 == 0 ? -1.0 : 1.0) * 0.01 * Vec3::Unit(axis);
    EXPECT_NEAR(field.value(outside), field.band_m() + 0.01, 1e-6 * kVoxelM);
    EXPECT_LE(field.value(outside), outside.norm() - 0.03);
    EXPECT_GT(field.gradient(outside)[axis] * outside[axis], 0.0);
  }
  EXPECT_TRUE(std::isnan(field.value(Vec3(std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0))));
}

TEST(CarvedField, CarveIsTheMaximumByBruteForce) {
  CarvedField field = make_clay_ball();
  std::vector<float> expected = values_of(field);
  const double band = field.band_m();
  for (const Carve& carve : random_carves(21, 60)) {
    const std::vector<float> before = values_of(field);
    const CarvedFieldBox box = field.carve(carve);
    CarvedFieldBox changed{{1 << 20, 1 << 20, 1 << 20}, {0, 0, 0}};
    for_each_node_of(field, [&](int x, int y, int z, std::size_t i) {
      const double carved = std::min(band, -distance_to_capsule(rounded(carve), field.grid().node(x, y, z)));
      expected[i] = std::max(expected[i], static_cast<float>(carved));
      ASSERT_NEAR(field.values()[i], expected[i], 1e-6 * band);
      if (field.values()[i] == before[i] || before[i] >= static_cast<float>(2.0 * kVoxelM)) return;
      const std::array<int, 3> node = {x, y, z};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        changed.low[axis] = std::min(changed.low[axis], node[axis]);
        changed.high[axis] = std::max(changed.high[axis], node[axis] + 1);
      }
    });
    EXPECT_EQ(box.is_empty(), changed.is_empty());
    if (box.is_empty()) continue;
    EXPECT_EQ(box.low, changed.low);
    EXPECT_EQ(box.high, changed.high);
  }
}

// A ball with a radius of 31 m, with carves 1024 times as large: the code contains no absolute length.
TEST(CarvedField, LargeBodiesAreCarvedAsSmallOnesAre) {
  constexpr double kScale = 1024.0;
  CarvedField small = make_clay_ball(), large = make_clay_ball(0.03 * kScale, kVoxelM * kScale);
  ASSERT_EQ(large.nodes(), small.nodes());
  const double tolerance = 1e-5 * small.band_m();
  for (const Carve& carve : random_carves(27, 60)) {
    const CarvedFieldBox box = small.carve(carve);
    const CarvedFieldBox large_box = large.carve({kScale * carve.from_m, kScale * carve.to_m, kScale * carve.radius_m});
    EXPECT_EQ(large_box.is_empty(), box.is_empty());
  }
  for (std::size_t i = 0; i < small.values().size(); ++i) ASSERT_NEAR(large.values()[i] / kScale, small.values()[i], tolerance) << i;
}

TEST(CarvedField, WhetherACarveChangesAnythingIsKnownBefore) {
  CarvedField field = make_clay_ball();
  int effective_carves = 0;
  for (const Carve& carve : random_carves(26, 300)) {
    const std::vector<float> before = values_of(field);
    const bool expected = field.would_change(carve);
    ASSERT_EQ(values_of(field), before) << "would_change() changes nothing";
    ASSERT_EQ(!field.carve(carve).is_empty(), expected);
    effective_carves += expected ? 1 : 0;
  }
  EXPECT_GT(effective_carves, 100);
  EXPECT_LT(effective_carves, 290);
}

TEST(CarvedField, OrderAndRepetitionOfCarvesDoNotMatter) {
  std::vector<Carve> carves = random_carves(22, 80);
  CarvedField in_order = make_clay_ball(), shuffled = make_clay_ball();
  for (const Carve& carve : carves) in_order.carve(carve);
  std::shuffle(carves.begin(), carves.end(), std::mt19937_64(23));
  for (const Carve& carve : carves) {
    shuffled.carve(rounded(carve));
    EXPECT_TRUE(shuffled.carve(carve).is_empty());
  }
  EXPECT_EQ(values_of(in_order), values_of(shuffled));
  EXPECT_NE(values_of(in_order), values_of(make_clay_ball()));
}

TEST(CarvedField, ValuesAfterCarvesBoundTheDistanceToWhatIsLeft) {
  CarvedField field = make_clay_ball(0.02);
  const std::vector<Carve> carves = random_carves(24, 25);
  for (const Carve& carve : carves) field.carve(carve);
  std::vector<Vec3> remaining_nodes;
  for_each_node_of(field, [&](int x, int y, int z, std::size_t i) {
    if (field.values()[i] < 0.0F) remaining_nodes.push_back(field.grid().node(x, y, z));
  });
  ASSERT_GT(remaining_nodes.size(), 500U);
  for_each_node_of(field, [&](int x, int y, int z, std::size_t i) {
    if (field.values()[i] <= 0.0F || i % 7 != 0) return;
    const Vec3 p = field.grid().node(x, y, z);
    double nearest = 1.0;
    for (const Vec3& q : remaining_nodes) nearest = std::min(nearest, (p - q).norm());
    ASSERT_LE(field.values()[i], nearest * (1.0 + 1e-6));
  });
}

TEST(CarvedField, CarvesThatAreNoCapsuleChangeNothing) {
  CarvedField field = make_clay_ball();
  const std::vector<float> before = values_of(field);
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const Vec3 origin = Vec3::Zero();
  for (const Carve& carve :
       {Carve{origin, origin, 0.0}, Carve{origin, origin, -0.01}, Carve{origin, origin, nan}, Carve{origin, origin, infinity},
        Carve{origin, Vec3(nan, 0, 0), 0.01}, Carve{Vec3(0, infinity, 0), origin, 0.01}, Carve{Vec3(0, 1e300, 0), origin, 0.01},
        Carve{Vec3(1, 0, 0), Vec3(2, 0, 0), 0.01}, Carve{Vec3(-1e30, 0, 0), Vec3(-1e30, 0, 0), 0.01}}) {
    EXPECT_TRUE(field.carve(carve).is_empty());
  }
  EXPECT_EQ(values_of(field), before);
  EXPECT_FALSE(field.carve({origin, origin, 1.0}).is_empty());
  for (const float value : field.values()) EXPECT_EQ(value, static_cast<float>(field.band_m()));
}

TEST(CarvedField, CarveAndQueriesUseNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP();
  CarvedField field = make_clay_ball();
  const std::vector<Carve> carves = random_carves(25, 20);
  double sum = 0.0;
  const AllocationGuard guard;
  for (const Carve& carve : carves) {
    field.carve(carve);
    sum += field.value(carve.to_m) + field.gradient(carve.to_m).x();
  }
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_TRUE(std::isfinite(sum));
}

// The grid has the cells of the mesh and four on each side, with a multiple of eight nodes along x. The mesh is in the grid's middle.
TEST(CarvedField, TheGridIsAsLargeAsTheMeshAndItsMargins) {
  const TriangleMesh box = scaled_and_moved(make_box(Vec3(0.096, 0.046, 0.016)), 1.0, Vec3(1.0, 2.0, 3.0));
  const auto grid = CarvedField::plan(box, 0.01);
  ASSERT_TRUE(grid) << grid.error().what;
  EXPECT_EQ(grid->nodes, (std::array<int, 3>{24, 14, 11})) << "10, 5 and 2 cells, 8 of margin, and the last node";
  EXPECT_EQ(grid->spacing_m, 0.01);
  const Vec3 middle = 0.5 * (grid->node(0, 0, 0) + grid->node(23, 13, 10));
  EXPECT_LT((middle - Vec3(1.0, 2.0, 3.0)).norm(), 1e-12);
  const auto field = CarvedField::make(box, 0.01);
  ASSERT_TRUE(field);
  EXPECT_DOUBLE_EQ(field->band_m(), 0.03);
}

// A grid of the voxel size that the error advises can be made; one of somewhat smaller voxels cannot.
TEST(CarvedField, TheVoxelsAdvisedArePossible) {
  const TriangleMesh box = make_box(Vec3::Constant(0.1));
  EXPECT_EQ(CarvedField::plan(box, 1.1e-4).error().what,
            "voxels of 0.11 mm would be 777 million, at most 16 are possible: give voxels of 0.41 mm or more");
  EXPECT_TRUE(CarvedField::plan(box, 4.1e-4));
  EXPECT_FALSE(CarvedField::plan(box, 3.9e-4)) << "not much larger than needed";
}

TEST(CarvedField, RejectsWhatHasNoInsideAndTooManyVoxels) {
  EXPECT_THAT(CarvedField::make(make_plane_grid(0.1, 3), 0.001).error().what, HasSubstr("not closed (12 boundary, 0 non-manifold"));
  EXPECT_THAT(CarvedField::make(make_icosphere(0.05, 1), 0.0).error().what, HasSubstr("above 0"));
  EXPECT_THAT(CarvedField::make(make_icosphere(0.05, 1), std::nan("")).error().what, HasSubstr("above 0"));
  EXPECT_THAT(CarvedField::make(make_icosphere(0.05, 1), std::numeric_limits<double>::infinity()).error().what, HasSubstr("above 0"));
  const std::string what = CarvedField::make(make_icosphere(0.05, 1), 1e-4).error().what;
  EXPECT_THAT(what, HasSubstr("at most 16 are possible"));
  EXPECT_THAT(what, HasSubstr("or more"));
  EXPECT_FALSE(CarvedField::make(make_icosphere(0.05, 1), 1e-12).has_value());
}

}  // namespace
}  // namespace hapton
