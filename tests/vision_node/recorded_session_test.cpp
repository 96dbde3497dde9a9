#include "vision_node/recorded_session.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/session/opened_recording.h"
#include "tests/vision_node/made_views.h"
#include "vision_node/vision_session.h"

namespace hapton {
namespace {

// A window of the recording, off screen.
struct RecordedWindow : OpenedRecording {
  explicit RecordedWindow(VisionOptions given) : options(std::move(given)) {
    options.session = file;
    options.view.width_px = 320;
    options.view.height_px = 180;
    options.view.offscreen = true;
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

TEST(RecordedObjects, GoesForwardsAndBackwards) {
  RecordedWindow window(VisionOptions{});
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
