// Slides of a ball of 0.5 mm over meshes of the project. In each of them the ball once stayed at one place until all work was used up.
#include <gtest/gtest.h>

#include <filesystem>
#include <ostream>
#include <string>

#include "core/force/proxy/proxy_method.h"
#include "core/geometry/touch_trajectory.h"
#include "tools/bench/bench_meshes.h"

namespace hapton {
namespace {

struct StalledSlide {
  const char* mesh;
  std::uint64_t seed;
  std::size_t stalled_row;
};

std::ostream& operator<<(std::ostream& out, const StalledSlide& slide) { return out << slide.mesh << " " << slide.seed; }

class BallOnMesh : public ::testing::TestWithParam<StalledSlide> {};

TEST_P(BallOnMesh, IsFollowedWithoutAStall) {
  const StalledSlide& slide = GetParam();
  const auto mesh = make_bench_mesh(slide.mesh, std::filesystem::path(HAPTON_SOURCE_DIR) / "meshes");
  ASSERT_TRUE(mesh) << mesh.error().what;
  const auto trajectory = make_slide_trajectory(*mesh->mesh, {.seed = slide.seed, .rows = slide.stalled_row + 1});
  ASSERT_TRUE(trajectory) << trajectory.error().what;
  TouchScene scene;
  scene.objects.push_back({mesh->mesh, {}});
  const auto made = ProxyMethod::make({.probe_radius_m = 0.0005}, scene);
  ASSERT_TRUE(made) << made.error().what;
  auto& proxy = static_cast<ProxyMethod&>(**made);
  const std::size_t first_row = slide.stalled_row / trajectory->reset_every * trajectory->reset_every;
  proxy.reset(trajectory->p_SD[first_row]);
  // A jump may take the work of a few steps. A stall used up the work of any number of steps.
  constexpr int kMaxSteps = 4;
  for (std::size_t i = first_row; i <= slide.stalled_row; ++i) {
    proxy.step({.p_SD = trajectory->p_SD[i]});
    for (int k = 1; k < kMaxSteps && proxy.carried_from(); ++k) proxy.step({.p_SD = trajectory->p_SD[i]});
    ASSERT_FALSE(proxy.carried_from()) << "row " << i;
  }
  EXPECT_EQ(proxy.counters().swept, 0U);
  EXPECT_GT(proxy.counters().contact_steps, 0U);
}

// The causes: a piece of path that ended behind its start; a contact that was left in a direction that leads into it again; two pieces that
// each overshot a minimum; a multiplier that was wrongly taken for zero.
INSTANTIATE_TEST_SUITE_P(Slides, BallOnMesh,
                         ::testing::Values(StalledSlide{"nefertiti_70k.ply", 2, 4441}, StalledSlide{"nefertiti_70k.ply", 2, 1615},
                                           StalledSlide{"mountain_51k_open.ply", 2, 4880}, StalledSlide{"fish_22k.obj", 2, 6272}),
                         [](const auto& slide) { return "Row" + std::to_string(slide.index); });

}  // namespace
}  // namespace hapton
