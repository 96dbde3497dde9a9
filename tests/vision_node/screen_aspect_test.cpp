#include "vision_node/screen_aspect.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(ScreenAspect, PixelsThatAreNotSquareAreReported) {
  const ScreenRectangle screen{Pose::Identity(), 0.32, 0.18};
  EXPECT_EQ(describe_aspect(screen, {1280, 720}), "");
  EXPECT_EQ(describe_aspect(screen, {3840, 2160}), "");
  EXPECT_EQ(describe_aspect(screen, {1280, 700}), "") << "within the errors of touches";
  EXPECT_EQ(describe_aspect(screen, {0, 0}), "") << "not mapped yet";
  EXPECT_EQ(describe_aspect(screen, {1280, 800}),
            "the picture has 1280x800 pixels, and the screen of --screen 320 x 180 mm: make the window fill the area whose corners were "
            "touched, or run hapton screen again; until then things are not seen where they are felt");
  EXPECT_NE(describe_aspect(screen, {1280, 690}), "");
  EXPECT_NE(describe_aspect(screen, {1230, 720}), "");
}

}  // namespace
}  // namespace hapton
