#include "vision_node/live_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

#include "tests/support/log_of.h"
#include "tests/support/scratch_folder.h"
#include "tests/vision_node/made_views.h"
#include "vision_node/scene_framing.h"

namespace hapton {
namespace {

using testing::HasSubstr;

constexpr const char* kRedObject = "color = [1, 0, 0]\n";
constexpr const char* kGreenObject = "color = [0, 1, 0]\n";

// A sheet that is seen from the front, its file, and the picture of it.
struct LiveSceneTest : testing::Test {
  LiveSceneTest() {
    folder.write("a.obj", "v -0.03 -0.03 0\nv 0.03 -0.03 0\nv 0.03 0.03 0\nv -0.03 0.03 0\nf 1 2 3\nf 1 3 4\n");
    options.loading = {.sealing = CrackSealing::off, .fit = MeshFit::workspace, .appearance = AppearanceReading::on};
    options.view_yaw_deg = options.view_pitch_deg = 0.0;
    options.view = plain_settings(StereoMode::mono, 320, 240);
    write(kRedObject);
    reload.emplace(file, options.loading);
    auto scene = load_scene(file, options.loading);
    EXPECT_TRUE(scene) << scene.error().what;
    describe_scene(*scene, options);
    view = open_or_fail(options.view, list_shown_objects(*scene, false));
    if (view == nullptr) return;
    live.emplace(*view, options, std::move(*scene));
    live->watch(&*reload);
  }
  void write(const std::string& keys) {
    folder.write("a.toml", "[[object]]\nmesh = 'a.obj'\nname = 'sheet'\n" + keys);
    // A file system rounds times: two writes within one step of its clock would look like one.
    std::filesystem::last_write_time(file, std::filesystem::file_time_type::clock::now() + std::chrono::seconds(++writes));
  }
  std::unique_ptr<LiveScene::Change> save(const std::string& keys, std::int64_t now_ns = 0) {
    write(keys);
    reload->poll();
    reload->poll();
    return live->follow(now_ns);
  }
  // The middle of what has this colour channel in the picture; nothing if there is none.
  std::optional<Vec2> find_colour(int channel) {
    view->draw();
    return centroid(view->read_picture(), channel, 0, 320);
  }
  std::uint64_t shown_hash() const { return live->scene().given_hash; }

  ScratchFolder folder;
  std::filesystem::path file = folder.path() / "a.toml";
  int writes = 0;
  VisionOptions options;
  std::optional<SceneReload> reload;
  std::unique_ptr<StereoView> view;
  std::optional<LiveScene> live;
};

TEST_F(LiveSceneTest, AnotherColourIsShownAtOnce) {
  ASSERT_TRUE(view);
  live->set_felt(shown_hash());
  ASSERT_TRUE(find_colour(0));
  EXPECT_FALSE(find_colour(1));
  EXPECT_EQ(live->follow(0), nullptr) << "nothing was saved";
  const auto change = save(kGreenObject);
  ASSERT_NE(change, nullptr);
  EXPECT_FALSE(change->has_new_camera);
  EXPECT_FALSE(find_colour(0));
  EXPECT_TRUE(find_colour(1));
}

TEST_F(LiveSceneTest, AMovedObjectIsShownOnceItIsFelt) {
  ASSERT_TRUE(view);
  live->set_felt(shown_hash());
  const Vec2 before = *find_colour(0);
  const std::string log = log_of([&] {
    EXPECT_EQ(save(std::string(kRedObject) + "position_m = [0.02, 0, 0]\n", 0), nullptr);
    EXPECT_EQ(live->problem(), "");
    EXPECT_EQ(live->follow(SceneFollower::kReportAfterNs), nullptr);
    EXPECT_EQ(live->problem(), "a.toml has changed; the picture waits until haptics_node uses it");
    EXPECT_EQ(live->follow(2 * SceneFollower::kReportAfterNs), nullptr);
  });
  EXPECT_THAT(log, HasSubstr("a.toml has changed, and the picture waits until haptics_node uses it"));
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 1) << log;
  EXPECT_LT((*find_colour(0) - before).norm(), 0.1);
  auto next = load_scene(file, options.loading);
  ASSERT_TRUE(next);
  EXPECT_NE(next->given_hash, shown_hash());
  live->set_felt(next->given_hash);
  ASSERT_NE(live->follow(0), nullptr);
  EXPECT_EQ(live->problem(), "");
  EXPECT_EQ(shown_hash(), next->given_hash);
  view->set_framing(options.view.framing);
  const Vec2 there = project_to_pixel(view->screen(), Eye::centre, {320, 240}, Vec3(0.02, 0, 0));
  EXPECT_LT((*find_colour(0) - there).norm(), 0.6);
}

TEST_F(LiveSceneTest, MoreObjectsACameraAndLightsAreShown) {
  ASSERT_TRUE(view);
  const std::string more_keys = std::string(kRedObject) +
                                "[[object]]\nmesh = 'a.obj'\nname = 'other'\ncolor = [0, 0, 1]\nposition_m = [0.07, 0, 0]\n"
                                "[camera]\nposition_m = [0, 0, 1]\n[[light]]\ndirection = [0, -1, -1]\n";
  const auto change = save(more_keys);
  ASSERT_NE(change, nullptr) << "no haptics node: nothing to wait for";
  EXPECT_TRUE(change->has_new_camera);
  EXPECT_EQ(options.names.size(), 2U);
  EXPECT_EQ(options.view.lights.size(), 1U);
  view->set_framing(options.view.framing);
  EXPECT_TRUE(find_colour(0));
  EXPECT_TRUE(find_colour(2));
  const auto again = save(kRedObject);
  ASSERT_NE(again, nullptr);
  EXPECT_TRUE(again->has_new_camera);
  view->set_framing(options.view.framing);
  EXPECT_FALSE(find_colour(2)) << "it is gone";
}

TEST_F(LiveSceneTest, AnErrorChangesNothing) {
  ASSERT_TRUE(view);
  const std::uint64_t before = shown_hash();
  const std::string log = log_of([&] { EXPECT_EQ(save("colr = 1\n"), nullptr); });
  EXPECT_THAT(log, HasSubstr("the present picture stays"));
  EXPECT_THAT(live->problem(), HasSubstr("unknown key 'colr'"));
  EXPECT_THAT(live->problem(), HasSubstr("; shown as it was before"));
  EXPECT_EQ(shown_hash(), before);
  EXPECT_TRUE(find_colour(0));
  EXPECT_NE(save(kGreenObject), nullptr);
  EXPECT_EQ(live->problem(), "");
  EXPECT_TRUE(find_colour(1));
}

TEST_F(LiveSceneTest, WhatProgramsMoveStaysWhereItIs) {
  ASSERT_TRUE(view);
  ASSERT_NE(save(std::string(kRedObject) + "moved_by = 'program'\n"), nullptr);
  const Vec3 there(0.02, -0.01, 0.0);
  const Vec3 pivot = live->scene().objects[0].commanded->pivot();
  ObjectMove move{.source = 5, .serial = 1, .start_ns = 1, .end_ns = 2, .from_p_m = pivot, .to_p_m = pivot + there};
  ASSERT_TRUE(live->moved().take(move));
  live->moved().set_time(1'000'000'000);
  const auto change = save(std::string(kGreenObject) + "moved_by = 'program'\n");
  ASSERT_NE(change, nullptr);
  EXPECT_LT((live->moved().moving()[0].translation() - there).norm(), 1e-12);
  EXPECT_FALSE(live->moved().take(move)) << "it is known";
  view->set_framing(options.view.framing);
  EXPECT_LT((*find_colour(1) - project_to_pixel(view->screen(), Eye::centre, {320, 240}, there)).norm(), 0.6);
}

}  // namespace
}  // namespace hapton
