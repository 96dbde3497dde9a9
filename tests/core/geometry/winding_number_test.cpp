#include "core/geometry/winding_number.h"

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

TEST(WindingNumber, IsOneInsideAndZeroOutsideUpToRounding) {
  const TriangleMesh box = make_box(Vec3(1.0, 0.8, 0.6), 3);
  for (const double offset : {0.1, 1e-4, 1e-8, 1e-12, 1e-14}) {
    for (const Vec3& on_wall : {Vec3(0.5, 0.1, 0.07), Vec3(0.5, 0.4, 0.07), Vec3(0.5, 0.4, 0.3)}) {  // a wall, an edge, a corner
      EXPECT_NEAR(compute_winding_number(box, on_wall - Vec3::Constant(offset)), 1.0, 1e-3) << offset;
      EXPECT_NEAR(compute_winding_number(box, on_wall + Vec3::Constant(offset)), 0.0, 1e-3) << offset;
      EXPECT_NEAR(compute_winding_number(box, on_wall + Vec3(offset, -offset, -offset)), 0.0, 1e-3) << offset;
    }
  }
}

TEST(WindingNumber, AddsUpOverBodiesAndChangesSignWithTheFaces) {
  const TriangleMesh ball = make_icosphere(0.5, 2);
  const Vec3 inside(0.1, 0.2, 0.0);
  EXPECT_NEAR(compute_winding_number(joined(ball, scaled_and_moved(ball, 1.0, Vec3(0.2, 0.0, 0.0))), inside), 2.0, 1e-12);
  EXPECT_NEAR(compute_winding_number(flipped(ball), inside), -1.0, 1e-12);
  EXPECT_NEAR(compute_winding_number(ball, Vec3(0.9, 0.2, 0.0)), 0.0, 1e-12);
}

}  // namespace
}  // namespace hapton
