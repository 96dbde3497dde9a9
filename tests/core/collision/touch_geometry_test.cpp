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
  const TouchGeometry geometry({&ball, &box});
  ASSERT_EQ(geometry.triangle_count(), ball.triangles.size() + box.triangles.size());
  std::size_t of_box = 0;
  for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t) {
    const bool right = geometry.to_scene(geometry.corner(t, 0)).x() > 0.1;
    EXPECT_EQ(geometry.mesh_of(t), right ? 1U : 0U);
    of_box += right ? 1 : 0;
  }
  EXPECT_EQ(of_box, box.triangles.size());
  EXPECT_GT(geometry.bytes(), geometry.triangle_count() * 20);
}

TEST(TouchGeometry, ThereAndBackAgainIsTheSamePlace) {
  const TriangleMesh mesh = make_icosphere(0.05, 1);
  const TouchGeometry geometry({&mesh});
  const Vec3 p(0.013, -0.4, 0.02);
  EXPECT_LE((geometry.to_scene(geometry.to_local(p)) - p).norm(), 1e-16);
}

}  // namespace
}  // namespace hapton
