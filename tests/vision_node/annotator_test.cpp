#include "vision_node/annotator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "scene/annotations_file.h"
#include "tests/support/file_size_limit.h"
#include "tests/vision_node/annotator_fixture.h"
#include "vision_node/annotation_figure.h"
#include "vision_node/menu_figure.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

TEST_F(AnnotatorTest, AStrokeLiesOnTheSurfaceDrawnThoughTheProbeDoesNot) {
  ASSERT_TRUE(view);
  open();
  Pose X_WS = Pose::Identity();
  X_WS.linear() = Eigen::AngleAxisd(0.8, Vec3(1, 1, 0).normalized()).toRotationMatrix();
  draw_arc(1, X_WS);
  ASSERT_EQ(entries().size(), 1U);
  const Stroke& stroke = std::get<Stroke>(entries()[0]);
  EXPECT_EQ(stroke.object, 1);
  ASSERT_GT(stroke.points_m.size(), 2U);
  for (const Vec3& p : stroke.points_m) {
    // The middle of a facet is below the sphere by up to 1 - cos(7.5 degrees) of the radius.
    EXPECT_LE((p - Vec3(0.1, 0, 0)).norm(), kBallRadius * (1.0 + 1e-12));
    EXPECT_GE((p - Vec3(0.1, 0, 0)).norm(), kBallRadius * 0.98);
  }
  EXPECT_LT((stroke.points_m.front() - Vec3(0.1, 0, 0)).normalized().x(), 0.05) << "in the frame of the object, wherever the dials are";
}

TEST_F(AnnotatorTest, WhatIsDrawnIsSavedAndReadAgain) {
  ASSERT_TRUE(view);
  options.strokes = folder.path() / "lines.vtp";
  open();
  draw_arc();
  touch(Vec3::UnitZ(), kMeasureButton);
  lift();
  touch(Vec3::UnitX(), kMeasureButton);
  lift();
  EXPECT_THAT(annotator->describe(), HasSubstr("1 stroke, 1 measure"));
  EXPECT_THAT(annotator->describe(), HasSubstr("measured 42.43 mm"));
  ASSERT_TRUE(annotator->finish());
  EXPECT_TRUE(std::filesystem::exists(options.strokes));
  const std::vector<Annotation> before = entries();
  open();
  ASSERT_EQ(entries().size(), 2U);
  EXPECT_EQ(std::get<Stroke>(entries()[0]).points_m, std::get<Stroke>(before[0]).points_m);
  EXPECT_EQ(std::get<Measure>(entries()[1]).ends[1].p_O, std::get<Measure>(before[1]).ends[1].p_O);
  std::filesystem::remove(options.file);
  ASSERT_TRUE(annotator->finish());
  EXPECT_FALSE(std::filesystem::exists(options.file)) << "nothing has changed: nothing is written";
}

TEST_F(AnnotatorTest, AStrokeThatIsBeingDrawnAtTheEndIsSaved) {
  ASSERT_TRUE(view);
  open();
  lift();
  touch(Vec3::UnitZ(), kPenButton);
  ASSERT_TRUE(annotator->finish());
  const auto read = read_annotations(options.file, std::vector<std::string>{"left", "right"}, scene.given_hash);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(read->annotations.entries.size(), 1U);
}

TEST_F(AnnotatorTest, AKeySavesAndUndoAfterwardsCountsAsAChange) {
  ASSERT_TRUE(view);
  open();
  draw_arc();
  press({.save = true});
  EXPECT_TRUE(std::filesystem::exists(options.file));
  press({.undo = true});
  EXPECT_TRUE(entries().empty());
  ASSERT_TRUE(annotator->finish());
  EXPECT_TRUE(read_annotations(options.file, std::vector<std::string>{"left"}, scene.given_hash)->annotations.entries.empty());
}

TEST_F(AnnotatorTest, BadFilesAreRejectedBeforeAnything) {
  ASSERT_TRUE(view);
  const auto error = [&] {
    const auto opened = Annotator::open(*view, scene, kSceneRadius, options, true);
    return opened ? std::string("opened") : opened.error().what;
  };
  options.file = folder.write("bad.toml", "schema = 1\n");
  EXPECT_THAT(error(), HasSubstr("bad.toml: line 1"));
  options.file = folder.path() / "notes.obj";
  EXPECT_THAT(error(), HasSubstr(".toml"));
  options.file = folder.path() / "bad.toml" / "notes.toml";
  EXPECT_THAT(error(), HasSubstr("cannot be a folder"));
  options.file.clear();
  options.strokes = folder.path() / "lines.stl";
  EXPECT_THAT(error(), HasSubstr(".vtp"));
  options.strokes.clear();
  options.measure_button = options.draw_button;
  EXPECT_THAT(error(), HasSubstr("--draw-button and --measure-button are both 2"));
  options.draw_button = options.measure_button = options.menu_button = 0;
  EXPECT_EQ(error(), "opened");
}

TEST_F(AnnotatorTest, NothingIsDrawnWhereThereIsNoPointOnTheSceneShown) {
  ASSERT_TRUE(view);
  open(false);  // a rigid tool
  draw_arc();
  EXPECT_TRUE(entries().empty());
  open();
  annotator->set_other_scene(true);
  draw_arc();
  EXPECT_TRUE(entries().empty());
  annotator->set_other_scene(false);
  draw_arc(5);
  draw_arc(-1);
  EXPECT_TRUE(entries().empty());
  ProbeState state;
  state.contact = true;
  state.object = 0;
  state.p_WD = Vec3::Constant(std::nan(""));
  state.buttons = kPenButton;
  annotator->receive(state, Pose::Identity());
  EXPECT_TRUE(entries().empty());
}

TEST_F(AnnotatorTest, StrokesGoWithAnObjectThatIsMovedAndItsPoseIsSaved) {
  ASSERT_TRUE(view);
  open();
  const Vec3 by(0.0, 0.05, 0.0);
  annotator->receive(ObjectPose{.serial = 1, .object = 1});
  EXPECT_EQ(annotator->pen().entries_revision(), 1U) << "where the scene has it: no change";
  annotator->receive(ObjectPose{.serial = 2, .object = 1, .is_held = true});
  draw_arc(0);
  EXPECT_TRUE(entries().empty()) << "what the stylus holds has no tip";
  annotator->receive(ObjectPose{.serial = 3, .object = 1, .p_m = by});
  annotator->receive(ObjectPose{.serial = 3, .object = 9, .p_m = by});
  lift();
  // Touches the object where it lies now.
  ProbeState state;
  state.p_WD = Vec3(0.1, 0, 0) + by + Vec3(0, 0, 0.9 * kBallRadius);
  state.contact = true;
  state.object = 1;
  state.buttons = kPenButton;
  annotator->receive(state, Pose::Identity());
  lift();
  ASSERT_EQ(entries().size(), 1U);
  EXPECT_LT((std::get<Stroke>(entries()[0]).points_m[0] - Vec3(0.1, 0, kBallRadius)).norm(), 0.02 * kBallRadius);
  ASSERT_TRUE(annotator->finish());
  const auto read = read_annotations(options.file, std::vector<std::string>{"left", "right"}, scene.given_hash);
  ASSERT_TRUE(read) << read.error().what;
  ASSERT_EQ(read->annotations.put_down.size(), 1U);
  EXPECT_EQ(read->annotations.put_down[0].object, 1);
  EXPECT_EQ(read->annotations.put_down[0].p_m, by);
}

TEST_F(AnnotatorTest, UndoRequestsThatAnObjectIsPutBackInItsTurn) {
  ASSERT_TRUE(view);
  open();
  const auto pick_up_and_put_down = [&](std::uint32_t serial, const Vec3& p) {
    annotator->receive(ObjectPose{.serial = serial, .object = 1, .is_held = true});
    annotator->receive(ObjectPose{.serial = serial + 1, .object = 1, .p_m = p});
  };
  annotator->receive(ObjectPose{.serial = 1, .object = 1});
  const Vec3 first(0.0, 0.05, 0.0);
  pick_up_and_put_down(2, first);
  pick_up_and_put_down(4, Vec3(0.0, 0.07, 0.0));
  draw_arc(0);
  ASSERT_EQ(entries().size(), 1U);
  press({.undo = true});
  EXPECT_TRUE(entries().empty()) << "the stroke was drawn last";
  EXPECT_FALSE(annotator->take_due(0));
  press({.undo = true});
  const auto request = annotator->take_due(1'000'000'000);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->object, 1);
  EXPECT_EQ(request->serial, 5U);
  EXPECT_FALSE(request->is_held);
  EXPECT_EQ(request->p_m, first);
  EXPECT_FALSE(annotator->take_due(1'050'000'000));
  EXPECT_TRUE(annotator->take_due(1'100'000'000)) << "again, until there is a reply";
  annotator->receive(ObjectPose{.serial = 6, .object = 1, .p_m = first});
  EXPECT_FALSE(annotator->take_due(1'300'000'000));
  press({.undo = true});
  const auto home = annotator->take_due(2'000'000'000);
  ASSERT_TRUE(home);
  EXPECT_EQ(home->p_m, Vec3::Zero());
  EXPECT_TRUE(annotator->take_due(11'900'000'000)) << "two round trips of a slow network";
  EXPECT_FALSE(annotator->take_due(12'000'000'000)) << "nobody replies";
  EXPECT_FALSE(annotator->take_due(12'200'000'000));
  press({.undo = true});
  const auto again = annotator->take_due(13'000'000'000);
  ASSERT_TRUE(again) << "it can be tried again";
  EXPECT_EQ(again->p_m, Vec3::Zero());
  annotator->receive(ObjectPose{.serial = 7, .object = 1});
  press({.undo = true});
  EXPECT_FALSE(annotator->take_due(14'000'000'000)) << "nothing is left";
}

TEST_F(AnnotatorTest, UndosThatComeBeforeTheReplyAreDoneAfterIt) {
  ASSERT_TRUE(view);
  open();
  annotator->receive(ObjectPose{.serial = 1, .object = 1});
  const Vec3 first(0.0, 0.05, 0.0);
  annotator->receive(ObjectPose{.serial = 2, .object = 1, .is_held = true});
  annotator->receive(ObjectPose{.serial = 3, .object = 1, .p_m = first});
  annotator->receive(ObjectPose{.serial = 4, .object = 1, .is_held = true});
  annotator->receive(ObjectPose{.serial = 5, .object = 1, .p_m = 2.0 * first});
  press({.undo = true});
  press({.undo = true});
  const auto request = annotator->take_due(1'000'000'000);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->p_m, first);
  annotator->receive(ObjectPose{.serial = 6, .object = 1, .p_m = first});
  std::optional<ObjectPose> next;
  for (int n = 0; n < 3 && !next; ++n) next = annotator->take_due(1'100'000'000 + n);
  ASSERT_TRUE(next);
  EXPECT_EQ(next->serial, 6U);
  EXPECT_EQ(next->p_m, Vec3::Zero());
}

// The stroke before the move must not be undone in place of the move.
TEST_F(AnnotatorTest, WhileAnObjectIsHeldTheMoveBeforeIsNotUndone) {
  ASSERT_TRUE(view);
  open();
  draw_arc(0);
  annotator->receive(ObjectPose{.serial = 1, .object = 1});
  annotator->receive(ObjectPose{.serial = 2, .object = 1, .is_held = true});
  annotator->receive(ObjectPose{.serial = 3, .object = 1, .p_m = Vec3(0, 0.05, 0)});
  annotator->receive(ObjectPose{.serial = 4, .object = 1, .is_held = true});
  press({.undo = true});
  EXPECT_EQ(annotator->take_notice(), "NOT UNDONE: put down what the stylus holds, and press again");
  EXPECT_EQ(entries().size(), 1U) << "the stroke is older";
  EXPECT_FALSE(annotator->take_due(1'000'000'000));
}

TEST_F(AnnotatorTest, StrokesGoAlongToAnotherSceneByTheNamesOfItsObjects) {
  ASSERT_TRUE(view);
  open();
  draw_arc(1);
  draw_arc(0);
  ASSERT_EQ(entries().size(), 2U);
  Scene recoloured = scene;
  recoloured.objects[0].colour = {0, 1, 0};
  annotator->change_scene(recoloured, nullptr);
  press({.undo = true});
  EXPECT_EQ(entries().size(), 1U) << "the same objects: undone as before";
  press({.redo = true});
  Scene other = scene;
  other.objects.front().name = "new";
  other.objects.push_back(scene.objects.front());
  annotator->change_scene(other, nullptr);
  ASSERT_EQ(entries().size(), 2U);
  EXPECT_EQ(std::get<Stroke>(entries()[0]).object, 1) << "right";
  EXPECT_EQ(std::get<Stroke>(entries()[1]).object, 2) << "left";
  Scene alone = scene;
  alone.objects.resize(1);
  annotator->change_scene(alone, nullptr);
  draw_arc(0);
  annotator->show(Pose::Identity());
  EXPECT_EQ(entries().size(), 3U) << "what was drawn on an object that is gone is kept for the file";
  ASSERT_TRUE(annotator->finish());
  const auto read = read_annotations(options.file, std::vector<std::string>{"left", "right"}, scene.given_hash);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(read->annotations.entries.size(), 3U);
}

TEST_F(AnnotatorTest, TheMenuIsOpenedAndChosenFrom) {
  ASSERT_TRUE(view);
  open();
  draw_arc();
  const auto before = annotator->revision();
  press({.menu = true});
  ASSERT_TRUE(annotator->menu().is_open());
  EXPECT_GT(annotator->revision(), before);
  const auto at = [&](TouchMenu::Entry entry) { return Vec3(annotator->menu().pose() * place_entry(entry)); };
  lift(0, at(TouchMenu::Entry::undo));
  EXPECT_EQ(annotator->menu().lit(), TouchMenu::Entry::undo);
  lift(1, at(TouchMenu::Entry::undo));
  press({});
  EXPECT_TRUE(entries().empty());
  lift(0, at(TouchMenu::Entry::redo));
  press({.draw = true});
  EXPECT_EQ(entries().size(), 1U) << "the key chooses as well";
  EXPECT_FALSE(annotator->pen().is_key_down());
  lift(0, at(TouchMenu::Entry::measure));
  lift(kPenButton, at(TouchMenu::Entry::measure));
  press({});
  EXPECT_EQ(annotator->pen().mode(), PenMode::measure);
  EXPECT_FALSE(annotator->menu().is_open());
  lift(kMenuButton);
  press({});
  EXPECT_TRUE(annotator->menu().is_open()) << "by its button";
  lift();
  lift(kMenuButton);
  press({});
  EXPECT_FALSE(annotator->menu().is_open());
}

TEST_F(AnnotatorTest, TheMenuIsDrawnAndTheEntryAtTheTipIsHighlighted) {
  ASSERT_TRUE(view);
  open();
  press({.menu = true});
  const Vec3 undo = annotator->menu().pose() * place_entry(TouchMenu::Entry::undo);
  // At the right end of the entry, beside its letters.
  const Vec3 beside_letters = undo + annotator->menu().pose().linear() * Vec3(0.45 * TouchMenu::kWidthM, 0, 0);
  const auto colour = [&] {
    annotator->show(Pose::Identity());
    view->draw();
    const Vec2 at = project_to_pixel(view->screen(), Eye::centre, {320, 240}, beside_letters);
    const Picture picture = view->read_picture();
    const std::uint8_t* rgb = picture.at(static_cast<int>(at.x()), static_cast<int>(at.y()));
    return std::array<int, 3>{rgb[0], rgb[1], rgb[2]};
  };
  lift();
  EXPECT_LT(colour()[0], 80);
  EXPECT_GT(colour()[2], 30);
  lift(0, undo);
  EXPECT_GT(colour()[0], 200);
  press({.menu = true});
  EXPECT_EQ(colour(), (std::array<int, 3>{0, 0, 0}));
}

// In the other scene the same number names another object.
TEST_F(AnnotatorTest, WhatWasPutDownInASceneOfOtherObjectsIsNotPutBack) {
  ASSERT_TRUE(view);
  open();
  annotator->receive(ObjectPose{.serial = 1, .object = 1});
  annotator->receive(ObjectPose{.serial = 2, .object = 1, .is_held = true});
  annotator->receive(ObjectPose{.serial = 3, .object = 1, .p_m = Vec3(0, 0.05, 0)});
  Scene other = scene;
  other.objects[1].name = "other";
  annotator->change_scene(other, nullptr);
  press({.undo = true});
  EXPECT_FALSE(annotator->take_due(1'000'000'000));
}

TEST_F(AnnotatorTest, WhatWasNotSavedBeforeTheSceneChangedIsSavedAtTheEnd) {
  ASSERT_TRUE(view);
  open();
  draw_arc(1);
  Scene other = scene;
  other.objects.front().name = "new";
  annotator->change_scene(other, nullptr);
  ASSERT_TRUE(annotator->finish());
  const auto read = read_annotations(options.file, std::vector<std::string>{"left", "right"}, scene.given_hash);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(read->annotations.entries.size(), 1U);
  press({.save = true});
  std::filesystem::remove(options.file);
  annotator->change_scene(scene, nullptr);
  ASSERT_TRUE(annotator->finish());
  EXPECT_FALSE(std::filesystem::exists(options.file)) << "it was saved: another scene is not a change of it";
}

TEST_F(AnnotatorTest, WhatCannotBeSavedByAKeyIsSavedAtTheEnd) {
  ASSERT_TRUE(view);
  open();
  draw_arc();
  {
    const FileSizeLimit full(10);
    press({.save = true});
  }
  EXPECT_THAT(annotator->take_notice(), testing::StartsWith("NOT SAVED: "));
  EXPECT_FALSE(std::filesystem::exists(options.file));
  ASSERT_TRUE(annotator->finish());
  const auto read = read_annotations(options.file, std::vector<std::string>{"left", "right"}, scene.given_hash);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(read->annotations.entries.size(), 1U);
}

}  // namespace
}  // namespace hapton
