#include "core/collision/touch_geometry.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

TEST(TouchGeometry, LocalCoordinatesDoNotDependOnScaleOrPlace) {
  const TriangleMesh mesh = make_icosphere(0.05, 2);
  const TouchGeometry here({&mesh});
  for (const double scale : {0x1p-20, 0x1p20}) {
    const TriangleMesh other = scaled_and_moved(mesh, scale, Vec3::Zero());
    const TouchGeometry there({&other});
    EXPECT_EQ(there.unit_m(), here.unit_m() * scale);
    for (std::uint32_t t = 0; t < here.triangle_count(); ++t) {
      for (int k = 0; k < 3; ++k) EXPECT_EQ(there.corner(t, k), here.corner(t, k));
    }
  }
  const TriangleMesh far = scaled_and_moved(mesh, 1.0, Vec3(1e6, -1e6, 1e6));
  const TouchGeometry away({&far});
  EXPECT_LE((away.origin() - Vec3(1e6, -1e6, 1e6)).norm(), 1e-9);
}

TEST(TouchGeometry, EdgesAreExact) {
  const TriangleMesh mesh = make_bumpy_sphere(0.05, 0.1, 2000, 11);
  const TouchGeometry geometry({&mesh});
  for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Vec3& a = geometry.corner(t, k);
      const Vec3& b = geometry.corner(t, (k + 1) % 3);
      const Vec3 edge = b - a;
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_EQ(static_cast<long double>(b[axis]) - static_cast<long double>(a[axis]), static_cast<long double>(edge[axis]));
      }
    }
  }
}

TEST(TouchGeometry, KeepsEveryTriangleAndWhoseItIs) {
  const TriangleMesh ball = make_icosphere(0.05, 2);
  const TriangleMesh box = scaled_and_moved(make_box({0.02, 0.02, 0.02}), 1.0, Vec3(0.2, 0, 0));
  const TouchGeometry geometry(std::vector<const TriangleMesh*>{&ball, &box});
  ASSERT_EQ(geometry.triangle_count(), ball.triangles.size() + box.triangles.size());
  std::size_t of_box = 0;
  geometry.for_each_overlapping(Box{Vec3::Constant(-2), Vec3::Constant(2)}, [&](std::uint32_t id) {
    const bool right = geometry.to_scene(geometry.corner(id, 0)).x() > 0.1;
    EXPECT_EQ(geometry.mesh_of(id), right ? 1U : 0U);
    of_box += right ? 1 : 0;
  });
  EXPECT_EQ(of_box, box.triangles.size());
  EXPECT_GT(geometry.bytes(), geometry.triangle_count() * 20);
}

TEST(TouchGeometry, ThereAndBackAgainIsTheSamePlace) {
  const TriangleMesh mesh = make_icosphere(0.05, 1);
  const TouchGeometry geometry({&mesh});
  const Vec3 p(0.013, -0.4, 0.02);
  EXPECT_LE((geometry.to_scene(geometry.to_local(p)) - p).norm(), 1e-16);
}

TEST(TouchGeometry, BuildsOnApproachAndLetsNoObjectCloseRoundTheProbe) {
  const auto near = std::make_shared<TriangleMesh>(make_icosphere(0.05, 2));
  const auto far = std::make_shared<TriangleMesh>(scaled_and_moved(make_icosphere(0.05, 2), 1.0, Vec3(3, 0, 0)));
  TouchGeometry geometry({near, far}, BuildPolicy::on_approach);
  const auto seen = [&] {
    int count = 0;
    geometry.for_each_overlapping(Box{Vec3::Constant(-9), Vec3::Constant(9)}, [&](std::uint32_t) { ++count; });
    return count;
  };
  EXPECT_EQ(geometry.built_count(), 0U);
  EXPECT_FALSE(geometry.build_wanted()) << "nothing was asked for";
  EXPECT_GT(geometry.look_ahead(geometry.to_local({0, 1.5, 0}), 0.0), 0.0);
  EXPECT_FALSE(geometry.build_wanted());
  EXPECT_EQ(geometry.look_ahead(geometry.to_local({0, 0.1, 0}), 0.0), 0.0);
  EXPECT_EQ(seen(), 0);
  EXPECT_TRUE(geometry.build_wanted());
  EXPECT_FALSE(geometry.build_wanted()) << "the far one was built, too";
  EXPECT_EQ(geometry.look_ahead(geometry.to_local({0, 0, 0}), 0.0), 0.0);
  EXPECT_EQ(seen(), 0) << "it closed round the probe";
  EXPECT_GT(geometry.look_ahead(geometry.to_local({0, 0.1, 0}), 0.0), 0.0);
  EXPECT_EQ(seen(), static_cast<int>(near->triangles.size()));
  EXPECT_EQ(geometry.built_count(), 1U);
}

}  // namespace
}  // namespace hapton
