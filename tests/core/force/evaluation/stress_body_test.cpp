#include "core/force/evaluation/stress_body.h"

#include <gtest/gtest.h>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

TEST(StressBody, EveryBodyButAnOpenOneHasAClosedSolidOfPositiveVolumeAndSensibleSize) {
  for (const std::string_view name : stress_body_names()) {
    const StressBody body = make_stress_body(name);
    EXPECT_EQ(body.name, name);
    EXPECT_EQ(body.solid.triangles.empty(), name.starts_with("open-")) << name;
    if (!body.solid.triangles.empty()) {
      EXPECT_TRUE(count_edges(body.solid).closed()) << name;
      EXPECT_GT(compute_volume(body.solid), 0.0) << name;
    }
    EXPECT_GT(compute_bounds(body.touched).extent(), 0.03) << name;
    EXPECT_LT(compute_bounds(body.touched).extent(), 0.2) << name;
    EXPECT_FALSE(body.touched.triangles.empty());
  }
  EXPECT_TRUE(make_stress_body("no such body").touched.triangles.empty());
}

TEST(StressBody, AnOpenMeshHasNoSolid) {
  EXPECT_TRUE(make_stress_body("sheet", make_plane_grid(0.1, 4)).solid.triangles.empty());
  EXPECT_FALSE(make_stress_body("ball", make_icosphere(0.1, 1)).solid.triangles.empty());
}

TEST(StressBody, PlacedScalesAndMovesBothMeshes) {
  const StressBody body = placed(make_stress_body("box"), 10.0, Vec3(5.0, 0.0, 0.0));
  EXPECT_NEAR(compute_bounds(body.touched).extent(), 1.0, 1e-12);
  EXPECT_NEAR(compute_bounds(body.solid).centre().x(), 5.0, 1e-12);
}

}  // namespace
}  // namespace hapton
