#include "vision_node/label_figure.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include <vtkActor2DCollection.h>
#include <vtkTextProperty.h>

namespace hapton {
namespace {

struct LabelFigureTest : testing::Test {
  LabelFigureTest() {
    figure.add_to(renderer);
    vtkActor2DCollection* actors = renderer->GetActors2D();
    actors->InitTraversal();
    for (vtkActor2D* actor = actors->GetNextActor2D(); actor != nullptr; actor = actors->GetNextActor2D()) {
      texts.push_back(vtkTextActor::SafeDownCast(actor));
    }
  }
  int count_shown() const {
    int shown = 0;
    for (vtkTextActor* text : texts) shown += text->GetVisibility() != 0 ? 1 : 0;
    return shown;
  }
  int font_in(PictureSize size) {
    figure.place({{Vec3::Zero(), "a"}}, screen, Eye::centre, size);
    return texts[0]->GetTextProperty()->GetFontSize();
  }

  vtkNew<vtkRenderer> renderer;
  LabelFigure figure;
  std::vector<vtkTextActor*> texts;
  StereoScreen screen = compute_screen(Framing(), {640, 480});
};

// The font size is width / 48 or height / 50, whichever is less: a label then fits into a small picture and can be read in a large one.
TEST_F(LabelFigureTest, LettersGoWithThePictureWithinBounds) {
  EXPECT_EQ(font_in({960, 1000}), 20);
  EXPECT_EQ(font_in({960, 800}), 16);
  EXPECT_EQ(font_in({528, 1000}), 11);
  EXPECT_EQ(font_in({384, 400}), 9);
  EXPECT_EQ(font_in({4800, 500}), 10);
  EXPECT_EQ(font_in({4800, 4000}), 36);
}

TEST_F(LabelFigureTest, EachIsWhereItsEyeSeesItsPoint) {
  ASSERT_EQ(texts.size(), LabelFigure::kMax);
  EXPECT_EQ(count_shown(), 0);
  const std::vector<WorldLabel> labels = {{Vec3(0.01, 0.02, 0.0), "one"}, {Vec3(-0.03, 0.0, 0.02), "two"}};
  for (const Eye eye : {Eye::left, Eye::right, Eye::centre}) {
    figure.place(labels, screen, eye, {640, 480});
    EXPECT_EQ(count_shown(), 2);
    for (std::size_t i = 0; i < labels.size(); ++i) {
      const Vec2 at = project_to_pixel(screen, eye, {640, 480}, labels[i].p_W);
      EXPECT_EQ(texts[i]->GetInput(), labels[i].text);
      EXPECT_NEAR(texts[i]->GetPosition()[0], at.x(), 1e-9);
      EXPECT_NEAR(texts[i]->GetPosition()[1], at.y(), 1e-9);
    }
  }
  figure.place({{Vec3::Zero(), "three"}}, screen, Eye::centre, {640, 480});
  EXPECT_EQ(count_shown(), 1);
  EXPECT_EQ(std::string(texts[0]->GetInput()), "three");
}

TEST_F(LabelFigureTest, WhatIsBehindTheEyeOrTooMuchIsLeftOut) {
  const Vec3 eye = compute_eye_position(screen, Eye::centre);
  const Vec3 ahead = -screen.X_WV.linear().col(2);
  figure.place({{eye - 0.1 * ahead, "behind"}, {eye + 0.5 * ahead, "ahead"}}, screen, Eye::centre, {640, 480});
  EXPECT_EQ(texts[0]->GetVisibility(), 0);
  EXPECT_EQ(texts[1]->GetVisibility(), 1);
  figure.place(std::vector<WorldLabel>(LabelFigure::kMax + 3, WorldLabel{Vec3::Zero(), "many"}), screen, Eye::centre, {640, 480});
  EXPECT_EQ(count_shown(), static_cast<int>(LabelFigure::kMax));
  figure.place({}, screen, Eye::centre, {640, 480});
  EXPECT_EQ(count_shown(), 0);
}

}  // namespace
}  // namespace hapton
