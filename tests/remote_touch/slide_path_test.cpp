#include "remote_touch/slide_path.h"

#include <gtest/gtest.h>

#include "remote_touch/remote_methods.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kSamplePeriodS = 1e-3;

RemoteScene scene_of_sphere() { return *make_remote_scene(made::shared(made::sphere(0.05, 40)), {}); }

TEST(SlidePath, ComesSlidesRestsAndLeaves) {
  const RemoteScene scene = scene_of_sphere();
  const SlidePlan plan{.seed = 3, .speed_m_per_s = 0.1, .slide_s = 1.0};
  const auto path = make_slide_path(*scene.mesh, *scene.zero_delay_method, plan);
  ASSERT_TRUE(path) << path.error().what;
  EXPECT_EQ(path->first_resting_row - path->first_sliding_row, 1000U);
  EXPECT_EQ(path->first_leaving_row - path->first_resting_row, 800U) << "SlidePlan::rest_s";
  EXPECT_LT(path->rows.front().depth_m, 0.0) << "above the surface";
  EXPECT_LT(path->rows.back().depth_m, -plan.depth_m);
  double length_m = 0.0;
  for (std::size_t i = path->first_sliding_row; i < path->first_resting_row; ++i) {
    EXPECT_NEAR(path->rows[i].p_SQ.norm(), 0.05, 3e-4) << "on the surface, but for the height of a facet";
    EXPECT_GT(path->rows[i].outward_S.dot(path->rows[i].p_SQ.normalized()), 0.98);
    EXPECT_NEAR(path->rows[i].outward_S.norm(), 1.0, 1e-12);
    EXPECT_EQ(path->rows[i].depth_m, plan.depth_m);
    length_m += (path->rows[i].p_SQ - path->rows[i - 1].p_SQ).norm();
  }
  EXPECT_NEAR(length_m, plan.speed_m_per_s * plan.slide_s, 1e-3);
  for (std::size_t i = 1; i < path->rows.size(); ++i)
    EXPECT_LT((path->rows[i].device_m() - path->rows[i - 1].device_m()).norm(), 5e-4) << "no jump, row " << i;
}

TEST(SlidePath, TheSameSeedGivesTheSamePath) {
  const RemoteScene scene = scene_of_sphere();
  const auto position = [&](std::uint64_t seed) {
    return make_slide_path(*scene.mesh, *scene.zero_delay_method, {.seed = seed})->rows[2000].device_m();
  };
  EXPECT_EQ(position(5), position(5));
  EXPECT_NE(position(5), position(6));
}

TEST(SlidePath, AHandAimsDeeperSoThatTheDeviceReachesItsDepth) {
  const RemoteScene scene = scene_of_sphere();
  const auto path = make_slide_path(*scene.mesh, *scene.zero_delay_method, {.seed = 1, .depth_m = 1e-3});
  ASSERT_TRUE(path);
  const HandPath hand = path->make_hand_path(500.0, 1000.0, kSamplePeriodS);
  const SlideRow& row = path->rows[path->first_sliding_row];
  // At a depth of 1 mm the surface gives 1 N, which stretches the spring of the hand by 2 mm.
  EXPECT_NEAR((hand.position_m(static_cast<std::int64_t>(path->first_sliding_row) * 1'000'000) - (row.p_SQ - 3e-3 * row.outward_S)).norm(),
              0.0, 1e-9);
  EXPECT_NEAR((hand.position_m(0) - path->rows.front().device_m()).norm(), 0.0, 1e-12) << "in free space, where the device is";
}

TEST(SlidePath, AMeshWithoutAnAreaIsAnError) {
  const RemoteScene scene = scene_of_sphere();
  EXPECT_FALSE(make_slide_path(TriangleMesh{}, *scene.zero_delay_method, {}));
}

// Two sheets that face each other, 3 mm apart: above each place of one is the other.
TEST(SlidePath, WithoutRoomAboveTheSurfaceThereIsNoPath) {
  TriangleMesh mesh = made::sheet(0.02, 0.0, 2);
  const auto below = static_cast<std::uint32_t>(mesh.vertices.size());
  const TriangleMesh above = made::sheet(0.02, 0.003, 2);
  mesh.vertices.insert(mesh.vertices.end(), above.vertices.begin(), above.vertices.end());
  for (const Triangle& t : above.triangles) mesh.triangles.push_back({below + t[0], below + t[2], below + t[1]});
  const RemoteScene scene = *make_remote_scene(made::shared(std::move(mesh)), {});
  const auto path = make_slide_path(*scene.mesh, *scene.zero_delay_method, {.seed = 4, .slide_s = 0.01, .rest_s = 0.01});
  ASSERT_FALSE(path);
  EXPECT_EQ(path.error().what, "slide: no path over the surface was found that the hand can follow, in 1000 draws with seed 4");
}

// The path goes back the same way, through the same positions.
TEST(SlidePath, TurnsBackAfterAStroke) {
  const RemoteScene scene = scene_of_sphere();
  const auto path =
      make_slide_path(*scene.mesh, *scene.zero_delay_method, {.seed = 2, .speed_m_per_s = 0.3, .slide_s = 1.2, .stroke_m = 0.06});
  ASSERT_TRUE(path) << path.error().what;
  constexpr std::size_t kStrokeRows = 200;  // 60 mm at 0.3 mm a row
  const std::size_t start = path->first_sliding_row - 1;
  for (std::size_t i = 0; i <= kStrokeRows; ++i) {
    EXPECT_EQ(path->rows[start + i].p_SQ, path->rows[start + 2 * kStrokeRows - i].p_SQ) << i;
    EXPECT_EQ(path->rows[start + i].p_SQ, path->rows[start + 2 * kStrokeRows + i].p_SQ) << i;
  }
  EXPECT_GT((path->rows[start].p_SQ - path->rows[start + kStrokeRows].p_SQ).norm(), 0.03);
}

}  // namespace
}  // namespace hapton
