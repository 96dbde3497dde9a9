// Texts of the picture that do not come from the hub.
#include <gtest/gtest.h>

#include "vision_node/vision_step.h"

namespace hapton {
namespace {

TEST(VisionStep, WhatHasJustHappenedIsInTheCornerAtOnce) {
  VisionStep step{VisionStepSettings()};
  (void)step.compose(0);
  step.set_recent_event("exported to /a: b.vtp");
  EXPECT_NE(step.compose(1).hud.find("exported to /a: b.vtp"), std::string::npos);
  step.set_recent_event("");
  EXPECT_EQ(step.compose(2).hud.find("exported"), std::string::npos);
}

TEST(VisionStep, ARecordedPoseTakesThePlaceOfTheDials) {
  VisionStepSettings settings;
  settings.dials.turn(1, 30.0);
  VisionStep step(settings);
  Pose X_WS = Pose::Identity();
  X_WS.translation() = Vec3(0.0, 0.2, 0.0);
  step.set_recording(X_WS, "recording a.hapton", "marker: trial 7");
  step.set_teaching("grid: 1 of 1 cells occupied");
  const VisionStep::Shown shown = step.compose(0);
  EXPECT_EQ(shown.X_WS.matrix(), X_WS.matrix());
  for (const char* part : {"recording a.hapton", "marker: trial 7", "grid: 1 of 1"}) {
    EXPECT_NE(shown.hud.find(part), std::string::npos) << shown.hud;
  }
  EXPECT_NE(shown.help.find("space pause"), std::string::npos);
}

}  // namespace
}  // namespace hapton
