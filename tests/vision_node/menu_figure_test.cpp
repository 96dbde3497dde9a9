#include "vision_node/menu_figure.h"

#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include <vtkCellData.h>
#include <vtkMatrix4x4.h>
#include <vtkPolyData.h>
#include <vtkVectorText.h>

#include "tests/vision_node/figure_parts.h"

namespace hapton {
namespace {

using Entry = TouchMenu::Entry;
const PartColour kPlainField = {38, 48, 62}, kChosenField = {24, 92, 116}, kLitField = {235, 180, 40};

TouchMenu opened_menu() {
  StereoScreen screen;
  screen.X_WV.linear() = Eigen::AngleAxisd(0.4, Vec3::UnitY()).toRotationMatrix();
  TouchMenu menu;
  menu.open(screen, Vec3::Zero());
  return menu;
}

// The space that the font leaves before the first letter, as a share of the letters' size: the smallest of all labels.
double smallest_bearing() {
  double smallest = 1.0;
  for (const TouchMenu::Entry entry : TouchMenu::kEntries) {
    vtkNew<vtkVectorText> letters;
    letters->SetText(std::string(TouchMenu::label(entry)).c_str());
    letters->Update();
    smallest = std::min(smallest, letters->GetOutput()->GetBounds()[0]);
  }
  return smallest;
}

TEST(MenuFigure, HasAFieldForEachEntryWhereItIsChosen) {
  MenuFigure figure;
  const FigureParts parts(figure);
  EXPECT_FALSE(parts.is_any_shown());
  const TouchMenu menu = opened_menu();
  figure.set(menu, PenMode::off);
  vtkPolyData* fields = parts.solid_shape(0);
  const auto cells = cells_of(fields->GetPolys());
  ASSERT_EQ(cells.size(), TouchMenu::kEntries.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Vec3 middle = place_entry(TouchMenu::kEntries[i]);
    const Vec3 half(0.03, 0.46 * 0.012, 0.0);  // half the width, and half the height of an entry without the gap
    const Vec3 corners[4] = {middle - half, middle + Vec3(half.x(), -half.y(), 0.0), middle + half,
                             middle + Vec3(-half.x(), half.y(), 0.0)};
    for (std::size_t k = 0; k < 4; ++k) EXPECT_LT((point_of(fields, cells[i][k]) - corners[k]).norm(), 1e-7) << i << " " << k;
  }
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
    vtkMatrix4x4* matrix = parts.solid(i)->GetUserMatrix();
    ASSERT_NE(matrix, nullptr);
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 4; ++column) EXPECT_DOUBLE_EQ(matrix->GetElement(row, column), menu.pose().matrix()(row, column));
    }
    EXPECT_NE(parts.solid(i)->GetVisibility(), 0);
  }
  // The letters are slightly in front of the panel, within its edges, and begin at its left.
  double bounds[6];
  parts.solid_shape(1)->GetBounds(bounds);
  EXPECT_NEAR(bounds[0], -0.03 + 0.6 * 0.012 + 0.5 * 0.012 * smallest_bearing(), 1e-7);
  EXPECT_LT(bounds[1], 0.03);
  EXPECT_GT(bounds[2], -0.5 * TouchMenu::kHeightM);
  EXPECT_LT(bounds[3], 0.5 * TouchMenu::kHeightM);
  EXPECT_NEAR(bounds[4], 0.0012, 1e-6);
  EXPECT_NEAR(bounds[5], 0.0012, 1e-6);
  figure.set(TouchMenu(), PenMode::off);
  EXPECT_FALSE(parts.is_any_shown());
}

TEST(MenuFigure, TheModeOfThePenIsMarkedAndTheEntryAtTheTipIsHighlighted) {
  MenuFigure figure;
  const FigureParts parts(figure);
  TouchMenu menu = opened_menu();
  const auto colours = [&](PenMode mode) {
    figure.set(menu, mode);
    std::vector<PartColour> found;
    for (std::size_t i = 0; i < TouchMenu::kEntries.size(); ++i) {
      found.push_back(colour_of(parts.solid_shape(0)->GetCellData()->GetScalars(), static_cast<vtkIdType>(i)));
    }
    return found;
  };
  const std::pair<PenMode, Entry> modes[] = {{PenMode::off, Entry::off}, {PenMode::draw, Entry::draw}, {PenMode::measure, Entry::measure}};
  for (const auto& [mode, entry] : modes) {
    const auto found = colours(mode);
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i], TouchMenu::kEntries[i] == entry ? kChosenField : kPlainField) << i;
    }
  }
  menu.receive(menu.pose() * place_entry(Entry::redo), 0);
  const auto lit = colours(PenMode::draw);
  // kEntries: draw has index 1, redo has index 4.
  EXPECT_EQ(lit[4], kLitField);
  EXPECT_EQ(lit[1], kChosenField);
  menu.receive(menu.pose() * place_entry(Entry::draw), 0);
  EXPECT_EQ(colours(PenMode::draw)[1], kLitField) << "the highlight of the tip takes precedence";
}

}  // namespace
}  // namespace hapton
