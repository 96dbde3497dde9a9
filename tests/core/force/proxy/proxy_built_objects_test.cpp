// A proxy on objects that were built before, of which one has moved, feels what it feels on objects that it builds itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/collision/marked_objects.h"
#include "core/force/proxy/proxy_method.h"
#include "core/force/reference/reference_method.h"
#include "core/geometry/mesh_shapes.h"
#include "core/math/rotation_vector.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr unsigned kBuiltSeed = 22418;

struct MovedScene {
  explicit MovedScene(double size_m, std::optional<double> crease_rad = std::nullopt) : size(size_m), shading_crease_rad(crease_rad) {
    const std::vector<TriangleMesh> shapes = {scaled_and_moved(make_box({0.2, 0.2, 0.02}, 6), 1.0, {0.0, 0.0, -0.01}),
                                              scaled_and_moved(make_box({0.04, 0.04, 0.04}, 3), 1.0, {0.0, 0.0, 0.02}),
                                              scaled_and_moved(make_bumpy_sphere(0.03, 0.1, 300, 5), 1.0, {0.05, 0.05, 0.06})};
    for (const TriangleMesh& shape : shapes) scene.objects.push_back({shared(scaled_and_moved(shape, size, Vec3::Zero())), Material()});
    scene.objects[0].material = {.stiffness_n_per_m = 900.0, .friction_static = 0.5, .friction_dynamic = 0.3};
    for (const TouchObject& object : scene.objects) {
      for (const Vec3& v : object.mesh->vertices) whole_bounds.grow(v);
    }
    frame = TouchGeometry::frame_of(whole_bounds);
    for (std::size_t o = 0; o < 3; ++o) build(o);
    cube_at_rest = scene.objects[1].mesh;
  }

  static std::shared_ptr<const TriangleMesh> shared(TriangleMesh mesh) { return std::make_shared<const TriangleMesh>(std::move(mesh)); }

  void build(std::size_t o) {
    std::vector<std::shared_ptr<const TriangleMesh>> meshes;
    for (const TouchObject& object : scene.objects) meshes.push_back(object.mesh);
    Box box;
    for (const Vec3& v : meshes[o]->vertices) box.grow(v);
    unmarked.resize(3);
    bounds.resize(3);
    bounds[o] = TouchGeometry::local_bounds(frame, box);
    unmarked[o] = std::make_shared<const ObjectGeometry>(
        ObjectGeometry::make(*meshes[o], frame, TouchGeometry::most_triangles(meshes), shading_crease_rad));
  }
  // Moves the cube from its rest pose. by: in multiples of `size`.
  void move(const Vec3& turn, const Vec3& by) {
    const Quat rotation = turn_by(turn);
    TriangleMesh moved = *cube_at_rest;
    for (Vec3& v : moved.vertices) v = rotation * v + size * by;
    scene.objects[1].mesh = shared(std::move(moved));
    build(1);
  }
  TouchScene with_built() {
    auto built = std::make_shared<BuiltObjects>();
    built->frame = frame;
    built->shading_crease_rad = shading_crease_rad;
    for (const TouchObject& object : scene.objects) built->meshes.push_back(object.mesh);
    built->bounds = bounds;
    built->objects = marked.update(unmarked, bounds);
    TouchScene all = scene;
    all.built = built;
    return all;
  }
  // For a method that builds its own objects. The frame is the same if the cube lies within the scene as it was at first.
  TouchScene without_built() const {
    TouchScene all = scene;
    all.part_of = whole_bounds;
    return all;
  }

  double size;
  std::optional<double> shading_crease_rad;
  TouchScene scene;
  Box whole_bounds;
  LocalFrame frame;
  std::shared_ptr<const TriangleMesh> cube_at_rest;
  std::vector<std::shared_ptr<const ObjectGeometry>> unmarked;
  std::vector<Box> bounds;
  MarkedObjects marked;
};

std::unique_ptr<ProxyMethod> proxy_over(const MethodSettings& settings, const TouchScene& scene) {
  auto made = ProxyMethod::make(settings, scene);
  EXPECT_TRUE(made) << made.error().what;
  return std::unique_ptr<ProxyMethod>(static_cast<ProxyMethod*>(made->release()));
}

// A hand that wanders about the cube, through surfaces and back.
struct Hand {
  std::mt19937_64& random;
  Vec3 at;
  Vec3 centre;
  double size;

  const Vec3& next() {
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> exponent(-6.0, -2.0);
    const double length = size * std::pow(10.0, exponent(random));
    const Vec3 by(normal(random), normal(random), normal(random));
    at += length * by;
    const Vec3 off = at - centre;
    if (off.norm() > 0.05 * size) at = centre + off * (0.05 * size / off.norm());
    return at;
  }
};

// Where the cube goes: onto the plate, near it or into it, into the bumpy sphere, above the plate.
Vec3 draw_place(std::mt19937_64& random, int n) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const double x = 0.06 * uniform(random);
  const double y = 0.06 * uniform(random);
  switch (n % 4) {
    case 0:
      return {x, y, 0.0};
    case 1:
      return {x, y, 0.01 * uniform(random)};
    case 2:
      return {0.05, 0.05, 0.035};
    default:
      return {x, y, 0.025};
  }
}

TEST(ProxyOnBuiltObjects, FeelsTheSameToTheBitAsOnObjectsBuiltAnew) {
  std::mt19937_64 random(kBuiltSeed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int contacts = 0;
  for (const double size : {1.0, 1e-6, 1e6}) {
    for (int n = 0; n < 24; ++n) {
      SCOPED_TRACE(testing::Message() << "seed " << kBuiltSeed << ", size " << size << ", place " << n);
      MethodSettings settings;
      settings.probe_radius_m = n % 3 == 1 ? 0.002 * size : 0.0;
      settings.shading = n % 5 == 2 ? 0.5 : 0.0;
      MovedScene scene(size, ProxyMethod::shading_crease_rad(settings));
      // It is called again below, so that what it keeps of the scene before is used.
      (void)scene.with_built();
      const Vec3 place = draw_place(random, n);
      scene.move({0.0, 0.0, n % 4 == 3 ? 0.3 * uniform(random) : 0.0}, place);
      const auto built = proxy_over(settings, scene.with_built());
      const auto anew = proxy_over(settings, scene.without_built());
      ASSERT_EQ(built->geometry().unit_m(), anew->geometry().unit_m());
      ASSERT_EQ(built->geometry().origin(), anew->geometry().origin());
      ASSERT_EQ(built->geometry().frame().origin, scene.frame.origin);
      const Vec3 centre = size * (place + Vec3(0.0, 0.0, 0.03));
      Hand hand{random, centre + Vec3(0.0, 0.0, 0.05 * size), centre, size};
      built->reset(hand.at);
      anew->reset(hand.at);
      for (int step = 0; step < 1500; ++step) {
        const MethodInput input{.p_SD = hand.next()};
        const MethodOutput one = built->step(input);
        const MethodOutput other = anew->step(input);
        ASSERT_EQ(one.force_n, other.force_n) << step;
        ASSERT_EQ(one.p_SP, other.p_SP) << step;
        ASSERT_EQ(one.object, other.object) << step;
        contacts += one.contact ? 1 : 0;
      }
    }
  }
  EXPECT_GT(contacts, 10'000);
}

// Compared with the brute-force twin, the reference, which keeps no local frame of an earlier scene.
TEST(ProxyOnBuiltObjects, AgreesWithTheReferenceWhereverTheCubeIsPutDown) {
  std::mt19937_64 random(kBuiltSeed + 1);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int contacts = 0;
  for (int n = 0; n < 12; ++n) {
    SCOPED_TRACE(testing::Message() << "seed " << kBuiltSeed + 1 << ", place " << n);
    MovedScene scene(1.0);
    scene.scene.objects[0].material = Material();
    // Also a place beyond the scene as it was at first, whose frame is kept.
    const Vec3 place = n % 4 == 3 ? Vec3(0.1, -0.1, 0.09) : draw_place(random, n);
    scene.move({0.0, 0.0, 0.3 * uniform(random)}, place);
    const auto built = proxy_over({}, scene.with_built());
    MethodSettings reference_settings;
    reference_settings.name = "reference";
    const auto reference = make_method(reference_settings, scene.scene).value();
    Vec3 at = place + Vec3(0.003, 0.002, 0.05);
    built->reset(at);
    reference->reset(at);
    for (int step = 0; step < 200; ++step) {
      // Down onto the upper face, and along it beyond the edge.
      at += step < 60 ? Vec3(0.0, 0.0, -0.0002) : Vec3(0.00015, 0.00005, 0.0);
      const MethodOutput felt = built->step({.p_SD = at});
      const MethodOutput expected = reference->step({.p_SD = at});
      ASSERT_LT((felt.force_n - expected.force_n).norm(), 1e-5 * (1.0 + expected.force_n.norm())) << step;
      contacts += felt.contact ? 1 : 0;
    }
  }
  EXPECT_GT(contacts, 600);
}

TEST(ProxyOnBuiltObjects, SharesWhatWasBuilt) {
  MovedScene scene(1.0);
  const TouchScene first = scene.with_built();
  const auto before = proxy_over({}, first);
  scene.move(Vec3::Zero(), {0.03, 0.0, 0.0});
  const TouchScene second = scene.with_built();
  const auto after = proxy_over({}, second);
  EXPECT_EQ(&after->geometry().object_geometry(2), &before->geometry().object_geometry(2)) << "near no other object";
  EXPECT_NE(&after->geometry().object_geometry(0), &before->geometry().object_geometry(0)) << "other marks under the cube";
  EXPECT_NE(&after->geometry().object_geometry(1), &before->geometry().object_geometry(1));
}

TEST(ProxyOnBuiltObjects, BuildsItsOwnWhereTheyAreOfOtherMeshesOrNormals) {
  MovedScene scene(1.0);
  TouchScene stale = scene.with_built();
  scene.move(Vec3::Zero(), {0.03, 0.0, 0.0});
  stale.objects[1].mesh = scene.scene.objects[1].mesh;
  const auto built = proxy_over({}, stale);
  const auto anew = proxy_over({}, scene.scene);
  const Vec3 from(0.03, 0.0, 0.05);
  const Vec3 to(0.03, 0.0, 0.039);
  for (const auto* method : {&built, &anew}) (*method)->reset(from);
  const MethodOutput felt = built->step({.p_SD = to});
  EXPECT_EQ(felt.object, 1);
  EXPECT_EQ(felt.force_n, anew->step({.p_SD = to}).force_n);
  MethodSettings shaded;
  shaded.shading = 1.0;
  const auto smooth = proxy_over(shaded, scene.with_built());
  EXPECT_GT(smooth->geometry().bytes(), proxy_over({}, scene.with_built())->geometry().bytes()) << "with normals";
}

TEST(ProxyOnBuiltObjects, AStepUsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  std::mt19937_64 random(kBuiltSeed + 2);
  MovedScene scene(1.0);
  scene.move(Vec3::Zero(), {0.03, 0.0, 0.0});
  const auto built = proxy_over({}, scene.with_built());
  Hand hand{random, {0.03, 0.0, 0.07}, {0.03, 0.0, 0.03}, 1.0};
  const AllocationGuard guard;
  built->reset(hand.at);
  for (int step = 0; step < 2000; ++step) built->step({.p_SD = hand.next()});
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
