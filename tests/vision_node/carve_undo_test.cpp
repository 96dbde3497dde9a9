// Carves together with strokes and measures: undo, which begins with the newest of them, and the file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <vector>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "scene/annotations_file.h"
#include "scene/mesh_file.h"
#include "tests/support/file_size_limit.h"
#include "tests/support/patience.h"
#include "tests/support/scratch_folder.h"
#include "tests/vision_node/made_views.h"
#include "vision_node/annotator.h"

namespace hapton {
namespace {

constexpr double kUndoClayRadius = 0.03;
constexpr std::int64_t kTenthOfSecondNs = 100'000'000;

struct CarveUndoTest : testing::Test {
  CarveUndoTest() {
    SceneObject clay;
    clay.name = "clay";
    clay.mesh = std::make_shared<const TriangleMesh>(make_icosphere(kUndoClayRadius, 4));
    clay.sculpt = SculptSettings{.voxel_m = 0.002, .tool_radius_m = 0.008};
    scene.objects = {clay};
    scene.given_hash = 7;
    view = open_or_fail(plain_settings(StereoMode::mono, 320, 240), {{clay.mesh, {1, 0, 0}}});
    options.file = folder.path() / "notes.toml";
  }
  void open() {
    annotator.reset();
    carved = std::make_unique<CarvedObjects>(*view, scene);
    auto opened = Annotator::open(*view, scene, 0.05, options, true);
    ASSERT_TRUE(opened) << opened.error().what;
    annotator = std::move(*opened);
    annotator->set_carved_objects(carved.get());
  }
  static Carves::One one_carve(std::uint32_t serial) {
    return {
        .object = 0, .from_m = {0.03F, 0.001F * static_cast<float>(serial), 0}, .to_m = {0.03F, 0, 0}, .radius_m = 0.008F, .begins = true};
  }
  void carve(std::uint32_t source = 3) {
    Carves carves{.source = source, .newest = ++serial, .first = serial, .count = 1};
    carves.carves[0] = one_carve(serial);
    carved->take(carves, Arrival::newest);
  }
  void reply(const CarveUndo& request) {
    Carves carves{.source = 3, .newest = ++serial, .first = serial, .count = 1};
    carves.carves[0] = {.object = -1, .undone_first = request.serial, .undone_last = request.serial};
    carved->take(carves, Arrival::newest);
  }
  void draw() {
    ProbeState state;
    state.p_WD = Vec3(0, 0, kUndoClayRadius);
    state.contact = true;
    state.object = 0;
    annotator->receive(state, Pose::Identity());
    state.buttons = 2;  // the pen's button
    annotator->receive(state, Pose::Identity());
    state.buttons = 0;
    annotator->receive(state, Pose::Identity());
  }
  void undo() { annotator->handle({.undo = true}, view->screen(), Vec3::Zero()); }
  std::size_t strokes() const { return annotator->pen().annotations().entries.size(); }
  std::vector<CarvedPress> read_saved_presses() const {
    const auto read = read_annotations(options.file, std::vector<std::string>{"clay"}, scene.given_hash);
    EXPECT_TRUE(read) << read.error().what;
    return read ? read->annotations.carved : std::vector<CarvedPress>();
  }
  // Waits until the thread has computed the field, so that strokes find a surface.
  void settle() {
    for (int n = 0; n < 60'000 && !carved->is_up_to_date(); ++n) {
      carved->show();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  // Presses the key for an export, and returns the line that reports its result.
  std::string export_work() {
    annotator->handle({.export_work = true}, view->screen(), Vec3::Zero());
    std::string line;
    EXPECT_TRUE(wait_until([&] {
      if (std::string next = annotator->take_notice(); !next.empty()) line = next;
      return !line.empty() && line != "exporting ...";
    }));
    return line;
  }
  double volume_of(const char* file) const {
    const auto read = load_mesh_file(folder.path() / file);
    EXPECT_TRUE(read) << read.error().what;
    return read ? compute_volume(read->mesh) : 0.0;
  }

  ScratchFolder folder;
  Scene scene;
  std::unique_ptr<StereoView> view;
  AnnotatorOptions options;
  std::unique_ptr<CarvedObjects> carved;
  std::unique_ptr<Annotator> annotator;
  std::uint32_t serial = 0;
};

TEST_F(CarveUndoTest, WhatWasDoneLastIsUndoneFirst) {
  ASSERT_TRUE(view);
  open();
  settle();
  carve();
  draw();
  carve();
  settle();
  draw();
  ASSERT_EQ(strokes(), 2U);
  undo();
  EXPECT_EQ(strokes(), 1U);
  EXPECT_FALSE(annotator->take_carve_undo(kTenthOfSecondNs));
  undo();
  const auto second = annotator->take_carve_undo(2 * kTenthOfSecondNs);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->source, 3U);
  EXPECT_EQ(second->serial, 2U);
  reply(*second);
  EXPECT_FALSE(annotator->take_carve_undo(4 * kTenthOfSecondNs)) << "done";
  undo();
  EXPECT_EQ(strokes(), 0U);
  undo();
  const auto first = annotator->take_carve_undo(5 * kTenthOfSecondNs);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->serial, 1U);
  reply(*first);
  undo();
  EXPECT_FALSE(annotator->take_carve_undo(6 * kTenthOfSecondNs)) << "nothing is left";
}

TEST_F(CarveUndoTest, ARequestIsRepeatedUntilTheUndoComes) {
  ASSERT_TRUE(view);
  open();
  carve();
  undo();
  int sent = 0;
  for (int n = 1; n <= 100; ++n) sent += annotator->take_carve_undo(n * kTenthOfSecondNs / 10) ? 1 : 0;
  EXPECT_EQ(sent, 10) << "in a second";
  // A second press meanwhile makes no second request.
  undo();
  const auto again = annotator->take_carve_undo(12 * kTenthOfSecondNs);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->serial, 1U);
  int last_sent = 0;  // in tenths of a second
  for (int n = 12; n <= 400; ++n) last_sent = annotator->take_carve_undo(n * kTenthOfSecondNs) ? n : last_sent;
  EXPECT_LT(last_sent, 250) << "it is given up";
}

// vision_node was killed after it had saved. haptics_node still runs (3), or was started again with the file (8).
TEST_F(CarveUndoTest, AfterARestartTheNewestIsUndoneFirstToo) {
  ASSERT_TRUE(view);
  for (const std::uint32_t source : {3U, 8U}) {
    serial = 0;
    std::filesystem::remove(options.file);
    open();
    carve(3);
    settle();
    draw();
    carve(3);
    settle();
    draw();
    annotator->handle({.save = true}, view->screen(), Vec3::Zero());
    open();
    serial = 0;
    carve(source);
    carve(source);
    EXPECT_EQ(strokes(), 2U);
    undo();
    EXPECT_FALSE(annotator->take_carve_undo(kTenthOfSecondNs)) << source;
    EXPECT_EQ(strokes(), 1U) << source;
    undo();
    const auto second = annotator->take_carve_undo(2 * kTenthOfSecondNs);
    ASSERT_TRUE(second) << source;
    EXPECT_EQ(second->serial, 2U);
  }
}

// A haptics node that was started again counts its carves from 1 again.
TEST_F(CarveUndoTest, CarvesOfANewHapticsNodeAreNewerThanWhatWasDrawnBefore) {
  ASSERT_TRUE(view);
  open();
  carve(3);
  carve(3);
  settle();
  draw();
  serial = 0;
  carve(8);
  undo();
  const auto newest = annotator->take_carve_undo(kTenthOfSecondNs);
  ASSERT_TRUE(newest);
  EXPECT_EQ(newest->serial, 1U);
  EXPECT_EQ(strokes(), 1U);
}

TEST_F(CarveUndoTest, AnObjectThatWasPutDownBeforeACarveIsPutBackAfterIt) {
  ASSERT_TRUE(view);
  open();
  annotator->receive(ObjectPose{.serial = 1, .object = 0});
  annotator->receive(ObjectPose{.serial = 2, .object = 0, .is_held = true});
  annotator->receive(ObjectPose{.serial = 3, .object = 0, .p_m = Vec3(0.01, 0, 0)});
  carve();
  undo();
  EXPECT_FALSE(annotator->take_due(kTenthOfSecondNs));
  const auto request = annotator->take_carve_undo(kTenthOfSecondNs);
  ASSERT_TRUE(request);
  reply(*request);
  EXPECT_FALSE(annotator->take_carve_undo(2 * kTenthOfSecondNs));
  undo();
  EXPECT_TRUE(annotator->take_due(3 * kTenthOfSecondNs));
}

TEST_F(CarveUndoTest, CarvesAreSavedAndStayWhereHapticsHasThem) {
  ASSERT_TRUE(view);
  open();
  carve();
  carve();
  ASSERT_TRUE(annotator->finish());
  ASSERT_EQ(read_saved_presses().size(), 2U);
  // Another run, with a haptics node that has read the file: nothing is written.
  open();
  serial = 0;
  carve(5);
  carve(5);
  std::filesystem::remove(options.file);
  ASSERT_TRUE(annotator->finish());
  EXPECT_FALSE(std::filesystem::exists(options.file));
  // One more carve, so the file is written.
  carve(5);
  ASSERT_TRUE(annotator->finish());
  EXPECT_EQ(read_saved_presses().size(), 3U);
}

TEST_F(CarveUndoTest, WhatIsUndoneIsNotSaved) {
  ASSERT_TRUE(view);
  open();
  carve();
  carve();
  reply({.source = 3, .serial = 1});
  ASSERT_TRUE(annotator->finish());
  const std::vector<CarvedPress> after = read_saved_presses();
  ASSERT_EQ(after.size(), 1U);
  EXPECT_NEAR(after[0].carves[0].from_m.y(), 0.002, 1e-9);
}

// The line is that of a session that began without a file: the carves of the file may have been undone since.
TEST_F(CarveUndoTest, TheCornerDoesNotCountCarvesOfTheFile) {
  ASSERT_TRUE(view);
  open();
  carve();
  settle();
  draw();
  const std::string line = annotator->describe();
  EXPECT_EQ(line, "1 stroke, 0 measures");
  ASSERT_TRUE(annotator->finish());
  open();
  EXPECT_EQ(annotator->describe(), line);
}

// The carves of the file are not lost when haptics_node was started without the file.
TEST_F(CarveUndoTest, CarvesOfTheFileStayWithoutAHapticsNodeThatHasThem) {
  ASSERT_TRUE(view);
  open();
  carve();
  carve();
  ASSERT_TRUE(annotator->finish());
  open();
  draw();
  ASSERT_TRUE(annotator->finish());
  EXPECT_EQ(read_saved_presses().size(), 2U) << "none has replied";
  open();
  serial = 6;
  Carves carves{.source = 9, .newest = 1, .first = 1, .count = 1};
  carves.carves[0] = one_carve(7);
  carved->take(carves, Arrival::newest);
  ASSERT_TRUE(annotator->finish());
  EXPECT_EQ(read_saved_presses().size(), 3U) << "both";
}

// This happens with --watch-scene: the new scene numbers its objects anew, and its carves have not arrived yet.
TEST_F(CarveUndoTest, CarvesOfTheFileStayOnTheirObjectInASceneOfOtherObjects) {
  ASSERT_TRUE(view);
  open();
  carve();
  annotator->handle({.save = true}, view->screen(), Vec3::Zero());
  ASSERT_EQ(read_saved_presses().size(), 1U);
  Scene other = scene;
  other.objects.insert(other.objects.begin(), scene.objects[0]);
  other.objects[0].name = "mould";
  ASSERT_TRUE(view->replace_scene(std::vector<ShownObject>(2, {scene.objects[0].mesh, {1, 0, 0}}), {}));
  CarvedObjects next(*view, other);
  annotator->change_scene(other, &next);
  annotator->handle({.save = true}, view->screen(), Vec3::Zero());
  annotator.reset();
  const auto read = read_annotations(options.file, std::vector<std::string>{"mould", "clay"}, scene.given_hash);
  ASSERT_TRUE(read) << read.error().what;
  ASSERT_EQ(read->annotations.carved.size(), 1U);
  EXPECT_EQ(read->annotations.carved[0].object, 1);
}

TEST_F(CarveUndoTest, AKeyExportsWhatIsDrawnAndCarvedAndThePictureSaysWhere) {
  ASSERT_TRUE(view);
  options.export_folder = folder.path();
  open();
  settle();
  EXPECT_EQ(export_work(), "nothing to export: nothing is drawn, measured or carved");
  EXPECT_EQ(annotator->take_notice(), "") << "once";
  draw();
  EXPECT_EQ(export_work(), "exported to " + folder.path().string() + ": hapton_export_001.vtp");
  carve();
  EXPECT_EQ(export_work(), "exported to " + folder.path().string() + ": hapton_export_002.vtp, hapton_export_002_clay.stl");
  // The exported surface is closed, and smaller than the ball.
  const double volume = volume_of("hapton_export_002_clay.stl");
  const double ball = 4.0 / 3.0 * std::numbers::pi * std::pow(kUndoClayRadius, 3);
  EXPECT_LT(volume, 0.995 * ball);
  EXPECT_GT(volume, 0.9 * ball);
  std::string failed;
  {
    const FileSizeLimit full(100);
    failed = export_work();
  }
  EXPECT_THAT(failed, testing::StartsWith("NOT EXPORTED: cannot write " + (folder.path() / "hapton_export_003.vtp").string()));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 3) << "nothing half is left";
  annotator->handle({.save = true}, view->screen(), Vec3::Zero());
  EXPECT_EQ(annotator->take_notice(), "saved in " + options.file.string());
}

// An export is computed in its own thread, from the work at the moment of the key, with all carves that had arrived by then.
TEST_F(CarveUndoTest, AnExportHasTheCarvesOfItsMomentAndIsFinishedAtTheEnd) {
  ASSERT_TRUE(view);
  options.export_folder = folder.path();
  open();
  for (int n = 0; n < 3; ++n) {
    carve();
    draw();
    annotator->handle({.export_work = true}, view->screen(), Vec3::Zero());
  }
  EXPECT_THAT(annotator->take_notice(), testing::AnyOf("exporting ...", testing::StartsWith("exported to ")));
  annotator.reset();
  const double first = volume_of("hapton_export_001_clay.stl");
  const double second = volume_of("hapton_export_002_clay.stl");
  const double third = volume_of("hapton_export_003_clay.stl");
  EXPECT_GT(first, 1.0001 * second);
  EXPECT_GT(second, 1.0001 * third);
}

// This happens with --watch-scene, when the scene file is saved while an export is computed.
TEST_F(CarveUndoTest, AnExportOutlivesTheObjectsThatItIsOf) {
  ASSERT_TRUE(view);
  options.export_folder = folder.path();
  open();
  carve();
  annotator->handle({.export_work = true}, view->screen(), Vec3::Zero());
  CarvedObjects next(*view, scene);
  annotator->change_scene(scene, &next);
  carved.reset();
  annotator.reset();
  EXPECT_GT(volume_of("hapton_export_001_clay.stl"), 0.0);
}

// A scene file may give an object any name, and several objects may have the same name.
TEST_F(CarveUndoTest, TheNamesOfExportedSurfacesAreThoseOfTheirObjects) {
  ASSERT_TRUE(view);
  scene.objects[0].name = "a/b c";
  scene.objects.push_back(scene.objects[0]);
  scene.objects.push_back(scene.objects[0]);
  scene.objects[2].name = "the-third";
  view = open_or_fail(plain_settings(StereoMode::mono, 320, 240), std::vector<ShownObject>(3, {scene.objects[0].mesh, {1, 0, 0}}));
  options.export_folder = folder.path();
  open();
  carve();
  EXPECT_THAT(export_work(),
              testing::EndsWith(": hapton_export_001_0_a_b_c.stl, hapton_export_001_1_a_b_c.stl, hapton_export_001_the-third.stl"));
}

// The measure was begun after the carve, so it is undone first.
TEST_F(CarveUndoTest, UndoOfAMeasureThatWasBegunPutsNoMaterialBack) {
  ASSERT_TRUE(view);
  open();
  carve();
  settle();
  ProbeState state;
  state.p_WD = Vec3(0, 0, kUndoClayRadius);
  state.contact = true;
  state.object = 0;
  for (const std::uint32_t buttons : {0U, 4U, 0U}) {  // 4: the button that measures
    state.buttons = buttons;
    annotator->receive(state, Pose::Identity());
  }
  ASSERT_TRUE(annotator->pen().first_end());
  undo();
  EXPECT_FALSE(annotator->pen().first_end());
  EXPECT_FALSE(annotator->take_carve_undo(kTenthOfSecondNs));
  undo();
  EXPECT_TRUE(annotator->take_carve_undo(2 * kTenthOfSecondNs)) << "now the carve";
}

// Another haptics node may have a carve with the same number.
TEST_F(CarveUndoTest, ARequestEndsWithTheHapticsNodeThatItIsFor) {
  ASSERT_TRUE(view);
  open();
  carve(3);
  undo();
  ASSERT_TRUE(annotator->take_carve_undo(kTenthOfSecondNs));
  serial = 0;
  carve(8);
  EXPECT_FALSE(annotator->take_carve_undo(3 * kTenthOfSecondNs));
}

// Long after the key was pressed nobody expects material to come back.
TEST_F(CarveUndoTest, WhatWaitsForARequestThatIsGivenUpIsNotDoneLater) {
  ASSERT_TRUE(view);
  open();
  carve();
  carve();
  undo();
  undo();
  ASSERT_TRUE(annotator->take_carve_undo(kTenthOfSecondNs));
  EXPECT_FALSE(annotator->take_carve_undo(kTenthOfSecondNs + 20'000'000'000)) << "given up";
  EXPECT_FALSE(annotator->take_due(kTenthOfSecondNs + 21'000'000'000));
  EXPECT_FALSE(annotator->take_carve_undo(kTenthOfSecondNs + 21'000'000'000));
  undo();
  EXPECT_TRUE(annotator->take_carve_undo(kTenthOfSecondNs + 22'000'000'000)) << "only at the next press";
}

}  // namespace
}  // namespace hapton
