#include "tools/demo/demo_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "devices/model_a.h"
#include "tools/demo/demo_shapes.h"
#include "tools/demo/demo_step.h"

namespace hapton {
namespace {

Scene scene_of(const std::string& name) {
  auto scene = load_scene(HAPTON_SOURCE_DIR "/scenes/" + name + ".toml");
  EXPECT_TRUE(scene) << scene.error().what;
  return scene ? *scene : Scene();
}

TEST(DemoShapes, AreThoseOfTheMeshes) {
  using namespace demo_groove;
  const TriangleMesh groove = *scene_of("groove").objects.at(0).mesh;
  std::size_t in_groove = 0;
  for (const Vec3& v : groove.vertices) {
    const double distance_from_centre_m = std::abs(v.y() - centre_m(v.x()));
    if (distance_from_centre_m < 1e-9) {
      EXPECT_NEAR(v.z(), kFrontM - kDepthM, 1e-9);
      ++in_groove;
    } else {
      EXPECT_GT(distance_from_centre_m, kHalfWidthM - 1e-9) << "only the bottom line lies between the rims";
    }
  }
  EXPECT_EQ(in_groove, 101U);
  const TriangleMesh wall = *scene_of("thin_wall").objects.at(0).mesh;
  for (const Vec3& v : wall.vertices) {
    EXPECT_NEAR(v.head<2>().cwiseAbs().minCoeff(), demo_wall::kHalfSideM, 1e-12);
    EXPECT_NEAR(std::abs(v.z()), demo_wall::kFrontM, 1e-12);
  }
}

TEST(DemoPath, FindsTheForemostPoint) {
  const auto in_groove = find_front(scene_of("groove"), 0.0, 0.0);
  ASSERT_TRUE(in_groove);
  EXPECT_NEAR(in_groove->z(), demo_groove::kFrontM - demo_groove::kDepthM, 1e-9);
  EXPECT_NEAR(find_front(scene_of("groove"), 0.01, 0.05)->z(), demo_groove::kFrontM, 1e-12);
  EXPECT_FALSE(find_front(scene_of("groove"), 0.5, 0.0));
  EXPECT_FALSE(make_rest_path(scene_of("groove"), 0.5, 0.0, 1.0)) << "nothing is there";
}

// A hand can follow every path: it is within the workspace and no faster than the device allows. It is also read back as it was written.
TEST(DemoPath, OfEveryStepCanBeFollowed) {
  const DeviceLimits limits = model_a::limits();
  for (const DemoStep& step : demo_steps()) {
    // The name of the scene, without "scenes/" and ".toml".
    const auto path = step.make_path(scene_of(step.scene.empty() ? "groove" : std::string(step.scene).substr(7, step.scene.size() - 12)));
    ASSERT_TRUE(path) << step.name;
    const auto read = parse_trajectory_csv(positions_to_csv(*path), "path.csv");
    ASSERT_TRUE(read) << step.name << ": " << read.error().what;
    ASSERT_EQ(read->size(), path->size());
    for (std::size_t i = 0; i < path->size(); ++i) {
      const TrajectoryRow& row = (*path)[i];
      EXPECT_EQ((*read)[i].p_WD, row.p_WD);
      EXPECT_TRUE((row.p_WD - limits.workspace_min_m).minCoeff() > 0.0 && (limits.workspace_max_m - row.p_WD).minCoeff() > 0.0)
          << step.name;
      if (i == 0) continue;
      const TrajectoryRow& before = (*path)[i - 1];
      EXPECT_LT((row.p_WD - before.p_WD).norm() / (row.t_s - before.t_s), limits.max_speed_m_per_s) << step.name << ", row " << i;
    }
  }
}

TEST(DemoPath, AgainstTheWallIsFasterThanItIsThick) {
  const DemoPath path = make_tap_path();
  double fastest = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    if (path[i - 1].p_WD.z() >= 0.0 && path[i].p_WD.z() < 0.0) {
      fastest = std::max(fastest, (path[i - 1].p_WD.z() - path[i].p_WD.z()) / (path[i].t_s - path[i - 1].t_s));
    }
  }
  EXPECT_GT(1e-3 * fastest, 2.0 * demo_wall::kThicknessM) << "of a step of 1 ms";
}

}  // namespace
}  // namespace hapton
