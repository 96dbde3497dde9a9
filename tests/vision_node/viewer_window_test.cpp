#include "vision_node/viewer_window.h"

#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "scene/scene_file.h"
#include "tests/support/patience.h"
#include "tests/vision_node/gone_folder.h"
#include "tests/vision_node/made_views.h"

// Include this last: it brings X's macros, which break other headers.
#include "tests/vision_node/window_person.h"

namespace hapton {
namespace {

// The key V shows the next level of the tree. With a tree of one level, or before there is a tree, the level stays 0.
TEST(ViewerWindow, ALevelThatStaysTheSameKeepsItsTeachingView) {
  VisionOptions options;
  options.teach = {TeachView::grid, 0};
  ViewSettings settings = plain_settings(StereoMode::mono, 320, 240);
  settings.offscreen = false;
  Scene scene;
  scene.objects.push_back({"ball", make_marker(Vec3::Zero(), 0.03), {}, {}});
  const auto view = open_or_fail(settings, {{scene.objects[0].mesh, {1, 0, 0}}});
  ASSERT_TRUE(view);
  view->draw();
  SteadyClock clock;
  ViewerWindow window(*view, clock, options);
  TeachBuilder teacher(scene.touch_scene());
  const StopSignal stop;
  window.set_teacher(&teacher);
  window.finish_teaching(stop);
  ASSERT_NE(window.step().compose(0).hud.find("cells occupied"), std::string::npos) << window.step().compose(0).hud;
  Person person;
  ASSERT_TRUE(person.has_window());
  person.press_key(XK_v, ShiftMask);
  person.press_key(XK_q);  // when it arrives, V has arrived too
  ASSERT_TRUE(wait_until([&] { return window.poll_events({}, {}).quit; }));
  window.finish_teaching(stop);
  const std::string hud = window.step().compose(1).hud;
  EXPECT_NE(hud.find("cells occupied"), std::string::npos) << hud;
}

TEST(ViewerWindow, AScreenshotThatFailsUsesNoNumberUp) {
  const auto view = open_or_fail(plain_settings(StereoMode::mono, 320, 240), {{make_marker(Vec3::Zero(), 0.03), {1, 0, 0}}});
  ASSERT_TRUE(view);
  SteadyClock clock;
  const VisionOptions options;
  ViewerWindow window(*view, clock, options);
  const GoneFolder nowhere;
  for (int n = 0; n < 2; ++n) {
    const std::string line = window.take_numbered_screenshot();
    EXPECT_TRUE(line.starts_with("NO SCREENSHOT: cannot write the screenshot hapton_001.png")) << line;
  }
}

}  // namespace
}  // namespace hapton
