#include "vision_node/annotator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>

#include "core/geometry/mesh_shapes.h"
#include "scene/annotations_file.h"
#include "tests/support/scratch_folder.h"
#include "tests/vision_node/made_views.h"
#include "vision_node/annotation_figure.h"
#include "vision_node/menu_figure.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

constexpr double kSphere = 0.03;
constexpr std::uint32_t kPenButton = 2;
constexpr std::uint32_t kRuleButton = 4;
constexpr std::uint32_t kMenuButton = 8;

struct AnnotatorTest : testing::Test {
  AnnotatorTest() {
    for (const double x : {0.0, 0.1}) {
      SceneObject object;
      object.name = x > 0.0 ? "right" : "left";
      object.mesh = make_marker({x, 0, 0}, kSphere);
      scene.objects.push_back(object);
      shown.push_back({object.mesh, {1, 0, 0}});
    }
    scene.given_hash = 7;
    view = open_or_fail(plain_settings(StereoMode::mono, 320, 240), shown);
    options.file = folder.path() / "notes.toml";
  }
  void open(bool can_touch = true) {
    auto opened = Annotator::open(*view, scene, 0.15, options, can_touch);
    ASSERT_TRUE(opened) << opened.error().what;
    annotator = std::move(*opened);
  }
  // The device inside a ball, the probe on its surface, a ball of the probe's radius away.
  void touch(const Vec3& direction, std::uint32_t buttons, std::int32_t object = 0, const Pose& X_WS = Pose::Identity()) {
    ProbeState state;
    const Vec3 centre = object == 1 ? Vec3(0.1, 0, 0) : Vec3(0, 0, 0);
    state.p_WD = X_WS * (centre + 0.9 * kSphere * direction.normalized());
    state.visual_offset_m = X_WS.linear() * (0.2 * kSphere * direction.normalized());
    state.contact = true;
    state.object = object;
    state.buttons = buttons;
    annotator->receive(state, X_WS);
  }
  void lift(std::uint32_t buttons = 0, const Vec3& at = Vec3(0, 0.09, 0)) {
    ProbeState state;
    state.p_WD = at;
    state.buttons = buttons;
    annotator->receive(state, Pose::Identity());
  }
  void draw_arc(std::int32_t object = 0, const Pose& X_WS = Pose::Identity()) {
    lift();
    for (int i = 0; i <= 40; ++i) touch({std::sin(0.02 * i), 0.1, std::cos(0.02 * i)}, kPenButton, object, X_WS);
    lift();
  }
  void press(const UserRequests& requests) { annotator->handle(requests, view->screen(), Vec3::Zero()); }
  const std::vector<Annotation>& entries() const { return annotator->pen().annotations().entries; }

  ScratchFolder folder;
  Scene scene;
  std::vector<ShownObject> shown;
  std::unique_ptr<StereoView> view;
  AnnotatorOptions options;
  std::unique_ptr<Annotator> annotator;
};

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
    // A facet of the ball is up to 1 - cos(7.5 degrees) of its radius below it.
    EXPECT_LE((p - Vec3(0.1, 0, 0)).norm(), kSphere * (1.0 + 1e-12));
    EXPECT_GE((p - Vec3(0.1, 0, 0)).norm(), kSphere * 0.98);
  }
  EXPECT_LT((stroke.points_m.front() - Vec3(0.1, 0, 0)).normalized().x(), 0.05) << "in the frame of the object, wherever the dials are";
}

TEST_F(AnnotatorTest, WhatIsDrawnIsSavedAndReadAgain) {
  ASSERT_TRUE(view);
  options.strokes = folder.path() / "lines.vtp";
  open();
  draw_arc();
  touch(Vec3::UnitZ(), kRuleButton);
  lift();
  touch(Vec3::UnitX(), kRuleButton);
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
  const auto read = read_annotations(options.file, std::vector<std::string>{"left", "right"}, 7);
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
  EXPECT_TRUE(read_annotations(options.file, std::vector<std::string>{"left"}, 7)->annotations.entries.empty());
}

TEST_F(AnnotatorTest, BadFilesAreRejectedBeforeAnything) {
  ASSERT_TRUE(view);
  const auto error = [&] {
    const auto opened = Annotator::open(*view, scene, 0.15, options, true);
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
  // Touched where it lies now.
  ProbeState state;
  state.p_WD = Vec3(0.1, 0, 0) + by + Vec3(0, 0, 0.9 * kSphere);
  state.contact = true;
  state.object = 1;
  state.buttons = kPenButton;
  annotator->receive(state, Pose::Identity());
  lift();
  ASSERT_EQ(entries().size(), 1U);
  EXPECT_LT((std::get<Stroke>(entries()[0]).points_m[0] - Vec3(0.1, 0, kSphere)).norm(), 0.02 * kSphere);
  ASSERT_TRUE(annotator->finish());
  const auto read = read_annotations(options.file, std::vector<std::string>{"left", "right"}, 7);
  ASSERT_TRUE(read) << read.error().what;
  ASSERT_EQ(read->annotations.put_down.size(), 1U);
  EXPECT_EQ(read->annotations.put_down[0].object, 1);
  EXPECT_EQ(read->annotations.put_down[0].p_m, by);
}

TEST_F(AnnotatorTest, UndoAsksForAnObjectToBePutBackInItsTurn) {
  ASSERT_TRUE(view);
  open();
  const auto put = [&](std::uint32_t serial, const Vec3& p) {
    annotator->receive(ObjectPose{.serial = serial, .object = 1, .is_held = true});
    annotator->receive(ObjectPose{.serial = serial + 1, .object = 1, .p_m = p});
  };
  annotator->receive(ObjectPose{.serial = 1, .object = 1});
  const Vec3 first(0.0, 0.05, 0.0);
  put(2, first);
  put(4, Vec3(0.0, 0.07, 0.0));
  draw_arc(0);
  ASSERT_EQ(entries().size(), 1U);
  press({.undo = true});
  EXPECT_TRUE(entries().empty()) << "the stroke was drawn last";
  EXPECT_FALSE(annotator->take_due(0));
  press({.undo = true});
  const auto asked = annotator->take_due(1'000'000'000);
  ASSERT_TRUE(asked);
  EXPECT_EQ(asked->object, 1);
  EXPECT_EQ(asked->serial, 5U);
  EXPECT_FALSE(asked->is_held);
  EXPECT_EQ(asked->p_m, first);
  EXPECT_FALSE(annotator->take_due(1'050'000'000));
  EXPECT_TRUE(annotator->take_due(1'100'000'000)) << "again, until there is an answer";
  annotator->receive(ObjectPose{.serial = 6, .object = 1, .p_m = first});
  EXPECT_FALSE(annotator->take_due(1'300'000'000));
  press({.undo = true});
  const auto home = annotator->take_due(2'000'000'000);
  ASSERT_TRUE(home);
  EXPECT_EQ(home->p_m, Vec3::Zero());
  EXPECT_FALSE(annotator->take_due(4'000'000'000)) << "nobody answers";
  EXPECT_FALSE(annotator->take_due(4'200'000'000));
  press({.undo = true});
  EXPECT_FALSE(annotator->take_due(5'000'000'000)) << "nothing is left";
}

// Within a second the left ball grows to twice its size, and moves up.
const Vec3 kUp(0.0, 0.06, 0.0);

struct DeformingAnnotatorTest : AnnotatorTest {
  DeformingAnnotatorTest() {
    MorphTarget target;
    const TriangleMesh& mesh = *scene.objects[0].mesh;
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
      target.vertices.push_back(v);
      target.displacements.emplace_back(mesh.vertices[v] + kUp);
    }
    scene.objects[0].deformation =
        std::make_shared<const MeshDeformation>(std::vector<MorphTarget>{target}, std::vector<MorphKey>{{0.0, {0.0}}, {1.0, {1.0}}}, false);
  }
  // Touches the left ball as large as it is then.
  void touch_at(double time_s, const Vec3& direction, std::uint32_t buttons) {
    ProbeState state;
    state.scene_time_ns = std::llround(1e9 * time_s);
    state.p_WD = time_s * kUp + 1.1 * (1.0 + time_s) * kSphere * direction.normalized();  // outside, where a vertex is closest
    state.contact = true;
    state.object = 0;
    state.buttons = buttons;
    annotator->receive(state, Pose::Identity());
    state.buttons = 0;
    annotator->receive(state, Pose::Identity());
  }
  std::string label() const {
    const auto labels = view->annotation_figure().labels();
    return labels.empty() ? "" : labels[0].text;
  }
};

TEST_F(DeformingAnnotatorTest, ADistanceIsMeasuredOnTheSurfaceAsItIs) {
  ASSERT_TRUE(view);
  open();
  touch_at(1.0, Vec3::UnitZ(), 0);
  touch_at(1.0, Vec3::UnitZ(), kRuleButton);
  touch_at(1.0, Vec3::UnitX(), kRuleButton);
  ASSERT_EQ(entries().size(), 1U);
  // 2 r sqrt(2)
  EXPECT_THAT(annotator->describe(), HasSubstr("measured 84.85 mm"));
}

TEST_F(DeformingAnnotatorTest, MarksGoAlongWithTheSurface) {
  ASSERT_TRUE(view);
  options.strokes = folder.path() / "lines.obj";
  open();
  touch_at(0.0, Vec3::UnitZ(), 0);
  touch_at(0.0, Vec3::UnitZ(), kRuleButton);
  touch_at(0.5, Vec3::UnitX(), kRuleButton);
  annotator->show(Pose::Identity());
  EXPECT_EQ(label(), "63.64 mm");
  EXPECT_THAT(annotator->describe(), HasSubstr("measured 63.64 mm"));
  const auto before = annotator->revision();
  touch_at(1.0, Vec3::UnitX(), 0);
  annotator->show(Pose::Identity());
  EXPECT_EQ(label(), "84.85 mm");
  EXPECT_GT(annotator->revision(), before) << "the corner tells it too";
  EXPECT_THAT(annotator->describe(), HasSubstr("measured 84.85 mm"));
  annotator->show(Pose::Identity());
  const auto after = annotator->revision();
  annotator->show(Pose::Identity());
  EXPECT_EQ(annotator->revision(), after) << "nothing is new";
  // Kept by where it is at rest, so that the file says the same at any time; exported as it is.
  ASSERT_TRUE(annotator->finish());
  const Measure& kept = std::get<Measure>(entries()[0]);
  EXPECT_LE((kept.ends[0].p_O - kSphere * Vec3::UnitZ()).norm(), 1e-12);
  EXPECT_LE((kept.ends[1].p_O - kSphere * Vec3::UnitX()).norm(), 1e-12);
  std::ostringstream exported;
  exported << std::ifstream(options.strokes).rdbuf();
  EXPECT_THAT(exported.str(), HasSubstr("# 0.08485"));
  options.strokes.clear();
  open();
  touch_at(0.0, Vec3::UnitX(), 0);
  EXPECT_THAT(annotator->describe(), HasSubstr("measured 42.43 mm"));
}

// A stroke across several facets; at twice the size it is twice as large.
TEST_F(DeformingAnnotatorTest, AStrokeStretchesWithTheSurface) {
  ASSERT_TRUE(view);
  open();
  touch_at(0.0, Vec3::UnitZ(), 0);
  const auto draw = [&](double time_s, double angle, std::uint32_t buttons) {
    ProbeState state;
    state.scene_time_ns = std::llround(1e9 * time_s);
    state.p_WD = time_s * kUp + (1.0 + time_s) * kSphere * Vec3(std::sin(angle), 0.1, std::cos(angle));
    state.contact = true;
    state.object = 0;
    state.buttons = buttons;
    annotator->receive(state, Pose::Identity());
  };
  for (int i = 0; i <= 100; ++i) draw(0.01 * i, 0.008 * i, kPenButton);
  draw(1.0, 0.8, 0);
  ASSERT_EQ(entries().size(), 1U);
  const std::vector<Vec3>& points = std::get<Stroke>(entries()[0]).points_m;
  EXPECT_GT(points.size(), 5U);
  // Each point was on the ball as large as it was then: kept, they are all on the one at rest, of 24 facets around.
  for (const Vec3& p : points) {
    EXPECT_LE(p.norm(), kSphere * (1.0 + 1e-12));
    EXPECT_GE(p.norm(), kSphere * 0.98);
  }
}

// The same growth, as a program gives it: known once its parts have come.
TEST_F(AnnotatorTest, MarksGoAlongWithASurfaceThatAProgramDeforms) {
  ASSERT_TRUE(view);
  scene.objects[0].program_shape = std::make_shared<const ProgramShape>(ProgramShape{.reach_m = 0.2});
  MovedObjects moved(*view, scene);
  open();
  annotator->set_moved_objects(&moved);
  const auto touch_then = [&](double time_s, double size, const Vec3& direction, std::uint32_t buttons) {
    ProbeState state;
    state.scene_time_ns = std::llround(1e9 * time_s);
    moved.set_time(state.scene_time_ns);
    state.p_WD = 1.1 * size * kSphere * direction;
    state.contact = true;
    state.object = 0;
    for (const std::uint32_t down : {buttons, 0U}) {
      state.buttons = down;
      annotator->receive(state, Pose::Identity());
    }
    annotator->show(Pose::Identity());
  };
  touch_then(0.0, 1.0, Vec3::UnitZ(), 0);
  touch_then(0.0, 1.0, Vec3::UnitZ(), kRuleButton);
  touch_then(0.0, 1.0, Vec3::UnitX(), kRuleButton);
  EXPECT_THAT(annotator->describe(), HasSubstr("measured 42.43 mm"));
  const std::vector<Vec3>& rest = scene.objects[0].mesh->vertices;
  const auto total = static_cast<std::uint32_t>(rest.size());
  moved.take(ShapeStart{.source = 5, .serial = 1, .total = total, .start_ns = 1'000'000'000, .end_ns = 2'000'000'000}, Arrival::newest);
  touch_then(1.5, 1.0, Vec3::UnitX(), 0);
  EXPECT_THAT(annotator->describe(), HasSubstr("measured 42.43 mm")) << "its vertices have not come";
  for (std::uint32_t first = 0; first < total; first += ShapePart::kMostHere) {
    ObjectShape part{.source = 5, .serial = 1, .part = {.total = total, .first = first}};
    for (std::uint32_t v = 0; v < part.part.count(); ++v) {
      const Vec3& p = rest[first + v];
      part.part.displacements_m[v] = {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
    }
    moved.take(part, Arrival::newest);
  }
  touch_then(1.5, 1.5, Vec3::UnitX(), 0);
  EXPECT_THAT(annotator->describe(), HasSubstr("measured 63.64 mm"));
  EXPECT_EQ(view->annotation_figure().labels()[0].text, "63.64 mm");
  touch_then(2.5, 2.0, Vec3::UnitY(), kRuleButton);
  touch_then(2.5, 2.0, Vec3::UnitX(), kRuleButton);
  EXPECT_THAT(annotator->describe(), HasSubstr("measured 84.85 mm"));
  ASSERT_EQ(entries().size(), 2U);
  const Measure& kept = std::get<Measure>(entries()[1]);
  EXPECT_LE((kept.ends[0].p_O - kSphere * Vec3::UnitY()).norm(), 1e-8) << "by where it is at rest";
}

// A pit that is carved as deep as the middle of a ball: what is touched is its bottom.
TEST_F(AnnotatorTest, WhereMaterialIsGoneTheSurfaceThatIsLeftIsMeasured) {
  ASSERT_TRUE(view);
  constexpr float kPit = 0.005F;
  constexpr double kVoxel = 0.001;
  scene.objects[0].mesh = std::make_shared<const TriangleMesh>(make_icosphere(kSphere, 5));
  scene.objects[0].sculpt = SculptSettings{.voxel_m = kVoxel, .tool_radius_m = kPit};
  CarvedObjects carved(*view, scene);
  open();
  annotator->set_carved_objects(&carved);
  Carves carves{.source = 1, .newest = 1, .first = 1, .count = 1};
  carves.carves[0] = {.object = 0, .from_m = {0, 0, 0.05F}, .to_m = {0, 0, kPit}, .radius_m = kPit};
  carved.take(carves, Arrival::newest);
  for (int n = 0; n < 60'000 && !carved.is_up_to_date(); ++n) {
    carved.show();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  const auto press_at = [&](const Vec3& p, std::uint32_t buttons) {
    ProbeState state;
    state.p_WD = p;
    state.contact = true;
    state.object = 0;
    state.buttons = buttons;
    annotator->receive(state, Pose::Identity());
  };
  press_at({0, 0, kPit - 0.0005}, 0);
  press_at({0, 0, kPit - 0.0005}, kRuleButton);  // the ball is on the bottom, its centre half a millimetre below that of the pit
  press_at({kSphere + 0.004, 0, 0}, 0);
  press_at({kSphere + 0.004, 0, 0}, kRuleButton);
  ASSERT_EQ(entries().size(), 1U);
  const Measure measure = std::get<Measure>(entries()[0]);
  EXPECT_LE(measure.ends[0].p_O.norm(), 0.2 * kVoxel) << "the bottom of the pit";
  EXPECT_LE((measure.ends[1].p_O - kSphere * Vec3::UnitX()).norm(), 0.2 * kVoxel);
  EXPECT_NEAR(compute_length_m(measure, {}), kSphere, 0.1 * kVoxel);
  // Material under a mark that is carved away leaves it where it was.
  carves = {.source = 1, .newest = 2, .first = 2, .count = 1};
  carves.carves[0] = {.object = 0, .from_m = {0, 0, 0}, .to_m = {0, 0, 0}, .radius_m = 0.02F};
  carved.take(carves, Arrival::newest);
  for (int n = 0; n < 60'000 && !carved.is_up_to_date(); ++n) {
    carved.show();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  annotator->show(Pose::Identity());
  EXPECT_EQ(std::get<Measure>(entries()[0]).ends[0].p_O, measure.ends[0].p_O);
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
  const auto read = read_annotations(options.file, std::vector<std::string>{"left", "right"}, 7);
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

TEST_F(AnnotatorTest, TheMenuIsDrawnAndTheEntryAtTheTipIsLight) {
  ASSERT_TRUE(view);
  open();
  press({.menu = true});
  const Vec3 undo = annotator->menu().pose() * place_entry(TouchMenu::Entry::undo);
  // At its right end, beside the letters.
  const Vec3 seen = undo + annotator->menu().pose().linear() * Vec3(0.45 * TouchMenu::kWidthM, 0, 0);
  const auto colour = [&] {
    annotator->show(Pose::Identity());
    view->draw();
    const Vec2 at = project_to_pixel(view->screen(), Eye::centre, {320, 240}, seen);
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

}  // namespace
}  // namespace hapton
