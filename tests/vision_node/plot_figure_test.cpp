#include "vision_node/plot_figure.h"

#include <gtest/gtest.h>

#include "tests/vision_node/figure_parts.h"

namespace hapton {
namespace {

constexpr PictureSize kPlotPicture{2000, 1000};
const PartColour kGridLine = {120, 126, 134}, kLimitLine = {240, 80, 70}, kFirstCurve = {90, 230, 120}, kSecondCurve = {120, 200, 255};

// Four seconds of a force, with a gap of more than a second and a value above the scale; a round trip without values.
std::vector<PlotContent> two_plots() {
  PlotContent force{.title = "force", .points = {{4.0, 2.0}, {3.5, 4.0}, {2.0, 20.0}, {1.0, 8.0}, {0.0, 0.0}}, .top = 10.0, .limit = 8.0};
  return {force, {.title = "round trip", .points = {}, .top = 1.0, .limit = 0.0}};
}

TEST(PlotFigure, CurvesAreDrawnInTheirFramesAtTheRight) {
  PlotFigure figure;
  const FigureParts parts(figure);
  EXPECT_FALSE(parts.is_any_shown());
  for (const double lift : {0.0, 40.0}) {
    figure.set(two_plots(), kPlotPicture, lift);
    // Margins of 30 pixels; frames of 680 x 130 pixels, the first 178 pixels above the second: a frame and 1.6 margins.
    const Vec2 size(680.0, 130.0);
    const Vec2 low[2] = {{1290.0, 180.0 + lift + 178.0}, {1290.0, 180.0 + lift}};
    struct Line {
      PartColour colour;
      int frame;
      std::vector<Vec2> at;
    };
    const std::vector<Vec2> border = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
    const std::vector<Line> expected = {{kGridLine, 0, border},
                                        {kGridLine, 0, {{0, 0.5}, {1, 0.5}}},
                                        {kLimitLine, 0, {{0, 0.8}, {1, 0.8}}},
                                        {kFirstCurve, 0, {{0.2, 0.2}, {0.3, 0.4}}},
                                        {kFirstCurve, 0, {{0.6, 1.0}, {0.8, 0.8}, {1.0, 0.0}}},
                                        {kGridLine, 1, border},
                                        {kGridLine, 1, {{0, 0.5}, {1, 0.5}}}};
    vtkPolyData* shape = parts.flat_shape(0);
    const auto cells = cells_of(shape->GetLines());
    ASSERT_EQ(cells.size(), expected.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const Line& line = expected[i];
      ASSERT_EQ(cells[i].size(), line.at.size()) << i;
      for (std::size_t k = 0; k < line.at.size(); ++k) {
        const Vec2 at = low[line.frame] + size.cwiseProduct(line.at[k]);
        EXPECT_LT((point_of(shape, cells[i][k]).head<2>() - at).norm(), 1e-3) << i << " " << k;
        EXPECT_EQ(colour_of(shape->GetPointData()->GetScalars(), cells[i][k]), line.colour) << i;
      }
    }
    for (std::size_t i = 0; i < 2; ++i) {
      vtkTextActor* title = parts.find_text(two_plots()[i].title);
      ASSERT_NE(title, nullptr);
      EXPECT_LT((place_of(title) - Vec2(low[i].x(), low[i].y() + 130.0 + 3.0)).norm(), 1e-6);
    }
  }
  figure.set({}, kPlotPicture);
  EXPECT_FALSE(parts.is_any_shown());
}

TEST(PlotFigure, ASecondCurveHasItsColourAndAThirdIsLeftOut) {
  PlotFigure figure;
  const FigureParts parts(figure);
  std::vector<PlotContent> plots = two_plots();
  plots[1].points = {{1.0, 0.5}, {0.5, 0.5}};
  plots.push_back(plots[1]);
  figure.set(plots, kPlotPicture);
  vtkPolyData* shape = parts.flat_shape(0);
  const auto cells = cells_of(shape->GetLines());
  ASSERT_EQ(cells.size(), 8U);
  EXPECT_EQ(colour_of(shape->GetPointData()->GetScalars(), cells.back().front()), kSecondCurve);
}

}  // namespace
}  // namespace hapton
