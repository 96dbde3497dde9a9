#include "vision_node/xr/mirror_place.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(MirrorPlace, TheWholePictureIsShownInTheMiddleUndistorted) {
  const MirrorPlace wide = place_mirror({1280, 720}, {1000, 1000});
  EXPECT_EQ(wide.size, (PictureSize{720, 720}));
  EXPECT_EQ(wide.x_px, 280);
  EXPECT_EQ(wide.y_px, 0);
  const MirrorPlace tall = place_mirror({500, 1000}, {1600, 1760});
  EXPECT_EQ(tall.size, (PictureSize{500, 550}));
  EXPECT_EQ(tall.x_px, 0);
  EXPECT_EQ(tall.y_px, 225);
  EXPECT_EQ(place_mirror({1, 1}, {2000, 1}).size, (PictureSize{1, 1})) << "never nothing";
}

TEST(MirrorPlace, ThePointerIsWhereTheEyesPixelIsShown) {
  constexpr PictureSize kEye{1600, 1760};
  const MirrorPlace place = place_mirror({1280, 720}, kEye);
  EXPECT_EQ(place.to_eye(place.x_px, place.y_px, kEye), Eigen::Vector2i(1, 1)) << "2.44 pixels of the eye are one of the window";
  EXPECT_EQ(place.to_eye(640, 360, kEye), Eigen::Vector2i(802, 881));
  EXPECT_LT(place.to_eye(place.x_px - 1, 0, kEye).x(), 0);
  EXPECT_GE(place.to_eye(place.x_px + place.size.width_px, 0, kEye).x(), kEye.width_px);
}

}  // namespace
}  // namespace hapton
