#include "vision_node/teach_figure.h"

#include <gtest/gtest.h>

#include <vtkMatrix4x4.h>

#include "tests/vision_node/figure_parts.h"

namespace hapton {
namespace {

PartColour as_part(const TeachColour& colour) { return {colour[0], colour[1], colour[2]}; }

TeachShapes made_shapes() {
  TeachShapes shapes;
  shapes.lines = {{Vec3(1, 2, 3), Vec3(4, 5, 6), {10, 20, 30}}, {Vec3(-1, 0, 1), Vec3(0, -1, 0), {40, 50, 60}}};
  shapes.triangles = {{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, {{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}}}};
  shapes.legend = TeachLegend{250.0, "1/m"};
  return shapes;
}

// The triangles are drawn first, then the lines.
TEST(TeachFigure, DrawsItsLinesAndTrianglesInTheirColours) {
  TeachFigure figure;
  const FigureParts parts(figure);
  EXPECT_FALSE(parts.is_any_shown());
  const TeachShapes shapes = made_shapes();
  figure.set(shapes);
  vtkPolyData* triangles = parts.solid_shape(0);
  ASSERT_EQ(triangles->GetNumberOfPolys(), 1);
  for (vtkIdType k = 0; k < 3; ++k) {
    EXPECT_EQ(point_of(triangles, k), shapes.triangles[0].corner[static_cast<std::size_t>(k)]);
    EXPECT_EQ(colour_of(triangles->GetPointData()->GetScalars(), k), as_part(shapes.triangles[0].colour[static_cast<std::size_t>(k)]));
  }
  vtkPolyData* lines = parts.solid_shape(1);
  const auto cells = cells_of(lines->GetLines());
  ASSERT_EQ(cells.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(point_of(lines, cells[i][0]), shapes.lines[i].from);
    EXPECT_EQ(point_of(lines, cells[i][1]), shapes.lines[i].to);
    EXPECT_EQ(colour_of(lines->GetPointData()->GetScalars(), cells[i][1]), as_part(shapes.lines[i].colour));
  }
  EXPECT_NE(parts.solid(0)->GetVisibility(), 0);
  EXPECT_NE(parts.solid(1)->GetVisibility(), 0);
  TeachShapes without_lines = shapes;
  without_lines.lines.clear();
  figure.set(without_lines);
  EXPECT_EQ(parts.solid(1)->GetVisibility(), 0);
  EXPECT_NE(parts.solid(0)->GetVisibility(), 0);
  figure.hide();
  EXPECT_FALSE(parts.is_any_shown());
}

TEST(TeachFigure, GoesWithTheScene) {
  TeachFigure figure;
  const FigureParts parts(figure);
  Pose X_WS = Pose::Identity();
  X_WS.linear() = Eigen::AngleAxisd(0.5, Vec3::UnitY()).toRotationMatrix();
  X_WS.translation() = Vec3(0.1, 0.2, 0.3);
  figure.set_scene_pose(X_WS);
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
    vtkMatrix4x4* matrix = parts.solid(i)->GetUserMatrix();
    ASSERT_NE(matrix, nullptr);
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 4; ++column) EXPECT_DOUBLE_EQ(matrix->GetElement(row, column), X_WS.matrix()(row, column));
    }
  }
}

// A strip from the lowest to the highest curvature, with three numbers beside it. Positions are shares of the picture's size.
TEST(TeachFigure, TheScaleGoesFromLowThroughZeroToHigh) {
  TeachFigure figure;
  const FigureParts parts(figure);
  figure.set(made_shapes());
  vtkPolyData* scale = parts.flat_shape(0);
  EXPECT_NE(parts.flat(0)->GetVisibility(), 0);
  ASSERT_EQ(scale->GetNumberOfPoints(), 2 * 33);
  const auto cells = cells_of(scale->GetPolys());
  ASSERT_EQ(cells.size(), 32U);
  for (vtkIdType i = 0; i <= 32; ++i) {
    const double share = static_cast<double>(i) / 32.0;
    EXPECT_LT((point_of(scale, 2 * i) - Vec3(0.02, 0.35 + 0.35 * share, 0.0)).norm(), 1e-6) << i;
    EXPECT_LT((point_of(scale, 2 * i + 1) - Vec3(0.035, 0.35 + 0.35 * share, 0.0)).norm(), 1e-6) << i;
    for (const vtkIdType side : {0, 1}) {
      EXPECT_EQ(colour_of(scale->GetPointData()->GetScalars(), 2 * i + side), as_part(curvature_colour(2.0 * share - 1.0, 1.0))) << i;
    }
    if (i == 0) continue;
    EXPECT_EQ(cells[static_cast<std::size_t>(i - 1)], (std::vector<vtkIdType>{2 * i - 2, 2 * i - 1, 2 * i + 1, 2 * i}));
  }
  const std::pair<const char*, double> labels[] = {{"-250 1/m", 0.35}, {"0 1/m", 0.525}, {"250 1/m", 0.7}};
  for (const auto& [text, y] : labels) {
    vtkTextActor* label = parts.find_text(text);
    ASSERT_NE(label, nullptr) << text;
    EXPECT_LT((place_of(label) - Eigen::Vector2d(0.0425, y)).norm(), 1e-9) << text;
  }
}

}  // namespace
}  // namespace hapton
