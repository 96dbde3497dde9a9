#include "vision_node/carved_objects.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <memory>
#include <thread>

#include "core/geometry/mesh_shapes.h"
#include "tests/recording/made_recording.h"
#include "tests/vision_node/made_views.h"
#include "vision_node/recorded_carves.h"

namespace hapton {
namespace {

constexpr double kClayBallRadius = 0.03;
const Vec3 kBesideClay(0.07, 0.0, 0.0);
constexpr Carves::Point kThroughFrom = {0.0F, 0.01F, -0.04F};
constexpr Carves::Point kThroughTo = {0.0F, 0.01F, 0.04F};

// A ball of clay, and a green one beside it that nobody carves.
struct CarvedObjectsTest : testing::Test {
  void open(StereoMode mode = StereoMode::mono) {
    SceneObject clay;
    clay.name = "clay";
    clay.mesh = std::make_shared<const TriangleMesh>(make_icosphere(kClayBallRadius, 4));
    clay.colour = {1, 0, 0};
    clay.sculpt = SculptSettings{.voxel_m = 0.0015};
    SceneObject other;
    other.mesh = make_marker(kBesideClay, 0.01);
    other.colour = {0, 1, 0};
    scene.objects = {clay, other};
    std::vector<ShownObject> shown;
    for (const SceneObject& object : scene.objects) shown.push_back({object.mesh, Vec3(object.colour.data()), object.appearance});
    view = open_or_fail(plain_settings(mode, 640, 480), shown);
    if (view) carved.emplace(*view, scene);
  }

  // The red value of the pixel where a point of the scene is drawn, in a picture that begins at column `left`.
  int red_at(const Vec3& p, Eye eye = Eye::centre, PictureSize size = {640, 480}, int left = 0) {
    view->draw();
    const Vec2 at = project_to_pixel(view->screen(), eye, size, p);
    return view->read_picture().at(left + static_cast<int>(at.x()), static_cast<int>(at.y()))[0];
  }
  // Waits until the thread has drawn everything. The limit is for a machine that stalls; it says nothing about how long drawing may take.
  bool settle() {
    bool has_changed = false;
    for (int n = 0; n < 60'000; ++n) {
      has_changed = carved->show() || has_changed;
      if (carved->is_up_to_date()) return has_changed;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ADD_FAILURE() << "never up to date";
    return false;
  }
  static Carves make_hole(std::uint32_t source, std::uint32_t serial, std::int32_t object = 0) {
    Carves carves{.source = source, .newest = serial, .first = serial, .count = 1};
    carves.carves[0] = {.object = object, .from_m = kThroughFrom, .to_m = kThroughTo, .radius_m = 0.006F};
    return carves;
  }

  Scene scene;
  std::unique_ptr<StereoView> view;
  std::optional<CarvedObjects> carved;
};

const Vec3 kInHole(0.0, 0.01, 0.0);
const Vec3 kBesideHole(0.0, -0.012, 0.0);

TEST_F(CarvedObjectsTest, AHoleIsSeenWhereItWasCarved) {
  open();
  ASSERT_TRUE(view);
  EXPECT_TRUE(settle()) << "the field's surface is drawn in place of the mesh";
  EXPECT_GT(red_at(kInHole), 200);
  carved->take(make_hole(5, 1), Arrival::newest);
  EXPECT_TRUE(settle());
  EXPECT_EQ(red_at(kInHole), 0) << "through and through";
  EXPECT_GT(red_at(kBesideHole), 200);
  EXPECT_GT(red_at(kInHole + Vec3(0.009, 0, 0)), 200) << "it is no wider";
  EXPECT_EQ(red_at(kInHole + Vec3(0.004, 0, 0)), 0);
  carved->take(make_hole(5, 1), Arrival::newest);
  EXPECT_FALSE(settle()) << "the same carve again";
}

// All stereo modes show the same two pictures; this test looks at each of the two.
TEST_F(CarvedObjectsTest, BothEyesSeeIt) {
  open(StereoMode::side_by_side);
  ASSERT_TRUE(view);
  carved->take(make_hole(5, 1), Arrival::newest);
  settle();
  for (const Eye eye : {Eye::left, Eye::right}) {
    const int left = eye == Eye::left ? 0 : 320;
    EXPECT_EQ(red_at(kInHole, eye, {320, 480}, left), 0);
    EXPECT_GT(red_at(kBesideHole, eye, {320, 480}, left), 200);
  }
}

TEST_F(CarvedObjectsTest, AnotherHapticsProcessBeginsWithTheWholeBody) {
  open();
  ASSERT_TRUE(view);
  carved->take(make_hole(5, 1), Arrival::newest);
  settle();
  EXPECT_EQ(red_at(kInHole), 0);
  carved->take(Carves{.source = 6}, Arrival::newest);
  EXPECT_TRUE(settle());
  EXPECT_GT(red_at(kInHole), 200);
  carved->take(make_hole(5, 2), Arrival::reordered);
  EXPECT_FALSE(settle()) << "a late message of the previous process";
  EXPECT_GT(red_at(kInHole), 200);
}

TEST_F(CarvedObjectsTest, WhatIsMissingIsRequested) {
  open();
  ASSERT_TRUE(view);
  EXPECT_FALSE(carved->take_request(0));
  carved->take(make_hole(5, 3), Arrival::newest);
  const auto request = carved->take_request(0);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->source, 5U);
  EXPECT_EQ(request->complete, 0U);
  settle();
  EXPECT_EQ(red_at(kInHole), 0) << "what has come is seen all the same";
}

// A carved object moves as its mesh would.
TEST_F(CarvedObjectsTest, ItIsDrawnWhereTheObjectIs) {
  open();
  ASSERT_TRUE(view);
  carved->take(make_hole(5, 1), Arrival::newest);
  settle();
  Pose moved = Pose::Identity();
  moved.translation() = Vec3(0.0, -0.05, 0.0);
  view->place_object(0, moved, true);
  EXPECT_EQ(red_at(moved * kInHole), 0);
  EXPECT_GT(red_at(moved * kBesideHole), 200);
}

TEST_F(CarvedObjectsTest, CarvesOfOtherObjectsAreLeftOut) {
  open();
  ASSERT_TRUE(view);
  settle();
  for (const std::int32_t object : {1, 2, 1'000'000})
    carved->take(make_hole(5, static_cast<std::uint32_t>(object), object), Arrival::newest);
  settle();
  EXPECT_GT(red_at(kInHole), 200);
}

TEST_F(CarvedObjectsTest, ASceneWithoutClayNeedsNothing) {
  open();
  ASSERT_TRUE(view);
  settle();
  scene.objects[0].sculpt.reset();
  CarvedObjects none(*view, scene);
  none.take(make_hole(5, 1), Arrival::newest);
  EXPECT_FALSE(none.show());
  EXPECT_TRUE(none.is_up_to_date());
  EXPECT_FALSE(none.take_request(0));
}

// The time goes forwards, backwards, and past the moment at which another haptics process begins.
TEST_F(CarvedObjectsTest, ARecordingShowsWhatWasCarvedUntilThen) {
  const ScratchFolder scratch;
  auto reader = SessionReader::open(MadeRecording().write(scratch));
  ASSERT_TRUE(reader);
  const auto index = RecordingIndex::read(*reader);
  ASSERT_TRUE(index);
  open();
  ASSERT_TRUE(view);
  RecordedCarves recorded(*index, *carved);
  const auto is_hole_at = [&](double t_s) {
    recorded.show(t_s);
    settle();
    return red_at(kInHole) == 0;
  };
  EXPECT_FALSE(is_hole_at(1.0));
  EXPECT_TRUE(is_hole_at(2.0));
  EXPECT_FALSE(is_hole_at(3.5));
  EXPECT_TRUE(is_hole_at(3.0));
  EXPECT_FALSE(is_hole_at(0.5));
}

TEST_F(CarvedObjectsTest, WhatIsUndoneIsSeenAgain) {
  open();
  ASSERT_TRUE(view);
  settle();
  const int red_before = red_at(kInHole);
  Carves carves = make_hole(1, 1);
  carved->take(carves, Arrival::newest);
  settle();
  EXPECT_LT(red_at(kInHole), red_before / 2);
  EXPECT_EQ(carved->list().newest_active(), 1U);
  Carves undo{.source = 1, .newest = 2, .first = 2, .count = 1};
  undo.carves[0] = {.object = -1, .undone_first = 1, .undone_last = 1};
  carved->take(undo, Arrival::newest);
  EXPECT_TRUE(settle());
  EXPECT_EQ(red_at(kInHole), red_before);
  EXPECT_EQ(carved->list().newest_active(), 0U);
  EXPECT_TRUE(carved->is_complete());
  // The carve comes once more, late: it stays undone.
  carves.newest = 2;
  carved->take(carves, Arrival::reordered);
  settle();
  EXPECT_EQ(red_at(kInHole), red_before);
}

// A node that joins late may get the undo before the carve.
TEST_F(CarvedObjectsTest, AnUndoThatComesBeforeItsCarvesCounts) {
  open();
  ASSERT_TRUE(view);
  settle();
  const int red_before = red_at(kInHole);
  Carves undo{.source = 1, .newest = 2, .first = 2, .count = 1};
  undo.carves[0] = {.object = -1, .undone_first = 1, .undone_last = 1};
  carved->take(undo, Arrival::newest);
  Carves carves = make_hole(1, 1);
  carves.newest = 2;
  carved->take(carves, Arrival::newest);
  settle();
  EXPECT_EQ(red_at(kInHole), red_before);
  // The undo that came early is requested again, and changes nothing.
  EXPECT_TRUE(carved->take_request(1'000'000'000));
  carved->take(undo, Arrival::newest);
  settle();
  EXPECT_EQ(red_at(kInHole), red_before);
  EXPECT_FALSE(carved->take_request(2'000'000'000)) << "all have come";
}

}  // namespace
}  // namespace hapton
