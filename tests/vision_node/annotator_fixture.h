#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "scene/scene_file.h"
#include "tests/support/scratch_folder.h"
#include "tests/vision_node/made_views.h"
#include "vision_node/annotator.h"

namespace hapton {

inline constexpr double kBallRadius = 0.03;
inline constexpr double kSceneRadius = 0.15;  // of a sphere around both balls
inline constexpr std::uint32_t kPenButton = 2;
inline constexpr std::uint32_t kMeasureButton = 4;
inline constexpr std::uint32_t kMenuButton = 8;

// An annotator of a scene of two balls: the left one at the origin, the right one at x = 0.1 m.
struct AnnotatorTest : testing::Test {
  AnnotatorTest() {
    for (const double x : {0.0, 0.1}) {
      SceneObject object;
      object.name = x > 0.0 ? "right" : "left";
      object.mesh = make_marker({x, 0, 0}, kBallRadius);
      scene.objects.push_back(object);
      shown.push_back({object.mesh, {1, 0, 0}});
    }
    scene.given_hash = 7;
    view = open_or_fail(plain_settings(StereoMode::mono, 320, 240), shown);
    options.file = folder.path() / "notes.toml";
  }
  void open(bool can_touch = true) {
    auto opened = Annotator::open(*view, scene, kSceneRadius, options, can_touch);
    ASSERT_TRUE(opened) << opened.error().what;
    annotator = std::move(*opened);
  }
  // The device point is inside a ball; the drawn probe is outside, a tenth of the ball's radius above its surface.
  void touch(const Vec3& direction, std::uint32_t buttons, std::int32_t object = 0, const Pose& X_WS = Pose::Identity()) {
    ProbeState state;
    const Vec3 centre = object == 1 ? Vec3(0.1, 0, 0) : Vec3(0, 0, 0);
    state.p_WD = X_WS * (centre + 0.9 * kBallRadius * direction.normalized());
    state.visual_offset_m = X_WS.linear() * (0.2 * kBallRadius * direction.normalized());
    state.contact = true;
    state.object = object;
    state.buttons = buttons;
    annotator->receive(state, X_WS);
  }
  // Moves the probe to free space, with these buttons held.
  void lift(std::uint32_t buttons = 0, const Vec3& at = Vec3(0, 0.09, 0)) {
    ProbeState state;
    state.p_WD = at;
    state.buttons = buttons;
    annotator->receive(state, Pose::Identity());
  }
  void draw_arc(std::int32_t object = 0, const Pose& X_WS = Pose::Identity()) {
    lift();
    for (int i = 0; i <= 40; ++i) touch({std::sin(0.02 * i), 0.1, std::cos(0.02 * i)}, kPenButton, object, X_WS);
    lift();
  }
  void press(const UserRequests& requests) { annotator->handle(requests, view->screen(), Vec3::Zero()); }
  const std::vector<Annotation>& entries() const { return annotator->pen().annotations().entries; }

  ScratchFolder folder;
  Scene scene;
  std::vector<ShownObject> shown;
  std::unique_ptr<StereoView> view;
  AnnotatorOptions options;
  std::unique_ptr<Annotator> annotator;
};

}  // namespace hapton
