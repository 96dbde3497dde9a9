// Strokes and measures on surfaces that change: deformed by morphs or by a program, or carved.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "core/geometry/mesh_shapes.h"
#include "tests/vision_node/annotator_fixture.h"
#include "vision_node/annotation_figure.h"
#include "vision_node/carved_objects.h"
#include "vision_node/moved_objects.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

// Within a second the left ball grows to twice its size, and moves up by this.
const Vec3 kUpwardMove(0.0, 0.06, 0.0);

struct DeformingAnnotatorTest : AnnotatorTest {
  DeformingAnnotatorTest() {
    MorphTarget target;
    const TriangleMesh& mesh = *scene.objects[0].mesh;
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
      target.vertices.push_back(v);
      target.displacements.emplace_back(mesh.vertices[v] + kUpwardMove);
    }
    scene.objects[0].deformation =
        std::make_shared<const MeshDeformation>(std::vector<MorphTarget>{target}, std::vector<MorphKey>{{0.0, {0.0}}, {1.0, {1.0}}}, false);
  }
  // Touches the left ball in its size and place at time_s.
  void touch_at(double time_s, const Vec3& direction, std::uint32_t buttons) {
    ProbeState state;
    state.scene_time_ns = std::llround(1e9 * time_s);
    state.p_WD =
        time_s * kUpwardMove + 1.1 * (1.0 + time_s) * kBallRadius * direction.normalized();  // outside: the closest point is a vertex
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
  touch_at(1.0, Vec3::UnitZ(), kMeasureButton);
  touch_at(1.0, Vec3::UnitX(), kMeasureButton);
  ASSERT_EQ(entries().size(), 1U);
  // 2 r sqrt(2), where r is the radius at rest.
  EXPECT_THAT(annotator->describe(), HasSubstr("measured 84.85 mm"));
}

TEST_F(DeformingAnnotatorTest, MarksGoAlongWithTheSurface) {
  ASSERT_TRUE(view);
  options.strokes = folder.path() / "lines.obj";
  open();
  touch_at(0.0, Vec3::UnitZ(), 0);
  touch_at(0.0, Vec3::UnitZ(), kMeasureButton);
  touch_at(0.5, Vec3::UnitX(), kMeasureButton);
  annotator->show(Pose::Identity());
  EXPECT_EQ(label(), "63.64 mm");
  EXPECT_THAT(annotator->describe(), HasSubstr("measured 63.64 mm"));
  const auto before = annotator->revision();
  touch_at(1.0, Vec3::UnitX(), 0);
  annotator->show(Pose::Identity());
  EXPECT_EQ(label(), "84.85 mm");
  EXPECT_GT(annotator->revision(), before) << "the text in the corner shows it, too";
  EXPECT_THAT(annotator->describe(), HasSubstr("measured 84.85 mm"));
  annotator->show(Pose::Identity());
  const auto after = annotator->revision();
  annotator->show(Pose::Identity());
  EXPECT_EQ(annotator->revision(), after) << "nothing is new";
  // The measure is stored as points of the surface at rest, so that the file is the same at any time. The export has the present surface.
  ASSERT_TRUE(annotator->finish());
  const Measure& measure = std::get<Measure>(entries()[0]);
  EXPECT_LE((measure.ends[0].p_O - kBallRadius * Vec3::UnitZ()).norm(), 1e-12);
  EXPECT_LE((measure.ends[1].p_O - kBallRadius * Vec3::UnitX()).norm(), 1e-12);
  std::ostringstream exported;
  exported << std::ifstream(options.strokes).rdbuf();
  EXPECT_THAT(exported.str(), HasSubstr("# 0.08485"));
  options.strokes.clear();
  open();
  touch_at(0.0, Vec3::UnitX(), 0);
  EXPECT_THAT(annotator->describe(), HasSubstr("measured 42.43 mm"));
}

// A stroke across several facets, drawn while the ball grows to twice its size.
TEST_F(DeformingAnnotatorTest, AStrokeStretchesWithTheSurface) {
  ASSERT_TRUE(view);
  open();
  touch_at(0.0, Vec3::UnitZ(), 0);
  const auto draw = [&](double time_s, double angle, std::uint32_t buttons) {
    ProbeState state;
    state.scene_time_ns = std::llround(1e9 * time_s);
    state.p_WD = time_s * kUpwardMove + (1.0 + time_s) * kBallRadius * Vec3(std::sin(angle), 0.1, std::cos(angle));
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
  // Each point was on the ball in its size of that moment. They are stored as points of the ball at rest, which has 24 facets around.
  for (const Vec3& p : points) {
    EXPECT_LE(p.norm(), kBallRadius * (1.0 + 1e-12));
    EXPECT_GE(p.norm(), kBallRadius * 0.98);
  }
}

// A program makes the ball grow in the same way; its shape is known once all its parts have arrived.
TEST_F(AnnotatorTest, MarksGoAlongWithASurfaceThatAProgramDeforms) {
  ASSERT_TRUE(view);
  scene.objects[0].program_shape = std::make_shared<const ProgramShape>(ProgramShape{.reach_m = 0.2});
  MovedObjects moved(*view, scene);
  open();
  annotator->set_moved_objects(&moved);
  const auto touch_at_time = [&](double time_s, double size, const Vec3& direction, std::uint32_t buttons) {
    ProbeState state;
    state.scene_time_ns = std::llround(1e9 * time_s);
    moved.set_time(state.scene_time_ns);
    state.p_WD = 1.1 * size * kBallRadius * direction;
    state.contact = true;
    state.object = 0;
    for (const std::uint32_t down : {buttons, 0U}) {
      state.buttons = down;
      annotator->receive(state, Pose::Identity());
    }
    annotator->show(Pose::Identity());
  };
  touch_at_time(0.0, 1.0, Vec3::UnitZ(), 0);
  touch_at_time(0.0, 1.0, Vec3::UnitZ(), kMeasureButton);
  touch_at_time(0.0, 1.0, Vec3::UnitX(), kMeasureButton);
  EXPECT_THAT(annotator->describe(), HasSubstr("measured 42.43 mm"));
  const std::vector<Vec3>& vertices_at_rest = scene.objects[0].mesh->vertices;
  const auto total = static_cast<std::uint32_t>(vertices_at_rest.size());
  moved.take(ShapeStart{.source = 5, .serial = 1, .total = total, .start_ns = 1'000'000'000, .end_ns = 2'000'000'000}, Arrival::newest);
  touch_at_time(1.5, 1.0, Vec3::UnitX(), 0);
  EXPECT_THAT(annotator->describe(), HasSubstr("measured 42.43 mm")) << "its vertices have not come";
  for (std::uint32_t first = 0; first < total; first += ShapePart::kVerticesPerPart) {
    ObjectShape part{.source = 5, .serial = 1, .part = {.total = total, .first = first}};
    for (std::uint32_t v = 0; v < part.part.count(); ++v) {
      const Vec3& p = vertices_at_rest[first + v];
      part.part.displacements_m[v] = {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
    }
    moved.take(part, Arrival::newest);
  }
  touch_at_time(1.5, 1.5, Vec3::UnitX(), 0);
  EXPECT_THAT(annotator->describe(), HasSubstr("measured 63.64 mm"));
  EXPECT_EQ(view->annotation_figure().labels()[0].text, "63.64 mm");
  touch_at_time(2.5, 2.0, Vec3::UnitY(), kMeasureButton);
  touch_at_time(2.5, 2.0, Vec3::UnitX(), kMeasureButton);
  EXPECT_THAT(annotator->describe(), HasSubstr("measured 84.85 mm"));
  ASSERT_EQ(entries().size(), 2U);
  const Measure& measure = std::get<Measure>(entries()[1]);
  EXPECT_LE((measure.ends[0].p_O - kBallRadius * Vec3::UnitY()).norm(), 1e-8) << "stored as a point of the surface at rest";
}

// A pit is carved as deep as the centre of the ball: the bottom of the pit is what is touched.
TEST_F(AnnotatorTest, WhereMaterialIsGoneTheSurfaceThatIsLeftIsMeasured) {
  ASSERT_TRUE(view);
  constexpr float kPitRadius = 0.005F;
  constexpr double kVoxel = 0.001;
  scene.objects[0].mesh = std::make_shared<const TriangleMesh>(make_icosphere(kBallRadius, 5));
  scene.objects[0].sculpt = SculptSettings{.voxel_m = kVoxel, .tool_radius_m = kPitRadius};
  CarvedObjects carved(*view, scene);
  open();
  annotator->set_carved_objects(&carved);
  Carves carves{.source = 1, .newest = 1, .first = 1, .count = 1};
  carves.carves[0] = {.object = 0, .from_m = {0, 0, 0.05F}, .to_m = {0, 0, kPitRadius}, .radius_m = kPitRadius};
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
  press_at({0, 0, kPitRadius - 0.0005}, 0);
  press_at({0, 0, kPitRadius - 0.0005},
           kMeasureButton);  // the tool touches the bottom, its centre is half a millimetre lower than that of the pit
  press_at({kBallRadius + 0.004, 0, 0}, 0);
  press_at({kBallRadius + 0.004, 0, 0}, kMeasureButton);
  ASSERT_EQ(entries().size(), 1U);
  const Measure measure = std::get<Measure>(entries()[0]);
  EXPECT_LE(measure.ends[0].p_O.norm(), 0.2 * kVoxel) << "the bottom of the pit";
  EXPECT_LE((measure.ends[1].p_O - kBallRadius * Vec3::UnitX()).norm(), 0.2 * kVoxel);
  EXPECT_NEAR(compute_length_m(measure, {}), kBallRadius, 0.1 * kVoxel);
  // A mark stays where it was when the material under it is carved away.
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

}  // namespace
}  // namespace hapton
