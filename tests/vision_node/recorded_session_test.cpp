#include "vision_node/recorded_session.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include "scene/object_reader.h"
#include "tests/session/opened_recording.h"
#include "tests/vision_node/made_views.h"
#include "vision_node/vision_session.h"

// Last: it brings X's macros.
#include "tests/vision_node/window_person.h"

namespace hapton {
namespace {

// A window of the recording.
struct RecordedWindow : OpenedRecording {
  explicit RecordedWindow(VisionOptions given) : options(std::move(given)) {
    options.session = file;
    options.view.width_px = 320;
    options.view.height_px = 180;
    for (int i = 0; i < 3; ++i) {
      SceneObject object{"ball", make_marker(Vec3(0.04 * i, 0.0, 0.0), 0.015), {}, {0.8, 0.2, 0.1}};
      object.is_movable = i == 1;
      scene.objects.push_back(std::move(object));
    }
    view = std::move(*open_view(scene, options));
    session = std::make_unique<RecordedSession>(*view, clock, options, index, *rows);
  }

  VisionOptions options;
  SteadyClock clock;
  StopSignal stop;
  Scene scene;
  std::unique_ptr<StereoView> view;
  std::unique_ptr<RecordedSession> session;
};

TEST(RecordedSession, PlaysInTheTimeOfTheRecording) {
  VisionOptions options;
  options.seconds = 0.8;
  options.speed = 2.0;
  options.view.offscreen = true;
  RecordedWindow window(options);
  const std::int64_t begin_ns = window.clock.now_ns();
  ASSERT_TRUE(window.session->run(window.stop));
  const double passed_s = 1e-9 * static_cast<double>(window.clock.now_ns() - begin_ns);
  EXPECT_GT(window.session->player().moment_s(), window.index.begin_s());
  EXPECT_LE(window.session->player().moment_s(), window.index.begin_s() + 2.0 * passed_s);
  EXPECT_GT(window.session->step().frames().drawn(), 1U);
}

TEST(RecordedSession, ShowsTheMomentAskedForWithItsTimeLine) {
  const ScratchFolder scratch;
  VisionOptions options;
  options.at_s = 2.5;
  options.view.offscreen = true;
  options.screenshot = scratch.path() / "a.png";
  RecordedWindow window(options);
  MovedObjects moved(*window.view, window.scene);
  window.session->set_moved_objects(&moved);
  window.session->set_scene(78);
  ASSERT_TRUE(window.session->run(window.stop));
  EXPECT_TRUE(std::filesystem::exists(options.screenshot));
  EXPECT_DOUBLE_EQ(window.session->player().moment_s(), 2.5);
  EXPECT_TRUE(window.session->step().contact());
  EXPECT_NEAR(window.session->step().scene_pose().translation().x(), 0.25, 1e-6);
  // The band of contact is green at the middle of the line, and not at its begin.
  const Picture picture = window.view->read_picture();
  const TimeLinePlace place = place_time_line(picture.size);
  const int y = static_cast<int>(place.bottom_px + 0.5 * place.height_px);
  const auto at = [&](double share) { return picture.at(static_cast<int>(place.left_px + share * place.width_px), y); };
  EXPECT_GT(at(0.55)[1], at(0.55)[0] + 60);
  EXPECT_LT(std::abs(at(0.1)[1] - at(0.1)[0]), 20);
  const std::uint8_t* moment = at(find_time_line_share(window.index, 2.5));
  EXPECT_GT(std::min({moment[0], moment[1], moment[2]}), 200) << "white";
}

// Through the window itself: the keys' names, and where the pointer is.
TEST(RecordedSession, ObeysKeysAndAPressOnTheLine) {
  VisionOptions options;
  options.seconds = 0.5;
  options.view.offscreen = false;
  RecordedWindow window(options);
  window.view->draw();
  Person person;
  ASSERT_TRUE(person.found());
  const PictureSize size = window.view->picture_size();
  for (const KeySym key : {XK_bracketright, XK_bracketright, XK_space}) person.press_key(key);
  const TimeLinePlace place = place_time_line(size);
  const int x = static_cast<int>(place.left_px + 0.5 * place.width_px);
  person.button(ButtonPress, 1, x, size.height_px - 5);
  person.button(ButtonRelease, 1, x, size.height_px - 5);
  person.press_key(XK_period);
  ASSERT_TRUE(window.session->run(window.stop));
  EXPECT_TRUE(window.session->player().is_paused());
  EXPECT_EQ(window.session->player().speed(), 4.0);
  EXPECT_NEAR(window.session->player().moment_s(), 2.0, 0.03);
}

Picture picture_of_view(const char* view) {
  const ScratchFolder scratch;
  VisionOptions options;
  options.at_s = 1.0;  // the scene is where the file has it
  options.view.offscreen = true;
  options.screenshot = scratch.path() / "a.png";
  options.teach = *parse_teach(view);
  RecordedWindow window(options);
  TeachBuilder teacher(window.scene.touch_scene());
  window.session->set_teacher(&teacher);
  EXPECT_TRUE(window.session->run(window.stop));
  return window.view->read_picture();
}

TEST(RecordedSession, TeachingViewsAreInThePictureOfAMoment) {
  const Picture none = picture_of_view("off");
  for (const char* view : {"local-set", "tree:0", "grid", "curvature"}) {
    const Picture shown = picture_of_view(view);
    std::size_t changed = 0;
    for (int y = 60; y < 120; ++y) {  // where neither lines of text nor the time line are
      for (int x = 60; x < 260; ++x) {
        const std::uint8_t* a = none.at(x, y);
        const std::uint8_t* b = shown.at(x, y);
        changed += std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]) > 60 ? 1 : 0;
      }
    }
    EXPECT_GT(changed, 20U) << view;
  }
}

// What a program moves is known a fifth of a second before, and is at its place of the scene time of the sample shown.
TEST(RecordedObjects, WhatProgramsMoveIsWhereItWasInSceneTime) {
  VisionOptions options;
  options.view.offscreen = true;
  RecordedWindow window(options);
  ObjectSpec spec;
  spec.motion.by_program = true;
  SceneObject& lid = window.scene.objects[2];
  lid.commanded = std::make_shared<const CommandedObject>(spec, SceneFit(), *lid.mesh);
  MovedObjects moved(*window.view, window.scene);
  RecordedObjects objects(window.index, moved);
  const Pose at_rest = Pose::Identity();
  objects.show(0.94, 1'500'000'000);
  EXPECT_FALSE(objects.show(0.95, 1'500'000'000)) << "not known yet";
  EXPECT_EQ(moved.moving()[2].matrix(), at_rest.matrix());
  EXPECT_TRUE(objects.show(1.05, 1'450'000'000));
  EXPECT_NEAR(moved.moving()[2].translation().y(), 0.05, 1e-3) << "half way";
  EXPECT_FALSE(objects.show(1.06, 1'450'000'000)) << "scene time stands still";
  EXPECT_TRUE(objects.show(2.5, 2'500'000'000));
  const Vec3 there = moved.moving()[2].translation();
  EXPECT_TRUE(objects.show(0.9, 900'000'000));
  EXPECT_EQ(moved.moving()[2].matrix(), at_rest.matrix()) << "back";
  EXPECT_TRUE(objects.show(3.9, 3'900'000'000));
  EXPECT_EQ(moved.moving()[2].translation(), there);
}

TEST(RecordedObjects, GoesForwardsAndBackwards) {
  VisionOptions options;
  options.view.offscreen = true;
  RecordedWindow window(options);
  MovedObjects moved(*window.view, window.scene);
  RecordedObjects objects(window.index, moved);
  objects.show(0.6, 0);
  EXPECT_EQ(moved.held(), 1);
  EXPECT_TRUE(objects.show(1.0, 0));
  EXPECT_EQ(moved.held(), -1);
  EXPECT_FALSE(objects.show(1.1, 0));
  EXPECT_TRUE(objects.show(0.7, 0));
  EXPECT_EQ(moved.held(), 1);
  EXPECT_TRUE(objects.show(0.1, 0));
  EXPECT_EQ(moved.held(), -1);
}

}  // namespace
}  // namespace hapton
