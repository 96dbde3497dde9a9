#include "core/tool/stylus_tool.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "core/tool/held_tool.h"
#include "core/tool/held_voxels.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr ToolCoupling kCoupling{.stiffness_n_per_m = 1000.0, .rotational_stiffness_nm_per_rad = 0.2};
constexpr double kStylusVoxelM = 0.0005;

TriangleMesh cube_of_20_mm() { return made::box(Vec3::Constant(-0.01), Vec3::Constant(0.01)); }
std::shared_ptr<const TriangleMesh> floor_at_0() { return made::shared(made::box({-0.05, -0.05, -0.01}, {0.05, 0.05, 0.0})); }

// Whether a proxy or voxels compute the force, the same motion of the hand gives the same force and pose within two voxels.
TEST(StylusTool, ProxyAndVoxelsAreFeltThroughOneInterface) {
  auto proxy = std::make_unique<HeldTool>(ToolStep::make(cube_of_20_mm(), {floor_at_0()}, kCoupling).value());
  HeldTool& proxy_tool = *proxy;
  std::vector<std::unique_ptr<StylusTool>> tools;
  tools.push_back(std::move(proxy));
  tools.push_back(std::make_unique<HeldVoxels>(VoxelTool::make(cube_of_20_mm(), {floor_at_0()}, kCoupling, kStylusVoxelM).value(),
                                               cube_of_20_mm().vertices.front()));
  for (const auto& tool : tools) {
    ToolOutput felt;
    ToolInput input;
    for (int n = 0; n <= 400; ++n) {
      input.X_WD.translation().z() = 0.012 - 0.006 * std::min(1.0, n / 250.0);  // 4 mm deep
      felt = tool->step(input, 1'000'000 * n);
      if (tool.get() == &proxy_tool) proxy_tool.follow();
    }
    EXPECT_TRUE(tool->is_known());
    EXPECT_TRUE(felt.contact);
    EXPECT_NEAR(felt.force_n.z(), 4.0, kCoupling.stiffness_n_per_m * 2.0 * kStylusVoxelM);
    EXPECT_NEAR(felt.X_WP.translation().z(), 0.01, 2.0 * kStylusVoxelM);
    EXPECT_NEAR(tool->vertex_m().norm(), 0.01 * std::sqrt(3.0), 1e-12);
    tool->forget_motion();
    EXPECT_NEAR(tool->step(input, 401'000'000).force_n.z(), felt.force_n.z(), 0.25) << "the next sample goes on from there";
  }
}

}  // namespace
}  // namespace hapton
