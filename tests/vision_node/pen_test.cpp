#include "vision_node/pen.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

constexpr std::uint32_t kDrawButton = 2;
constexpr std::uint32_t kMeasureButton = 4;

PenSettings pen_settings() { return {.draw_buttons = kDrawButton, .measure_buttons = kMeasureButton, .bound_m = 1e-4}; }

struct PenTest : testing::Test {
  // Moves the pen along x, over this many points, with these buttons held.
  void move(std::uint32_t buttons, int points = 10, std::int32_t object = 0) {
    for (int i = 0; i < points; ++i) pen.receive(AnnotationPoint{object, Vec3(x_m += 0.001, 0, 0)}, buttons);
  }
  void lift(std::uint32_t buttons = 0) { pen.receive(std::nullopt, buttons); }
  std::size_t entries() const { return pen.annotations().entries.size(); }
  const Stroke& stroke(std::size_t i) const { return std::get<Stroke>(pen.annotations().entries.at(i)); }
  const Measure& measure(std::size_t i) const { return std::get<Measure>(pen.annotations().entries.at(i)); }

  Pen pen{pen_settings(), {}};
  double x_m = 0.0;
};

TEST_F(PenTest, AStrokeLastsFromThePressToTheRelease) {
  move(0);
  move(kDrawButton);
  EXPECT_EQ(entries(), 0U);
  ASSERT_NE(pen.current(), nullptr);
  move(0);
  ASSERT_EQ(entries(), 1U);
  EXPECT_EQ(pen.current(), nullptr);
  EXPECT_EQ(stroke(0).object, 0);
  EXPECT_DOUBLE_EQ(stroke(0).points_m.front().x(), 0.011);
  EXPECT_DOUBLE_EQ(stroke(0).points_m.back().x(), 0.020);
  EXPECT_EQ(stroke(0).points_m.size(), 2U);
  EXPECT_EQ(pen.take_finished(), 0U);
  EXPECT_EQ(pen.take_finished(), std::nullopt);
}

TEST_F(PenTest, OtherAnnotationsEndWhatCanBeUndone) {
  move(0);
  move(kDrawButton);
  move(0);
  move(0);
  move(kDrawButton, 4);
  ASSERT_TRUE(pen.undo());
  const auto entries_before = pen.entries_revision();
  Annotations replacement = pen.annotations();
  replacement.entries.resize(1);
  pen.replace(replacement);
  EXPECT_NE(pen.entries_revision(), entries_before);
  EXPECT_EQ(entries(), 1U);
  EXPECT_EQ(pen.current(), nullptr);
  EXPECT_FALSE(pen.redo());
  EXPECT_EQ(pen.take_finished(), std::nullopt);
  EXPECT_TRUE(pen.undo());
  EXPECT_EQ(entries(), 0U);
}

TEST_F(PenTest, AStrokeHasAVertexOnBothSidesOfWhereTheFacetChanges) {
  lift();
  for (int i = 1; i <= 30; ++i) pen.receive(AnnotationPoint{0, Vec3(0.001 * i, 0, 0)}, kDrawButton, i <= 12 ? 7 : 3);
  lift();
  ASSERT_EQ(entries(), 1U);
  EXPECT_EQ(stroke(0).points_m, (std::vector<Vec3>{{0.001, 0, 0}, {0.001 * 12, 0, 0}, {0.001 * 13, 0, 0}, {0.001 * 30, 0, 0}}));
}

TEST_F(PenTest, InFreeSpaceNothingIsDrawnAndAnotherObjectIsAnotherStroke) {
  lift();
  lift(kDrawButton);
  EXPECT_EQ(pen.current(), nullptr);
  move(kDrawButton);
  lift(kDrawButton);
  move(kDrawButton, 5, 0);
  move(kDrawButton, 5, 1);
  lift();
  ASSERT_EQ(entries(), 3U);
  EXPECT_EQ(stroke(2).object, 1);
}

TEST_F(PenTest, AButtonHeldSinceTheStartDoesNothing) {
  move(kDrawButton | kMeasureButton);
  EXPECT_EQ(pen.current(), nullptr);
  EXPECT_FALSE(pen.first_end());
  move(0, 1);
  move(kDrawButton);
  EXPECT_NE(pen.current(), nullptr);
}

TEST_F(PenTest, TwoPressesMeasure) {
  move(0);
  const double from = x_m + 0.001;
  move(kMeasureButton, 3);
  ASSERT_TRUE(pen.first_end());
  EXPECT_EQ(entries(), 0U);
  move(0, 20);
  lift();
  lift(kMeasureButton);  // not in contact: nothing is taken
  EXPECT_EQ(entries(), 0U);
  lift();
  move(kMeasureButton, 1, 3);
  ASSERT_EQ(entries(), 1U);
  EXPECT_EQ(measure(0).ends[0].object, 0);
  EXPECT_EQ(measure(0).ends[1].object, 3);
  EXPECT_EQ(measure(0).ends[0].p_O.x(), from);
  EXPECT_EQ(measure(0).ends[1].p_O.x(), x_m);
  EXPECT_FALSE(pen.first_end());
}

TEST_F(PenTest, KeysStandForButtons) {
  move(0);
  pen.toggle_draw_key();
  move(0);
  EXPECT_NE(pen.current(), nullptr);
  pen.toggle_draw_key();
  move(0, 1);
  EXPECT_EQ(entries(), 1U);
  pen.measure();
  move(0, 1);
  EXPECT_TRUE(pen.first_end());
  pen.measure();
  move(0, 1);
  EXPECT_EQ(entries(), 2U);
  pen.measure();
  lift();
  move(0, 1);
  EXPECT_FALSE(pen.first_end()) << "a key in free space takes nothing later";
}

TEST_F(PenTest, TheModeSaysWhatTheDrawButtonDoes) {
  lift();
  pen.set_mode(PenMode::off);
  move(kDrawButton);
  lift();
  EXPECT_EQ(entries(), 0U);
  pen.set_mode(PenMode::measure);
  move(kDrawButton);
  lift();
  move(kDrawButton);
  lift();
  ASSERT_EQ(entries(), 1U);
  EXPECT_TRUE(std::holds_alternative<Measure>(pen.annotations().entries[0]));
}

TEST_F(PenTest, AnotherModeFinishesTheStroke) {
  lift();
  move(kDrawButton);
  pen.set_mode(PenMode::measure);
  EXPECT_EQ(entries(), 1U);
  EXPECT_EQ(pen.current(), nullptr);
}

TEST_F(PenTest, UndoAndRedo) {
  lift();
  EXPECT_FALSE(pen.undo());
  EXPECT_FALSE(pen.redo());
  for (int i = 0; i < 3; ++i) {
    move(kDrawButton);
    lift();
  }
  const double last_stroke_x = stroke(2).points_m.front().x();
  EXPECT_TRUE(pen.undo());
  EXPECT_TRUE(pen.undo());
  EXPECT_EQ(entries(), 1U);
  EXPECT_TRUE(pen.redo());
  EXPECT_TRUE(pen.redo());
  EXPECT_FALSE(pen.redo());
  ASSERT_EQ(entries(), 3U);
  EXPECT_EQ(stroke(2).points_m.front().x(), last_stroke_x);
  EXPECT_TRUE(pen.undo());
  move(kDrawButton);
  lift();
  EXPECT_FALSE(pen.redo()) << "something else was drawn since";
  EXPECT_EQ(entries(), 3U);
}

TEST_F(PenTest, UndoOfWhatIsUnderWay) {
  lift();
  move(kMeasureButton, 1);
  EXPECT_TRUE(pen.undo());
  EXPECT_FALSE(pen.first_end());
  EXPECT_EQ(entries(), 0U);
  move(kDrawButton);
  EXPECT_TRUE(pen.undo());
  EXPECT_EQ(entries(), 0U);
  EXPECT_EQ(pen.current(), nullptr);
  move(kDrawButton);
  EXPECT_EQ(pen.current(), nullptr) << "not before it is pressed again";
  lift();
  move(kDrawButton);
  EXPECT_NE(pen.current(), nullptr);
}

TEST_F(PenTest, WhatAFileHadCanBeUndone) {
  Annotations from_file;
  from_file.entries = {Stroke{0, {Vec3::Zero()}}};
  pen = Pen(pen_settings(), from_file);
  EXPECT_TRUE(pen.undo());
  EXPECT_EQ(entries(), 0U);
  EXPECT_TRUE(pen.redo());
  EXPECT_EQ(entries(), 1U);
}

TEST_F(PenTest, TheNumberOfPointsIsLimited) {
  Annotations from_file;
  from_file.entries = {Stroke{0, std::vector<Vec3>(kMaxAnnotationPoints - 3, Vec3::Zero())}};
  pen = Pen(pen_settings(), from_file);
  lift();
  for (int i = 0; i < 20; ++i) pen.receive(AnnotationPoint{0, Vec3(0.01 * (i % 2), 0.001 * i, 0.0)}, kDrawButton);
  EXPECT_TRUE(pen.take_full_report());
  EXPECT_FALSE(pen.take_full_report()) << "reported once";
  lift();
  EXPECT_LE(count_points(pen.annotations()), kMaxAnnotationPoints);
  EXPECT_EQ(entries(), 2U);
  move(kMeasureButton, 1);
  lift();
  move(kMeasureButton, 1);
  EXPECT_EQ(entries(), 2U);
  EXPECT_TRUE(pen.undo());
  move(0, 1);
  move(kMeasureButton, 1);
  lift();
  move(kMeasureButton, 1);
  EXPECT_EQ(entries(), 2U) << "undo made room";
}

TEST_F(PenTest, RevisionsCountWhatChanges) {
  lift();
  const auto before = pen.revision();
  lift();
  EXPECT_EQ(pen.revision(), before);
  move(kDrawButton, 1);
  EXPECT_GT(pen.revision(), before);
  EXPECT_EQ(pen.entries_revision(), 1U);
  lift();
  EXPECT_EQ(pen.entries_revision(), 2U);
}

TEST_F(PenTest, WantsAPointOnlyWhereOneIsUsed) {
  EXPECT_FALSE(pen.wants_point(0));
  EXPECT_FALSE(pen.wants_point(1));
  EXPECT_TRUE(pen.wants_point(kDrawButton));
  EXPECT_TRUE(pen.wants_point(kMeasureButton));
  pen.measure();
  EXPECT_TRUE(pen.wants_point(0));
}

}  // namespace
}  // namespace hapton
