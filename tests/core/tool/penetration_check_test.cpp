#include "core/tool/penetration_check.h"

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

TEST(PenetrationCheck, ABoxThatTouchesAPlanePenetratesIt) {
  const TriangleMesh plane = make_plane_grid(1.0, 4);
  const TouchGeometry scene(std::vector<const TriangleMesh*>{&plane});
  const ObjectGeometry tool(make_box({0.2, 0.2, 0.2}), {Vec3::Zero(), scene.unit_m()});
  PenetrationCheck check(tool, scene);
  const auto at = [](double z) { return Placement{{0.01, 0.02, z}, turn_by({0.0, 0.0, 0.3})}; };
  EXPECT_FALSE(check.penetrates(at(0.1 + 1e-9)));
  EXPECT_TRUE(check.penetrates(at(0.1 - 1e-9)));
  EXPECT_TRUE(check.penetrates(at(0.1))) << "touching counts as penetration";
  EXPECT_NEAR(check.find_gap(at(0.103), 0.01), 0.003, 1e-12);
  EXPECT_GT(check.find_gap(at(0.2), 0.01), 1.0);
}

}  // namespace
}  // namespace hapton
