#include "vision_node/hud_figure.h"

#include <gtest/gtest.h>

#include <sstream>

#include <vtkTextProperty.h>

#include "tests/vision_node/figure_parts.h"
#include "vision_node/hud_text.h"
#include "vision_node/text_width.h"

namespace hapton {
namespace {

// In this picture letters have 20 pixels, a hundredth of the height is 9.2 pixels, and the scale bar is 27.6 pixels from the edges.
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

TEST(HudFigure, LettersHaveASmallestAndALargestSize) {
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
  const double lift = place_time_line(kHudPicture).strip_height_px;
  hud.expect_at("help", 10.0, 10.0 + lift, 18);
  hud.figure.set_scale_bar({.length_m = 0.1, .pixels = 200.0, .label = "100 mm"}, kHudPicture);
  hud.expect_at("100 mm", 1100.0 - 27.6 - 100.0, 4.0 * 27.6 + lift + 6.9, 18);
  hud.figure.set_plots({{.title = "force", .points = {}}}, kHudPicture);
  // From below: the margin under the lower plot, that plot, the gap, the upper plot, and the distance of its title.
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

// The pointer is a triangle whose tip points to the probe. The probe's distance is written farther inside the picture.
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

// The leftmost and the rightmost pixel of the lines of all texts shown, and the heights of the texts in the corners.
struct TextExtent {
  double left = 1e9, right = -1e9;
  double facts_px = 0.0, help_px = 0.0;
};
TextExtent measure_texts(const Hud& hud, PictureSize size) {
  TextExtent extent;
  for (std::size_t i = 0; i < hud.parts.texts(); ++i) {
    vtkTextActor* text = hud.parts.text(i);
    if (text->GetVisibility() == 0) continue;
    vtkTextProperty* style = text->GetTextProperty();
    std::istringstream lines(text->GetInput());
    int count = 0;
    for (std::string line; std::getline(lines, line); ++count) {
      const double width = measure_text_width_px(style, line);
      const int justification = style->GetJustification();
      const double share = justification == VTK_TEXT_LEFT ? 0.0 : justification == VTK_TEXT_RIGHT ? 1.0 : 0.5;
      const double left = place_of(text).x() - share * width;
      extent.left = std::min(extent.left, left);
      extent.right = std::max(extent.right, left + width);
    }
    const double height = 1.15 * style->GetFontSize() * count;
    if (i == 0) extent.facts_px = height;
    if (i == 1) extent.help_px = height;
  }
  EXPECT_LT(extent.facts_px + extent.help_px, size.height_px) << "the corners";
  return extent;
}

// Two eyes side by side in a window of 640 x 480 have the narrowest usual pictures.
TEST(HudFigure, AllTextsFitIntoNarrowPicturesToo) {
  HudFacts facts;
  facts.is_connected = true;
  facts.state.contact = true;
  facts.state.energy_percent = 20;
  facts.touched_name = "the upper half of the housing (sheet metal)";
  facts.is_hand_led = true;
  facts.is_other_scene = true;
  const std::string plot = make_plot({{0.1, 1.234}}, "force", "N", 8.5, 1.0).title;
  for (const PictureSize size : {PictureSize{320, 480}, PictureSize{640, 240}, PictureSize{640, 480}, PictureSize{1280, 720}}) {
    SCOPED_TRACE(size.width_px);
    Hud hud;
    hud.figure.place(size);
    hud.figure.set(compose_hud(facts), keys_help(), compose_notice(facts));
    hud.figure.set_plots({{.title = plot, .points = {}}, {.title = plot, .points = {}}}, size);
    hud.figure.set_force(2.0, 8.5, size);
    const TextExtent extent = measure_texts(hud, size);
    EXPECT_GE(extent.left, 0.0);
    EXPECT_LE(extent.right, size.width_px);
    if (size.width_px < 640) {
      EXPECT_GT(hud.parts.flat_shape(2)->GetBounds()[2], extent.help_px) << "the plots are above the help";
    }
  }
}

TEST(HudFigure, LinesAreBrokenAnewWhereThePictureIsResized) {
  Hud hud;
  const std::string help(keys_help());
  hud.figure.set("", help, "");
  EXPECT_NE(hud.parts.find_text(help), nullptr) << "wide enough";
  hud.figure.place({320, 480});
  EXPECT_EQ(hud.parts.find_text(help), nullptr);
  hud.figure.place(kHudPicture);
  EXPECT_NE(hud.parts.find_text(help), nullptr);
}

TEST(HudFigure, TheForceBarIsFilledUpToTheShareOfTheLimit) {
  Hud hud;
  constexpr std::size_t kBar = 5;  // index of the bar: after the scale bar, the pointer, the plots and the two shapes of the time line
  vtkActor2D* actor = hud.parts.flat(kBar);
  EXPECT_EQ(actor->GetVisibility(), 0);
  hud.figure.set_force(1.0, 4.0, kHudPicture);
  ASSERT_NE(actor->GetVisibility(), 0);
  vtkPolyData* shape = hud.parts.flat_shape(kBar);
  EXPECT_NE(hud.parts.find_text("4 N"), nullptr);
  const auto height = [&](vtkIdType first) { return point_of(shape, first + 2).y() - point_of(shape, first).y(); };
  const auto colour = [&] { return colour_of(shape->GetPointData()->GetScalars(), 4); };
  const double whole = height(0);
  EXPECT_NEAR(whole, 0.26 * kHudPicture.height_px, 1e-3);
  EXPECT_NEAR(height(4), 0.25 * whole, 1e-3);
  EXPECT_EQ(colour(), (PartColour{90, 230, 120}));
  EXPECT_NEAR(height(8), whole, 1e-3) << "the frame";
  hud.figure.set_force(3.9, 4.0, kHudPicture);
  EXPECT_NEAR(height(4), 0.975 * whole, 1e-3);
  EXPECT_EQ(colour(), (PartColour{240, 80, 70})) << "the limit cuts from here on";
  hud.figure.set_force(40.0, 4.0, kHudPicture);
  EXPECT_NEAR(height(4), whole, 1e-3);
  hud.figure.set_force(1.0, 0.0, kHudPicture);
  EXPECT_EQ(actor->GetVisibility(), 0) << "no limit is known";
  EXPECT_EQ(hud.parts.find_text("4 N"), nullptr);
}

}  // namespace
}  // namespace hapton
