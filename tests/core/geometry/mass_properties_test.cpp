#include "core/geometry/mass_properties.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

// The inertia per mass of a box a x b x c about its first axis is (b^2 + c^2) / 12. Far from the origin, cancellation would show.
TEST(MassProperties, OfABoxAreInClosedForm) {
  for (const double offset : {0.0, 1e3, 1e6}) {
    const Vec3 low(offset, -offset, 2.0 * offset);
    const auto box = compute_mass_properties(made::box(low, low + Vec3(1, 2, 3)));
    ASSERT_TRUE(box);
    const double error = 1e-14 * (1.0 + offset);
    EXPECT_NEAR(box->volume, 6.0, 60 * error);
    EXPECT_LT((box->centre - low - Vec3(0.5, 1.0, 1.5)).norm(), 10 * error);
    const Vec3 expected = Vec3(4.0 + 9.0, 1.0 + 9.0, 1.0 + 4.0) / 12.0;
    EXPECT_LT((box->inertia_per_mass - Mat3(expected.asDiagonal())).norm(), 60 * error);
  }
}

// The inertia per mass of a ball is 2 r^2 / 5. A mesh of flat triangles inside it has less; the missing part falls with their size squared.
TEST(MassProperties, OfABallAreThoseOfItsLimit) {
  double last_missing = 1.0;
  for (const int bands : {10, 20, 40}) {
    const auto ball = compute_mass_properties(made::sphere(0.3, bands));
    ASSERT_TRUE(ball);
    EXPECT_LT(ball->centre.norm(), 1e-12);
    const double missing = 1.0 - ball->volume / (4.0 / 3.0 * std::numbers::pi * 0.027);
    EXPECT_LT(missing, 0.3 * last_missing);
    last_missing = missing;
    const double inertia = ball->inertia_per_mass.trace() / 3.0;
    EXPECT_NEAR(inertia, 0.4 * 0.09, 1.1 * missing * 0.4 * 0.09);
  }
}

TEST(MassProperties, OfNoSolidThereAreNone) {
  EXPECT_FALSE(compute_mass_properties({}));
  EXPECT_FALSE(compute_mass_properties(made::sheet(1.0, 0.0, 4)));
  TriangleMesh open = made::box({0, 0, 0}, {1, 1, 1});
  open.triangles.pop_back();
  EXPECT_FALSE(compute_mass_properties(open));
  // Both sides of a sheet: its volume consists of rounding errors alone.
  TriangleMesh flat = made::box({0.1, 0.2, 0.3}, {1.3, 1.7, 0.3});
  for (Vec3& v : flat.vertices) v = Quat(0.5, 0.5, 0.5, 0.5) * Quat(0.8, 0.6, 0, 0) * v;
  EXPECT_FALSE(compute_mass_properties(flat));
  EXPECT_TRUE(compute_mass_properties(made::box({0, 0, 0}, {1, 1, 1e-9}))) << "thin, but solid";
  TriangleMesh inside_out = made::box({0, 0, 0}, {1, 1, 1});
  for (Triangle& triangle : inside_out.triangles) std::swap(triangle[0], triangle[1]);
  EXPECT_FALSE(compute_mass_properties(inside_out));
}

// The sum of the volumes is above zero, but the inertia would be that of the large body minus that of the small one, which is far away.
TEST(MassProperties, OfBodiesOfWhichOneIsInsideOutThereAreNone) {
  const TriangleMesh large = made::box({0, 0, 0}, {1, 1, 1});
  const TriangleMesh small = made::box({10, 0, 0}, {10.9, 0.9, 0.9});
  EXPECT_TRUE(compute_mass_properties(joined(large, small)));
  EXPECT_FALSE(compute_mass_properties(joined(large, flipped(small))));
  EXPECT_FALSE(compute_mass_properties(joined(flipped(small), large)));
  const auto hollow = compute_mass_properties(joined(large, flipped(made::box({0.25, 0.25, 0.25}, {0.75, 0.75, 0.75}))));
  ASSERT_TRUE(hollow) << "the triangles of a cavity face into it";
  EXPECT_NEAR(hollow->volume, 0.875, 1e-12);
}

}  // namespace
}  // namespace hapton
