#include "vision_node/hud_figure.h"

#include <gtest/gtest.h>

#include <vtkTextProperty.h>

#include "tests/vision_node/figure_parts.h"

namespace hapton {
namespace {

// Letters of 20 pixels; a hundredth of the height is 9.2, the edge of the scale bar 27.6.
constexpr PictureSize kHudPicture{1100, 920};

struct Hud {
  HudFigure figure;
  FigureParts parts{figure};

  Hud() {
    figure.place(kHudPicture);
    figure.set("facts", "help", "notice");
  }
  void expect_at(std::string_view text, double x, double y, int font) const {
    vtkTextActor* actor = parts.find_text(text);
    ASSERT_NE(actor, nullptr) << text;
    EXPECT_LT((place_of(actor) - Eigen::Vector2d(x, y)).norm(), 1e-6) << text << ": " << place_of(actor).transpose();
    EXPECT_EQ(actor->GetTextProperty()->GetFontSize(), font) << text;
  }
};

TEST(HudFigure, TextsStandInTheCornersAndAboveTheMiddle) {
  Hud hud;
  hud.expect_at("facts", 10.0, 910.0, 20);
  hud.expect_at("help", 10.0, 10.0, 18);
  hud.expect_at("notice", 550.0, 0.79 * 920.0, 23);
  hud.figure.set("facts", "", "");
  EXPECT_EQ(hud.parts.find_text("help"), nullptr);
  EXPECT_EQ(hud.parts.find_text("notice"), nullptr);
  EXPECT_NE(hud.parts.find_text("facts"), nullptr);
}

TEST(HudFigure, LettersHaveALeastAndALargestSize) {
  Hud hud;
  hud.figure.place({200, 100});
  hud.expect_at("facts", 4.0, 96.0, 9);
  hud.expect_at("help", 4.0, 4.0, 9);
  hud.expect_at("notice", 100.0, 79.0, 9);
  hud.figure.place({8000, 4000});
  hud.expect_at("facts", 20.0, 3980.0, 40);
  hud.expect_at("help", 20.0, 20.0, 38);
  hud.expect_at("notice", 4000.0, 3160.0, 64);
}

TEST(HudFigure, ATimeLineLiftsWhatIsAtTheLowerEdge) {
  Hud hud;
  hud.figure.set_time_line(TimeLineShown{}, 0.0, kHudPicture);
  const double lift = place_time_line(kHudPicture).reserve_px;
  hud.expect_at("help", 10.0, 10.0 + lift, 18);
  hud.figure.set_scale_bar({.length_m = 0.1, .pixels = 200.0, .label = "100 mm"}, kHudPicture);
  hud.expect_at("100 mm", 1100.0 - 27.6 - 100.0, 4.0 * 27.6 + lift + 6.9, 18);
  hud.figure.set_plots({{.title = "force", .points = {}}}, kHudPicture);
  EXPECT_NEAR(place_of(hud.parts.find_text("force")).y(), 6.0 * 27.6 + lift + 0.13 * 920.0 + 1.6 * 27.6 + 0.13 * 920.0 + 3.0, 1e-6);
  hud.figure.set_time_line(std::nullopt, 0.0, kHudPicture);
  hud.expect_at("help", 10.0, 10.0, 18);
}

TEST(HudFigure, TheScaleBarIsALineWithTwoEnds) {
  Hud hud;
  hud.figure.set_scale_bar({.length_m = 0.1, .pixels = 200.0, .label = "100 mm"}, kHudPicture);
  const double right = 1100.0 - 27.6;
  const double left = right - 200.0;
  const double y = 4.0 * 27.6;
  hud.expect_at("100 mm", 0.5 * (left + right), y + 6.9, 18);
  const Vec3 corners[6] = {{left, y, 0.0},       {right, y, 0.0},       {left, y - 6.9, 0.0},
                           {left, y + 6.9, 0.0}, {right, y - 6.9, 0.0}, {right, y + 6.9, 0.0}};
  vtkPolyData* shape = hud.parts.flat_shape(0);
  for (vtkIdType i = 0; i < 6; ++i) EXPECT_LT((point_of(shape, i) - corners[i]).norm(), 1e-3) << i;
  EXPECT_EQ(cells_of(shape->GetLines()), (std::vector<std::vector<vtkIdType>>{{0, 1}, {2, 3}, {4, 5}}));
  EXPECT_NE(hud.parts.flat(0)->GetVisibility(), 0);
  hud.figure.set_scale_bar({.length_m = 0.0, .pixels = 0.0, .label = "none"}, kHudPicture);
  EXPECT_EQ(hud.parts.flat(0)->GetVisibility(), 0);
  EXPECT_EQ(hud.parts.find_text("none"), nullptr);
}

// A triangle whose tip points to the probe, and its distance farther inside.
TEST(HudFigure, ThePointerPointsOutOfThePicture) {
  Hud hud;
  const Vec2 at(500.0, 300.0);
  for (const Vec2& towards : {Vec2(0.6, 0.8), Vec2(-1.0, 0.0)}) {
    hud.figure.set_pointer(EdgePointer{at, towards, "12 mm"}, kHudPicture);
    const Vec2 along = 27.6 * towards;
    const Vec2 left(-0.5 * along.y(), 0.5 * along.x());
    vtkPolyData* shape = hud.parts.flat_shape(1);
    EXPECT_LT((point_of(shape, 0).head<2>() - at - along).norm(), 1e-3);
    EXPECT_LT((point_of(shape, 1).head<2>() - at - left).norm(), 1e-3);
    EXPECT_LT((point_of(shape, 2).head<2>() - at + left).norm(), 1e-3);
    hud.expect_at("12 mm", at.x() - 1.5 * along.x() - 2.5 * along.x(), at.y() - 1.5 * along.y(), 18);
    EXPECT_NE(hud.parts.flat(1)->GetVisibility(), 0);
  }
  EXPECT_EQ(cells_of(hud.parts.flat_shape(1)->GetPolys()), (std::vector<std::vector<vtkIdType>>{{0, 1, 2}}));
  hud.figure.set_pointer(std::nullopt, kHudPicture);
  EXPECT_EQ(hud.parts.flat(1)->GetVisibility(), 0);
  EXPECT_EQ(hud.parts.find_text("12 mm"), nullptr);
}

}  // namespace
}  // namespace hapton
