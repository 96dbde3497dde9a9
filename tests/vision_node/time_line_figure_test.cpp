#include "vision_node/time_line_figure.h"

#include <gtest/gtest.h>

#include "tests/vision_node/figure_parts.h"

namespace hapton {
namespace {

constexpr PictureSize kLinePicture{1000, 400};

struct LineFigure {
  TimeLineFigure figure;
  FigureParts parts{figure};
  TimeLineShown line{
      .contact = {{0.25, 0.5}, {0.7, 0.7}}, .ticks = {{0.8, true}, {0.4, false}, {0.8, false}}, .begin = "0:00.0", .end = "0:04.0"};
  TimeLinePlace place = place_time_line(kLinePicture);

  double x(double share) const { return place.left_px + share * place.width_px; }
};

// Track, contact, markers and faults are rectangles, drawn in this order, each over the earlier ones.
TEST(TimeLineFigure, HasARectangleForEachThingThatHappened) {
  LineFigure drawn;
  EXPECT_FALSE(drawn.parts.is_any_shown());
  drawn.figure.set(drawn.line, 0.6, kLinePicture);
  const double low = drawn.place.bottom_px;
  const double high = low + drawn.place.height_px;
  const double overhang = 0.35 * drawn.place.height_px;
  struct Box {
    double left, right, bottom, top;
    PartColour colour;
  };
  const Box expected[] = {{drawn.x(0.0), drawn.x(1.0), low, high, {92, 98, 108}},
                          {drawn.x(0.25), drawn.x(0.5), low, high, {90, 230, 120}},
                          {drawn.x(0.7), drawn.x(0.7) + 1.0, low, high, {90, 230, 120}},
                          {drawn.x(0.4) - 1.0, drawn.x(0.4) + 1.0, low - overhang, high + overhang, {120, 200, 255}},
                          {drawn.x(0.8) - 1.0, drawn.x(0.8) + 1.0, low - overhang, high + overhang, {120, 200, 255}},
                          {drawn.x(0.8) - 1.0, drawn.x(0.8) + 1.0, low - overhang, high + overhang, {240, 80, 70}}};
  vtkPolyData* shape = drawn.parts.flat_shape(0);
  const auto cells = cells_of(shape->GetPolys());
  ASSERT_EQ(cells.size(), std::size(expected));
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Box& box = expected[i];
    const Vec3 corners[4] = {
        {box.left, box.bottom, 0.0}, {box.right, box.bottom, 0.0}, {box.right, box.top, 0.0}, {box.left, box.top, 0.0}};
    ASSERT_EQ(cells[i].size(), 4U);
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_LT((point_of(shape, cells[i][k]) - corners[k]).norm(), 1e-4) << i << " " << k;
      EXPECT_EQ(colour_of(shape->GetPointData()->GetScalars(), cells[i][k]), box.colour) << i;
    }
  }
}

TEST(TimeLineFigure, TheMomentIsAPostWithTwoHeads) {
  LineFigure drawn;
  for (const double moment : {0.0, 0.6, 1.0}) {
    drawn.figure.set(drawn.line, moment, kLinePicture);
    vtkPolyData* shape = drawn.parts.flat_shape(1);
    const double x = drawn.x(moment);
    const double overhang = 0.6 * drawn.place.height_px;
    const double low = drawn.place.bottom_px - overhang;
    const double high = drawn.place.bottom_px + drawn.place.height_px + overhang;
    const Vec3 corners[10] = {{x - 1.0, low, 0.0},
                              {x + 1.0, low, 0.0},
                              {x + 1.0, high, 0.0},
                              {x - 1.0, high, 0.0},
                              {x, high - overhang, 0.0},
                              {x + 0.8 * overhang, high, 0.0},
                              {x - 0.8 * overhang, high, 0.0},
                              {x, low + overhang, 0.0},
                              {x - 0.8 * overhang, low, 0.0},
                              {x + 0.8 * overhang, low, 0.0}};
    for (vtkIdType i = 0; i < 10; ++i) EXPECT_LT((point_of(shape, i) - corners[i]).norm(), 1e-4) << moment << " " << i;
    const auto cells = cells_of(shape->GetPolys());
    EXPECT_EQ(cells, (std::vector<std::vector<vtkIdType>>{{0, 1, 2, 3}, {4, 5, 6}, {7, 8, 9}}));
  }
}

TEST(TimeLineFigure, TimesStandAtItsEnds) {
  LineFigure drawn;
  drawn.figure.set(drawn.line, 0.6, kLinePicture);
  const double middle = drawn.place.bottom_px + 0.5 * drawn.place.height_px;
  const double gap = 0.6 * drawn.place.height_px;
  ASSERT_NE(drawn.parts.find_text("0:00.0"), nullptr);
  ASSERT_NE(drawn.parts.find_text("0:04.0"), nullptr);
  EXPECT_LT((place_of(drawn.parts.find_text("0:00.0")) - Eigen::Vector2d(drawn.x(0.0) - gap, middle)).norm(), 1e-6);
  EXPECT_LT((place_of(drawn.parts.find_text("0:04.0")) - Eigen::Vector2d(drawn.x(1.0) + gap, middle)).norm(), 1e-6);
  // A time line with other content or of another size is drawn again.
  drawn.line.end = "9:59.9";
  drawn.line.contact.clear();
  drawn.figure.set(drawn.line, 0.6, kLinePicture);
  EXPECT_NE(drawn.parts.find_text("9:59.9"), nullptr);
  EXPECT_EQ(drawn.parts.flat_shape(0)->GetNumberOfPolys(), 4);
  const PictureSize larger{2000, 800};
  drawn.figure.set(drawn.line, 0.6, larger);
  EXPECT_NEAR(point_of(drawn.parts.flat_shape(0), 1).x(), 0.93 * 2000.0, 1e-3);
  drawn.figure.set(std::nullopt, 0.6, larger);
  EXPECT_FALSE(drawn.parts.is_any_shown());
}

}  // namespace
}  // namespace hapton
