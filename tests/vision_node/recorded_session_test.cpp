#include "vision_node/recorded_session.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "scene/mesh_file.h"
#include "scene/object_reader.h"
#include "tests/recording/opened_recording.h"
#include "tests/vision_node/gone_folder.h"
#include "tests/vision_node/made_views.h"
#include "vision_node/recorded_surfaces.h"
#include "vision_node/vision_session.h"

// Include this last: it brings X's macros, which break other headers.
#include "tests/vision_node/window_person.h"

namespace hapton {
namespace {

// A window that shows the made recording.
struct RecordedWindow : OpenedRecording {
  explicit RecordedWindow(VisionOptions base_options, MadeRecording&& recording = MadeRecording())
      : OpenedRecording(std::move(recording)), options(std::move(base_options)) {
    options.session = file;
    options.view.width_px = 320;
    options.view.height_px = 180;
    for (int i = 0; i < 3; ++i) {
      SceneObject object{"ball", make_marker(Vec3(0.04 * i, 0.0, 0.0), 0.015), {}, {0.8, 0.2, 0.1}};
      object.is_movable = i == 1;
      scene.objects.push_back(std::move(object));
    }
    view = std::move(*open_view(scene, options));
    session = std::make_unique<RecordedSession>(*view, clock, options, index, *rows);
  }

  VisionOptions options;
  SteadyClock clock;
  StopSignal stop;
  Scene scene;
  std::unique_ptr<StereoView> view;
  std::unique_ptr<RecordedSession> session;
};

TEST(RecordedSession, PlaysInTheTimeOfTheRecording) {
  VisionOptions options;
  options.seconds = 0.8;
  options.speed = 2.0;
  options.view.offscreen = true;
  RecordedWindow window(options);
  const std::int64_t begin_ns = window.clock.now_ns();
  ASSERT_TRUE(window.session->run(window.stop));
  const double passed_s = 1e-9 * static_cast<double>(window.clock.now_ns() - begin_ns);
  EXPECT_GT(window.session->player().moment_s(), window.index.begin_s());
  EXPECT_LE(window.session->player().moment_s(), window.index.begin_s() + 2.0 * passed_s);
  EXPECT_GT(window.session->step().frames().drawn(), 1U);
}

TEST(RecordedSession, ShowsTheRequestedMomentWithItsTimeLine) {
  const ScratchFolder scratch;
  VisionOptions options;
  options.at_s = 2.5;
  options.view.offscreen = true;
  options.screenshot = scratch.path() / "a.png";
  RecordedWindow window(options);
  MovedObjects moved(*window.view, window.scene);
  window.session->set_moved_objects(&moved);
  window.session->set_scene(78);
  ASSERT_TRUE(window.session->run(window.stop));
  EXPECT_TRUE(std::filesystem::exists(options.screenshot));
  EXPECT_DOUBLE_EQ(window.session->player().moment_s(), 2.5);
  EXPECT_TRUE(window.session->step().contact());
  EXPECT_NEAR(window.session->step().scene_pose().translation().x(), 0.25, 1e-6);
  // The time line is green where there was contact, just after its middle, and not near its beginning.
  const Picture picture = window.view->read_picture();
  const TimeLinePlace place = place_time_line(picture.size);
  const int y = static_cast<int>(place.bottom_px + 0.5 * place.height_px);
  const auto at = [&](double share) { return picture.at(static_cast<int>(place.left_px + share * place.width_px), y); };
  EXPECT_GT(at(0.55)[1], at(0.55)[0] + 60);
  EXPECT_LT(std::abs(at(0.1)[1] - at(0.1)[0]), 20);
  const std::uint8_t* moment_pixel = at(find_time_line_share(window.index, 2.5));
  EXPECT_GT(std::min({moment_pixel[0], moment_pixel[1], moment_pixel[2]}), 200) << "white";
}

// Through the real window: with X's names of keys and positions of the pointer.
TEST(RecordedSession, ObeysKeysAndAPressOnTheLine) {
  VisionOptions options;
  options.seconds = 0.5;
  options.view.offscreen = false;
  RecordedWindow window(options);
  window.view->draw();
  Person person;
  ASSERT_TRUE(person.has_window());
  const PictureSize size = window.view->picture_size();
  for (const KeySym key : {XK_bracketright, XK_bracketright, XK_space}) person.press_key(key);
  const TimeLinePlace place = place_time_line(size);
  const int x = static_cast<int>(place.left_px + 0.5 * place.width_px);
  person.send_button(ButtonPress, 1, x, size.height_px - 5);
  person.send_button(ButtonRelease, 1, x, size.height_px - 5);
  person.press_key(XK_period);
  ASSERT_TRUE(window.session->run(window.stop));
  EXPECT_TRUE(window.session->player().is_paused());
  EXPECT_EQ(window.session->player().speed(), 4.0);
  // The middle of four seconds, and one sample more.
  EXPECT_NEAR(window.session->player().moment_s(), 2.0, 0.03);
}

TEST(RecordedSession, AScreenshotByKeyThatFailsIsALineInThePicture) {
  VisionOptions options;
  options.seconds = 30.0;  // the key q ends it earlier
  options.view.offscreen = false;
  RecordedWindow window(options);
  window.view->draw();
  Person person;
  ASSERT_TRUE(person.has_window());
  for (const KeySym key : {XK_s, XK_q}) person.press_key(key);
  const GoneFolder nowhere;
  const auto ended = window.session->run(window.stop);
  ASSERT_TRUE(ended) << ended.error().what;
  const std::string& line = window.session->step().recent_event();
  EXPECT_TRUE(line.starts_with("NO SCREENSHOT: cannot write the screenshot hapton_001.png")) << line;
}

Picture picture_of_view(const char* view) {
  const ScratchFolder scratch;
  VisionOptions options;
  options.at_s = 1.0;  // before the recording shifts the scene
  options.view.offscreen = true;
  options.screenshot = scratch.path() / "a.png";
  options.teach = *parse_teach(view);
  RecordedWindow window(options);
  TeachBuilder teacher(window.scene.touch_scene());
  window.session->set_teacher(&teacher);
  EXPECT_TRUE(window.session->run(window.stop));
  return window.view->read_picture();
}

TEST(RecordedSession, TeachingViewsAreInThePictureOfAMoment) {
  const Picture none = picture_of_view("off");
  for (const char* view : {"local-set", "tree:0", "grid", "curvature"}) {
    const Picture shown = picture_of_view(view);
    std::size_t changed = 0;
    for (int y = 60; y < 120; ++y) {  // where neither lines of text nor the time line are
      for (int x = 60; x < 260; ++x) {
        const std::uint8_t* a = none.at(x, y);
        const std::uint8_t* b = shown.at(x, y);
        changed += std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]) > 60 ? 1 : 0;
      }
    }
    EXPECT_GT(changed, 20U) << view;
  }
}

// A program's move is applied from 0.2 s before it was recorded on; the scene time of the shown sample decides where the object is.
TEST(RecordedObjects, WhatProgramsMoveIsWhereItWasInSceneTime) {
  VisionOptions options;
  options.view.offscreen = true;
  RecordedWindow window(options);
  ObjectSpec spec;
  spec.motion.by_program = true;
  SceneObject& lid = window.scene.objects[2];
  lid.commanded = std::make_shared<const CommandedObject>(spec, SceneFit(), *lid.mesh);
  MovedObjects moved(*window.view, window.scene);
  RecordedObjects objects(window.index, moved);
  const Pose at_rest = Pose::Identity();
  objects.show(0.94, 1'500'000'000);
  EXPECT_FALSE(objects.show(0.95, 1'500'000'000)) << "not known yet";
  EXPECT_EQ(moved.moving()[2].matrix(), at_rest.matrix());
  EXPECT_TRUE(objects.show(1.05, 1'450'000'000));
  EXPECT_NEAR(moved.moving()[2].translation().y(), 0.05, 1e-3) << "half way";
  EXPECT_FALSE(objects.show(1.06, 1'450'000'000)) << "scene time stands still";
  EXPECT_TRUE(objects.show(2.5, 2'500'000'000));
  const Vec3 there = moved.moving()[2].translation();
  EXPECT_TRUE(objects.show(0.9, 900'000'000));
  EXPECT_EQ(moved.moving()[2].matrix(), at_rest.matrix()) << "back";
  EXPECT_TRUE(objects.show(3.9, 3'900'000'000));
  EXPECT_EQ(moved.moving()[2].translation(), there);
}

TEST(RecordedObjects, GoesForwardsAndBackwards) {
  VisionOptions options;
  options.view.offscreen = true;
  RecordedWindow window(options);
  MovedObjects moved(*window.view, window.scene);
  RecordedObjects objects(window.index, moved);
  objects.show(0.6, 0);
  EXPECT_EQ(moved.held(), 1);
  EXPECT_TRUE(objects.show(1.0, 0));
  EXPECT_EQ(moved.held(), -1);
  EXPECT_FALSE(objects.show(1.1, 0));
  EXPECT_TRUE(objects.show(0.7, 0));
  EXPECT_EQ(moved.held(), 1);
  EXPECT_TRUE(objects.show(0.1, 0));
  EXPECT_EQ(moved.held(), -1);
}

// A recording in which a program deforms an object: it moves all vertices to the right.
struct ShapesRecording {
  MadeRecording recording;

  // Adds a shape: its vertices come part by part, from 20 samples before its start on, and once more 200 samples later.
  void add(std::uint32_t total, std::uint64_t sample, const ShapeStart& start, float right_m) {
    const auto before = recording.also;
    recording.also = [this, before, total, sample, start, right_m](std::uint64_t now) {
      if (before) before(now);
      const std::uint64_t first_at = start.start_ns == 0 ? sample + 3 : sample - 20;  // 0: a shape from before the recording
      for (const std::uint64_t at : {first_at, first_at + 200}) {
        if (now < at || (now - at) * ShapePart::kVerticesPerPart >= total || start.serial == 0) continue;
        ObjectShape part{.source = start.source, .serial = start.serial, .object = start.object};
        part.part = {.total = total, .first = static_cast<std::uint32_t>(now - at) * ShapePart::kVerticesPerPart};
        part.part.displacements_m.fill({right_m, 0.0F, 0.0F});
        recording.receive(MadeRecording::kHaptics, part, now);
      }
      if (now == sample || now == sample + 500) recording.receive(MadeRecording::kHaptics, start, now);
    };
  }
};

struct RecordedSurfacesTest : testing::Test {
  ShapesRecording made;
  std::uint32_t total = static_cast<std::uint32_t>(make_marker(Vec3::Zero(), 0.015)->vertices.size());

  ShapeStart start_of(std::uint32_t serial, std::int64_t start_ms, std::int64_t end_ms, std::uint32_t source = 5) const {
    return {.source = source,
            .serial = serial,
            .before = serial > 0 ? serial - 1 : 0,
            .total = total,
            .start_ns = start_ms * 1'000'000,
            .end_ns = end_ms * 1'000'000};
  }
  void open() {
    VisionOptions options;
    options.view.offscreen = true;
    window = std::make_unique<RecordedWindow>(options, std::move(made.recording));
    window->scene.objects[0].program_shape = std::make_shared<const ProgramShape>(ProgramShape{.reach_m = 0.1});
    moved.emplace(*window->view, window->scene);
    auto opened = RecordingShapes::open(window->file);
    ASSERT_TRUE(opened) << opened.error().what;
    shapes.emplace(std::move(*opened));
    surfaces.emplace(window->index, *shapes, *moved);
  }
  // Shows that moment. Returns how far all vertices are moved to the right, mm.
  double show(double t_s) {
    const auto scene_time_ns = std::llround(1e9 * t_s);
    surfaces->show(t_s, scene_time_ns);
    moved->set_time(scene_time_ns);
    const auto vertices = moved->find_vertices(0);
    if (!vertices) return NAN;
    const std::vector<Vec3>& rest = window->scene.objects[0].mesh->vertices;
    for (std::size_t v = 0; v < rest.size(); ++v) EXPECT_NEAR((*vertices)[v].x() - rest[v].x(), (*vertices)[0].x() - rest[0].x(), 1e-9);
    return 1e3 * ((*vertices)[0].x() - rest[0].x());
  }

  std::unique_ptr<RecordedWindow> window;
  std::optional<MovedObjects> moved;
  std::optional<RecordingShapes> shapes;
  std::optional<RecordedSurfaces> surfaces;
};

TEST_F(RecordedSurfacesTest, AnObjectThatAProgramDeformedHasItsShapeOfEachMoment) {
  made.add(total, 400, start_of(1, 398, 798), 0.02F);
  made.add(total, 1000, start_of(2, 1000, 1400), -0.01F);
  for (std::uint32_t n = 0; n < 30; ++n) {
    made.add(total, 1500 + 40 * n, start_of(3 + n, 1500 + 40 * n, 1540 + 40 * n), n % 2 == 0 ? 0.01F : -0.01F);
  }
  made.add(total, 3300, start_of(0, 0, 0, 6), 0.0F);
  open();
  EXPECT_EQ(window->index.shapes().all().size(), 33U) << "what was sent again is left out";
  const std::vector<std::pair<double, double>> expected_shifts = {{0.1, 0.0},    {0.399, 0.05}, {0.598, 10.0}, {0.9, 20.0},  {1.2, 5.0},
                                                                  {1.45, -10.0}, {1.5, -10.0},  {1.52, 0.0},   {1.54, 10.0}, {2.5, 10.0},
                                                                  {2.9, -10.0},  {3.25, -10.0}, {3.31, 0.0},   {3.9, 0.0}};
  for (const auto& [t_s, right_mm] : expected_shifts) EXPECT_NEAR(show(t_s), right_mm, 1e-4) << t_s;
  for (auto shift = expected_shifts.rbegin(); shift != expected_shifts.rend(); ++shift)
    EXPECT_NEAR(show(shift->first), shift->second, 1e-4) << "back to " << shift->first;
  for (std::size_t n = 0; n < 3 * expected_shifts.size(); ++n) {
    const auto& [t_s, right_mm] = expected_shifts[(5 * n) % expected_shifts.size()];
    EXPECT_NEAR(show(t_s), right_mm, 1e-4) << "across to " << t_s;
  }
}

// The haptics node started before the hub: a shape that it already had then is shown from the beginning, although it announces it later.
TEST_F(RecordedSurfacesTest, AShapeFromBeforeTheRecordingIsShownFromItsBeginning) {
  made.add(total, 700, start_of(4, 0, 1), 0.02F);
  made.add(total, 2000, start_of(5, 2000, 2400), -0.01F);
  open();
  for (const double t_s : {0.05, 3.0, 0.5, 1.9}) EXPECT_NEAR(show(t_s), t_s < 2.4 ? 20.0 : -10.0, 1e-4) << t_s;
  EXPECT_NEAR(show(2.2), 5.0, 1e-4);
}

// The vertices of shape 2 were lost: the object goes to the next shape that is known, as in a live session.
TEST_F(RecordedSurfacesTest, WithoutAPartOfAShapeTheOthersAreShown) {
  made.add(total, 400, start_of(1, 398, 798), 0.02F);
  made.add(0, 1000, start_of(2, 1000, 1400), -0.01F);
  made.add(total, 1600, start_of(3, 1600, 2000), 0.01F);
  open();
  EXPECT_NEAR(show(1.2), 20.0, 1e-4);
  EXPECT_NEAR(show(1.5), 20.0, 1e-4);
  EXPECT_NEAR(show(1.8), 10.0, 1e-4);
  EXPECT_NEAR(show(0.1), 0.0, 1e-4);
}

// The window shows these shapes: its picture differs from one of the same moment with the object at rest.
TEST_F(RecordedSurfacesTest, ShapesAreInTheShownSession) {
  const auto picture_at = [&](double t_s, bool is_read) {
    const ScratchFolder folder;
    VisionOptions options;
    options.at_s = t_s;
    options.view.offscreen = true;
    options.screenshot = folder.path() / "a.png";
    ShapesRecording own;
    own.add(total, 400, start_of(1, 398, 798), 0.06F);
    RecordedWindow shown(options, std::move(own.recording));
    shown.scene.objects[0].program_shape = std::make_shared<const ProgramShape>(ProgramShape{.reach_m = 0.1});
    MovedObjects objects(*shown.view, shown.scene);
    auto read = RecordingShapes::open(shown.file);
    shown.session->set_moved_objects(&objects, is_read ? &*read : nullptr);
    EXPECT_TRUE(shown.session->run(shown.stop));
    const Picture picture = shown.view->read_picture();
    const auto middle = picture.rgb.begin() + 3 * 60 * picture.size.width_px;  // without the lines of text
    return std::vector<std::uint8_t>(middle, middle + 3 * 60 * picture.size.width_px);
  };
  EXPECT_NE(picture_at(1.3, true), picture_at(1.3, false));
  EXPECT_EQ(picture_at(0.3, true), picture_at(0.3, false));
}

// Object 0 is carved at 1.6 s, and whole again from 3.2 s on.
TEST(RecordedSession, AKeyExportsWhatWasCarvedUntilTheMomentShown) {
  const auto volume_at = [](double t_s) {
    const ScratchFolder scratch;
    VisionOptions options;
    options.at_s = t_s;
    options.seconds = 60.0;
    options.view.offscreen = false;
    options.annotations.export_folder = scratch.path();
    RecordedWindow window(options);
    window.scene.objects[0].name = "clay";
    window.scene.objects[0].mesh = std::make_shared<const TriangleMesh>(make_icosphere(0.015, 3));
    window.scene.objects[0].sculpt = SculptSettings{.voxel_m = 0.001, .tool_radius_m = 0.006};
    MovedObjects moved(*window.view, window.scene);
    CarvedObjects carved(*window.view, window.scene);
    const auto marks = RecordedMarks::open(*window.view, window.scene, 0.1, {}, moved);
    EXPECT_TRUE(marks) << marks.error().what;
    window.session->set_moved_objects(&moved);
    window.session->set_carved_objects(&carved);
    window.session->set_marks(window.scene, marks->get());
    window.view->draw();
    Person person;
    EXPECT_TRUE(person.has_window());
    for (const KeySym key : {XK_o, XK_q}) person.press_key(key);
    EXPECT_TRUE(window.session->run(window.stop));
    window.session.reset();  // finishes the export
    const auto file = scratch.path() / "hapton_export_001_clay.stl";
    if (!std::filesystem::exists(file)) return 0.0;
    const auto mesh = load_mesh_file(file);
    EXPECT_TRUE(mesh) << mesh.error().what;
    return mesh ? compute_volume(mesh->mesh) : 0.0;
  };
  EXPECT_EQ(volume_at(1.5), 0.0) << "nothing to export";
  const double carved_volume = volume_at(2.5);
  EXPECT_GT(carved_volume, 0.0);
  EXPECT_LT(carved_volume, 0.95 * compute_volume(make_icosphere(0.015, 3)));
  EXPECT_EQ(volume_at(3.5), 0.0) << "another haptics process";
}

// Whoever ends the program while a picture waits for carved objects does not wait for them.
TEST(RecordedSession, AStopEndsTheWaitForCarvedObjects) {
  struct StoppingClock final : Clock {
    explicit StoppingClock(StopSignal& to_request) : stop(to_request) {}
    std::int64_t now_ns() const noexcept override { return SteadyClock().now_ns(); }
    void sleep_until_ns(std::int64_t) noexcept override {
      stop.request_stop();
      ++sleeps;
    }
    StopSignal& stop;
    int sleeps = 0;
  };
  for (const bool is_video : {false, true}) {
    SCOPED_TRACE(is_video);
    const ScratchFolder scratch;
    VisionOptions options;
    options.at_s = 2.5;
    options.view.offscreen = true;
    (is_video ? options.frames : options.screenshot) = scratch.path() / "picture";
    RecordedWindow window(options);
    window.scene.objects[0].mesh = std::make_shared<const TriangleMesh>(make_icosphere(0.015, 3));
    window.scene.objects[0].sculpt = SculptSettings{.voxel_m = 0.001, .tool_radius_m = 0.006};
    CarvedObjects carved(*window.view, window.scene);
    StoppingClock clock(window.stop);
    RecordedSession session(*window.view, clock, window.options, window.index, *window.rows);
    session.set_carved_objects(&carved);
    ASSERT_TRUE(session.run(window.stop));
    EXPECT_EQ(clock.sleeps, 1);
    EXPECT_FALSE(std::filesystem::exists(is_video ? options.frames / "frame_000001.png" : options.screenshot)) << "not complete";
  }
}

// One picture for each half second of the recording, however long it takes to draw.
TEST(RecordedSession, WritesAPictureForEachMomentOfAVideo) {
  const ScratchFolder scratch;
  VisionOptions options;
  options.at_s = 1.6;
  options.seconds = 1.5;
  options.frames = scratch.path() / "new" / "frames";
  options.frame_rate_hz = 2.0;
  options.view.offscreen = true;
  std::vector<std::string> pictures;
  {
    RecordedWindow window(options);
    ASSERT_TRUE(window.session->run(window.stop));
    EXPECT_NEAR(window.session->player().moment_s(), 3.1, 1e-9);
    EXPECT_FALSE(window.session->step().contact()) << "at its end";
  }
  for (int n = 1; n <= 5; ++n) {
    std::ifstream file(options.frames / fmt::format("frame_{:06}.png", n), std::ios::binary);
    pictures.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  for (int n = 0; n < 4; ++n) {
    EXPECT_GT(pictures[static_cast<std::size_t>(n)].size(), 1000U) << n;
    for (int other = 0; other < n; ++other) EXPECT_NE(pictures[static_cast<std::size_t>(n)], pictures[static_cast<std::size_t>(other)]);
  }
  EXPECT_TRUE(pictures[4].empty()) << "four moments are in a second and a half";
  RecordedWindow again(options);
  const auto rejected = again.session->run(again.stop);
  ASSERT_FALSE(rejected);
  EXPECT_NE(rejected.error().what.find("of an earlier run; name a new or empty folder"), std::string::npos) << rejected.error().what;
}

}  // namespace
}  // namespace hapton
