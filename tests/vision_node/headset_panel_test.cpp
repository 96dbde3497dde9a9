#include "vision_node/headset_panel.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include <vtkPropCollection.h>

#include "tests/vision_node/figure_parts.h"

namespace hapton {
namespace {

// The texts that are shown.
std::vector<std::string> panel_texts(vtkRenderer* renderer) {
  std::vector<std::string> texts;
  for (int i = 0; i < renderer->GetViewProps()->GetNumberOfItems(); ++i) {
    auto* text = vtkTextActor3D::SafeDownCast(renderer->GetViewProps()->GetItemAsObject(i));
    if (text != nullptr && text->GetVisibility() != 0) texts.emplace_back(text->GetInput());
  }
  return texts;
}

TEST(HeadsetPanel, TheBarOfTheForceStandsAtTheLeftOfTheWorkspace) {
  HeadsetPanel panel;
  const FigureParts parts(panel);
  vtkActor* bar = parts.solid(0);
  EXPECT_FALSE(parts.is_any_shown());
  panel.set_force(2.0, 8.0);
  ASSERT_NE(bar->GetVisibility(), 0);
  const double* box = bar->GetBounds();
  // The left edge of the bar is 6 px right of that of the panel, and the bar is 104 px high; a pixel is 0.6 mm.
  EXPECT_NEAR(box[0], -0.1854, 1e-9);
  EXPECT_GT(box[2], -0.095) << "within the height of the workspace";
  EXPECT_LT(box[3], 0.095);
  EXPECT_NEAR(box[3] - box[2], 0.0624, 1e-9);
  EXPECT_NEAR(box[4], -0.19, 1e-9) << "at the back of the workspace";
  // The rectangles of the background, the force and the frame lie one in front of the other.
  vtkPolyData* shape = parts.solid_shape(0);
  const auto height = [&](vtkIdType rectangle) { return point_of(shape, 4 * rectangle + 2).y() - point_of(shape, 4 * rectangle).y(); };
  EXPECT_NEAR(height(1), 0.25 * height(0), 1e-6);
  EXPECT_LT(point_of(shape, 0).z(), point_of(shape, 4).z());
  EXPECT_LT(point_of(shape, 4).z(), point_of(shape, 8).z());
  EXPECT_EQ(panel_texts(parts.renderer), std::vector<std::string>{"8 N"});
  panel.set_force(7.9, 8.0);
  EXPECT_GT(height(1), 0.98 * height(0));
  panel.set_force(2.0, 0.0);
  EXPECT_FALSE(parts.is_any_shown()) << "the limit is not known";
  EXPECT_TRUE(panel_texts(parts.renderer).empty());
}

TEST(HeadsetPanel, TheCurvesStandAtTheRight) {
  HeadsetPanel panel;
  const FigureParts parts(panel);
  vtkActor* curves = parts.solid(1);
  const PlotContent force{.title = "force 1.5 N of 5 N", .points = {{0.0, 1.5}, {4.0, 0.5}}, .top = 5.0, .limit = 4.0};
  const PlotContent age{.title = "age 12 ms of 20 ms", .points = {{0.0, 12.0}}, .top = 20.0};
  panel.set_plots({force, age});
  ASSERT_NE(curves->GetVisibility(), 0);
  const double* box = curves->GetBounds();
  EXPECT_GT(box[0], 0.1335) << "beside the workspace";
  EXPECT_LT(box[1], 0.3);
  EXPECT_GT(box[2], -0.095);
  EXPECT_LT(box[3], 0.1) << "below the help";
  EXPECT_EQ(panel_texts(parts.renderer), (std::vector<std::string>{force.title, age.title}));
  panel.set_plots({force});
  EXPECT_EQ(panel_texts(parts.renderer), (std::vector<std::string>{force.title}));
  panel.set_plots({});
  EXPECT_FALSE(parts.is_any_shown());
  EXPECT_TRUE(panel_texts(parts.renderer).empty());
}

}  // namespace
}  // namespace hapton
