#include "core/collision/shape_stage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/found_in_trees.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

constexpr double kReach = 0.03;

struct StreamedObject {
  explicit StreamedObject(TriangleMesh of) : mesh(made::shared(std::move(of))) {
    geometry = std::make_unique<TouchGeometry>(std::vector<std::shared_ptr<const TriangleMesh>>{mesh}, BuildPolicy::to_deform, std::nullopt,
                                               bounds_with_reach(*mesh, kReach));
    stager = std::make_unique<ShapeStager>(*geometry, mesh, kReach);
    surface = std::make_unique<StreamedGeometry>(*geometry, stager->make_rest());
  }
  template <class Map>
  std::vector<Vec3> mapped_vertices(const Map& map) const {
    std::vector<Vec3> shape;
    for (const Vec3& p : mesh->vertices) shape.push_back(map(p));
    return shape;
  }
  // The stage that leads to `shape` from where the newest stage ends.
  std::unique_ptr<ShapeStage> stage_to(const std::vector<Vec3>& shape) const {
    auto made = stager->make(surface->newest().to, shape);
    EXPECT_TRUE(made) << (made ? "" : made.error().what);
    return made ? std::move(*made) : nullptr;
  }
  void expect_shape(const std::vector<Vec3>& expected, double tolerance = 0x1p-49) const {
    for (std::size_t v = 0; v < expected.size(); ++v) {
      const Vec3& actual = geometry->deforming_object().vertices()[geometry->new_vertex()[v]];
      ASSERT_LE((actual - geometry->to_local(expected[v])).norm(), tolerance) << v;
      for (int k = 0; k < 3; ++k) ASSERT_EQ(std::ldexp(actual[k], 51), std::rint(std::ldexp(actual[k], 51))) << "on the grid";
    }
  }

  std::shared_ptr<const TriangleMesh> mesh;
  std::unique_ptr<TouchGeometry> geometry;
  std::unique_ptr<ShapeStager> stager;
  std::unique_ptr<StreamedGeometry> surface;
};

std::vector<Vec3> between(const std::vector<Vec3>& a, const std::vector<Vec3>& b, double share) {
  std::vector<Vec3> shape;
  for (std::size_t v = 0; v < a.size(); ++v) shape.push_back(a[v] + share * (b[v] - a[v]));
  return shape;
}

TEST(StreamedGeometry, GoesStraightFromEachShapeToTheNext) {
  const StreamedObject object(made::sphere(0.05, 12, 0.05));
  const auto rest = object.mesh->vertices;
  const auto wide = object.mapped_vertices([](const Vec3& p) { return Vec3(1.2 * p); });
  const auto bent = object.mapped_vertices([](const Vec3& p) { return Vec3(p + Vec3(0, 0.3 * p.z(), 0.1 * std::fabs(p.x()))); });
  object.expect_shape(rest);
  (void)object.surface->offer(object.stage_to(wide), 0.5, 1.0);
  EXPECT_EQ(object.surface->end_s(), 1.5);
  EXPECT_FALSE(object.surface->is_due(0.9));
  EXPECT_TRUE(object.surface->is_due(1.0));
  for (const double share : {0.0, 0.3, 0.55, 1.0}) {
    object.surface->shape(1.0 + 0.5 * share);
    object.expect_shape(between(rest, wide, share));
    const auto computed = object.surface->vertices_at(1.0 + 0.5 * share);
    for (std::size_t v = 0; v < rest.size(); ++v) ASSERT_LE((computed[v] - between(rest, wide, share)[v]).norm(), 1e-16) << v;
  }
  EXPECT_EQ(object.surface->serial(), 1U);
  EXPECT_GT(object.surface->present().trees.size(), 1U);
  // The next stage begins exactly where the one before has ended.
  const std::vector<Vec3> end(object.geometry->deforming_object().vertices().begin(), object.geometry->deforming_object().vertices().end());
  const auto released = object.surface->offer(object.stage_to(bent), 0.2, 1.5);
  EXPECT_NE(released.ended, nullptr);
  EXPECT_EQ(released.replaced, nullptr);
  object.surface->shape(1.5);
  EXPECT_EQ(object.surface->serial(), 2U);
  const auto now = object.geometry->deforming_object().vertices();
  EXPECT_TRUE(std::equal(end.begin(), end.end(), now.begin(), now.end())) << "to the last bit";
  object.surface->shape(1.65);
  object.expect_shape(between(wide, bent, (1.65 - 1.5) / 0.2));
  object.surface->shape(9.0);
  object.expect_shape(bent);
}

// The stage before the present one is kept until it is replaced: vertices moved in it.
TEST(StreamedGeometry, CountsTheMemoryOfAllItsStages) {
  const StreamedObject object(made::sphere(0.05, 12, 0.05));
  const auto wide = object.mapped_vertices([](const Vec3& p) { return Vec3(1.2 * p); });
  const auto bytes_of = [](const ShapeStage& stage) {
    std::size_t bytes = (stage.begin.size() + stage.to.size()) * sizeof(Vec3);
    bytes += (stage.begin_local.size() + stage.motion_local.size()) * sizeof(double);
    for (const WideBvh& tree : stage.trees) bytes += tree.bytes();
    return bytes;
  };
  const std::size_t rest_bytes = bytes_of(object.surface->present()) + object.surface->present().begin_local.size() * sizeof(double);
  EXPECT_GE(object.surface->bytes(), rest_bytes);
  EXPECT_LT(object.surface->bytes(), rest_bytes + rest_bytes / 4);
  auto next = object.stage_to(wide);
  const std::size_t both_bytes = rest_bytes + bytes_of(*next);
  (void)object.surface->offer(std::move(next), 0.5, 1.0);
  for (const double time_s : {0.5, 1.2}) {
    object.surface->shape(time_s);
    EXPECT_GE(object.surface->bytes(), both_bytes) << time_s;
    EXPECT_LT(object.surface->bytes(), both_bytes + both_bytes / 4) << time_s;
  }
}

// The vertices have a constant speed in both stages, wherever the samples are relative to the moment at which the stages change.
TEST(StreamedGeometry, KnowsHowFarAVertexMovedAlsoWhereAStageEndsBetween) {
  const StreamedObject object(made::sheet(0.05, 0.0, 4));
  const auto raised_by = [&](double by) { return object.mapped_vertices([by](const Vec3& p) { return Vec3(p + Vec3(0, 0, by)); }); };
  (void)object.surface->offer(object.stage_to(raised_by(0.005)), 0.1, 0.0);
  object.surface->shape(0.05);
  (void)object.surface->offer(object.stage_to(raised_by(0.01)), 0.1, 0.1);
  double before_s = 0.05;
  for (const double time_s : {0.07, 0.09, 0.113, 0.15, 0.2}) {
    object.surface->shape(time_s);
    const Vec3 moved = object.geometry->unit_m() * object.surface->displacement_between(0, before_s, time_s);
    EXPECT_NEAR(moved.z(), 0.05 * (time_s - before_s), 1e-15) << time_s;
    before_s = time_s;
  }
}

// A sample may be corrected after another stage was appended.
TEST(StreamedGeometry, KnowsHowFarAVertexMovedAlsoAfterTheStageThatEndedWasReturned) {
  const StreamedObject object(made::sheet(0.05, 0.0, 4));
  const auto raised_by = [&](double by) { return object.mapped_vertices([by](const Vec3& p) { return Vec3(p + Vec3(0, 0, by)); }); };
  const auto offer = [&](double height_m, double start_s) {
    auto stage = object.stager->make(object.surface->present().to, raised_by(height_m));
    return object.surface->offer(std::move(*stage), 0.1, start_s);
  };
  (void)offer(0.005, 0.0);
  object.surface->shape(0.05);
  for (int n = 1; n <= 4; ++n) {
    const double end_s = 0.1 * n;
    (void)offer(0.005 + 0.005 * n, end_s);
    object.surface->shape(end_s + 0.03);
    EXPECT_NE(offer(0.0, 9.0).ended, nullptr);
    const Vec3 moved = object.geometry->unit_m() * object.surface->displacement_between(0, end_s - 0.01, end_s + 0.03);
    EXPECT_NEAR(moved.z(), 0.05 * 0.04, 1e-15) << n;
  }
}

TEST(StreamedGeometry, TheNewestWaitingStageComesNext) {
  const StreamedObject object(made::sheet(0.05, 0.0, 4));
  const auto up = object.mapped_vertices([](const Vec3& p) { return Vec3(p + Vec3(0, 0, 0.01)); });
  const auto down = object.mapped_vertices([](const Vec3& p) { return Vec3(p - Vec3(0, 0, 0.02)); });
  EXPECT_EQ(object.surface->offer(object.stage_to(up), 1.0, 0.0).replaced, nullptr);
  auto to_down = object.stager->make(object.surface->present().to, down);
  EXPECT_NE(object.surface->offer(std::move(*to_down), 1.0, 0.0).replaced, nullptr);
  EXPECT_EQ(object.surface->waiting(), 1U);
  object.surface->shape(0.5);
  object.expect_shape(between(object.mesh->vertices, down, 0.5));
}

// Several stages wait, each for its start; after a step that passes several starts, the last of these stages is present. Each append()
// returns at most one stage that is no longer used, and only a limited number of stages is kept.
TEST(StreamedGeometry, SeveralStagesMayWaitEachForItsStart) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    std::mt19937_64 random(seed);
    const StreamedObject object(made::sheet(0.05, 0.0, 4));
    std::vector<std::vector<Vec3>> shapes = {object.mesh->vertices};
    std::vector<std::pair<double, double>> times = {{0.0, 0.0}};  // start and end of the stage that leads to each shape
    std::size_t returned = 0;
    double time_s = 0.0;
    for (int n = 0; n < 400; ++n) {
      while (object.surface->waiting() < StreamedGeometry::kMaxWaiting && random() % 4 != 0) {
        const double height = 1e-3 * static_cast<double>(random() % 20);
        shapes.push_back(object.mapped_vertices([&](const Vec3& p) { return Vec3(p + Vec3(0.1 * height, 0, height)); }));
        const double start_s = std::max(times.back().second, time_s) + 0.01 * static_cast<double>(random() % 3);
        const double duration_s = 0.01 * static_cast<double>(1 + random() % 5);
        returned += object.surface->append(object.stage_to(shapes.back()), duration_s, start_s) != nullptr ? 1 : 0;
        times.emplace_back(start_s, start_s + duration_s);
        EXPECT_DOUBLE_EQ(object.surface->end_s(), times.back().second);
      }
      const auto before = object.geometry->to_scene(object.geometry->deforming_object().vertices()[0]);
      time_s += 0.001 * static_cast<double>(random() % 60);
      const double bound_m = object.surface->travel_to(time_s);
      random() % 3 == 0 ? object.surface->skip_to(time_s) : object.surface->shape(time_s);
      std::size_t present = 0;
      while (present + 1 < times.size() && times[present + 1].first <= time_s) ++present;
      const double share =
          present == 0 ? 1.0 : std::min(1.0, (time_s - times[present].first) / (times[present].second - times[present].first));
      const auto expected = between(shapes[present == 0 ? 0 : present - 1], shapes[present], share);
      const auto computed = object.surface->vertices_at(time_s);
      for (std::size_t v = 0; v < expected.size(); ++v) ASSERT_LE((computed[v] - expected[v]).norm(), 1e-15) << n;
      EXPECT_EQ(object.surface->serial(), present) << n;
      object.surface->shape(time_s);
      object.expect_shape(expected, 0x1p-47);
      const auto after = object.geometry->to_scene(object.geometry->deforming_object().vertices()[0]);
      EXPECT_LE((after - before).norm(), bound_m + 1e-12) << n;
    }
    // Kept are the present stage and at most kMaxWaiting others, which wait or have not been returned yet.
    EXPECT_LE(shapes.size() - returned, StreamedGeometry::kMaxWaiting + 1);
    EXPECT_GT(shapes.size(), 300U);
  }
}

// travel_to() bounds how far each vertex is from where the geometry has it, whatever the time and the stages between.
TEST(StreamedGeometry, BoundsHowFarItTravels) {
  const StreamedObject object(made::sheet(0.05, 0.0, 4));
  const auto up = object.mapped_vertices([](const Vec3& p) { return Vec3(p + Vec3(0, 0, 0.01)); });
  const auto tilted = object.mapped_vertices([](const Vec3& p) { return Vec3(p + Vec3(0, 0, 0.2 * p.x())); });
  (void)object.surface->offer(object.stage_to(up), 1.0, 0.0);
  EXPECT_NEAR(object.surface->travel_to(0.5), 0.005, 1e-9);
  object.surface->skip_to(0.5);
  (void)object.surface->offer(object.stage_to(tilted), 1.0, 0.5);
  const auto before = object.surface->vertices_at(0.0);
  EXPECT_NEAR(object.surface->travel_to(0.5), 0.005, 1e-9) << "of the shape in the geometry, which is still that at rest";
  for (const double time : {0.7, 1.0, 1.4, 2.5}) {
    double farthest = 0.0;
    const auto now = object.surface->vertices_at(time);
    for (std::size_t v = 0; v < now.size(); ++v) farthest = std::max(farthest, (now[v] - before[v]).norm());
    EXPECT_GE(object.surface->travel_to(time), farthest - 1e-15) << time;
  }
  object.surface->skip_to(1.1);
  EXPECT_EQ(object.surface->serial(), 2U);
  EXPECT_NEAR(object.surface->travel_to(1.0), 0.01, 1e-9);
  object.surface->shape(1.5);
  EXPECT_EQ(object.surface->travel_to(1.5), 0.0);
  object.expect_shape(between(up, tilted, 0.5));
}

// Brute force: every triangle near a query point is found, whichever of the trees is in use.
TEST(StreamedGeometry, FindsEveryTriangleAtEachTime) {
  const StreamedObject object(made::sphere(0.05, 12, 0.05));
  std::mt19937_64 random(9);
  SCOPED_TRACE("seed 9");
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  double time = 0.0;
  for (int stage = 0; stage < 12; ++stage) {
    const Vec3 by = 0.01 * Vec3(unit(random), unit(random), unit(random));
    const double wide = 1.0 + 0.2 * unit(random);
    (void)object.surface->offer(object.stage_to(object.mapped_vertices([&](const Vec3& p) { return Vec3(wide * p + by); })), 1.0, time);
    for (int i = 0; i < 30; ++i) {
      time += 0.04;
      object.surface->shape(time);
      const auto triangles = static_cast<std::uint32_t>(object.mesh->triangles.size());
      expect_found_in_trees(*object.geometry, triangles, Vec3(unit(random), unit(random), unit(random)));
    }
  }
  EXPECT_GE(object.surface->serial(), 11U);
}

TEST(ShapeStager, RejectsInvalidShapes) {
  const StreamedObject object(made::sheet(0.05, 0.0, 4));
  const auto reject = [&](const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
    const auto made = object.stager->make(from, to);
    EXPECT_FALSE(made);
    return made ? std::string() : made.error().what;
  };
  const auto rest = object.mesh->vertices;
  auto fewer = rest;
  fewer.pop_back();
  EXPECT_THAT(reject(rest, fewer), HasSubstr("24 vertices were given; the mesh has 25"));
  auto broken = rest;
  broken[7].y() = std::nan("");
  EXPECT_THAT(reject(rest, broken), HasSubstr("vertex 7 has a number that is not finite"));
  auto far = rest;
  far[3].z() += 1.001 * kReach;
  EXPECT_THAT(reject(rest, far), HasSubstr("vertex 3 is 0.03003 m from where it is at rest; the largest distance is the reach, 0.03 m"));
  auto at_reach = rest;
  at_reach[3].z() += kReach;
  EXPECT_TRUE(object.stager->make(rest, at_reach));
  // The vertices on both sides of the middle line are moved onto it, so that the triangles between them lose their area.
  auto flat = rest;
  for (Vec3& p : flat) p.x() = std::fabs(p.x()) < 0.01 ? 0.0 : p.x() - std::copysign(0.025, p.x());
  EXPECT_THAT(reject(rest, flat), HasSubstr("at its end "));
}

// The shapes at both ends are valid, but half-way between them the two sheets lie in one plane.
TEST(ShapeStager, ChecksTheShapeHalfWay) {
  TriangleMesh sheets = made::sheet(0.02, 0.0, 4);
  const TriangleMesh above = made::sheet(0.015, 0.005, 4);
  const auto shift = static_cast<std::uint32_t>(sheets.vertices.size());
  sheets.vertices.insert(sheets.vertices.end(), above.vertices.begin(), above.vertices.end());
  for (const Triangle& t : above.triangles) sheets.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  const StreamedObject object(std::move(sheets));
  auto through = object.mesh->vertices;
  for (std::size_t v = shift; v < through.size(); ++v) through[v].z() -= 0.010;
  const auto made = object.stager->make(object.mesh->vertices, through);
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().what, HasSubstr("half-way 64 of its 64 triangles touch or nearly touch"));
}

}  // namespace
}  // namespace hapton
