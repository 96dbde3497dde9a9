#include "core/force/smooth/smooth_method.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <deque>
#include <functional>
#include <memory>
#include <random>
#include <thread>
#include <vector>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"
#include "tests/support/obj_mesh.h"

namespace hapton {
namespace {

// The VCP stands a billionth of the scene's size off the surface: so much for what is exact otherwise, in newtons and metres here.
constexpr double kHoverForce = 1e-6;
constexpr double kHover = 1e-9;
constexpr double kPi = 3.14159265358979323846;

TouchScene scene_of(const TriangleMesh& mesh, const Material& material = {}) {
  TouchScene scene;
  scene.objects.push_back({made::shared(mesh), material});
  return scene;
}

std::unique_ptr<SmoothMethod> make(const TouchScene& scene, SmoothMethod::Settings settings = {}) {
  auto method = SmoothMethod::make_with(settings, scene);
  EXPECT_TRUE(method) << (method ? "" : method.error().what);
  return method ? std::move(*method) : nullptr;
}

SmoothMethod::Settings with_size(std::uint32_t set_size, double layer = 0.0) {
  SmoothMethod::Settings settings;
  settings.set_size = set_size;
  settings.layer = layer;
  return settings;
}

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

// A hand that wanders over and into a mesh: towards a random place on it, about that place, out again. Some steps are tiny, some long.
std::vector<Vec3> wander(const TriangleMesh& mesh, std::uint64_t seed, int steps) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto direction = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  Vec3 low = mesh.vertices[0];
  Vec3 high = low;
  for (const Vec3& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  const double size = (high - low).norm();
  std::vector<Vec3> way = {high + 0.1 * (high - low)};
  Vec3 goal = way[0];
  for (int i = 1; i < steps; ++i) {
    if (i % 150 == 1) goal = mesh.corner(random() % mesh.triangles.size(), 0) + 0.02 * size * direction();
    if (i % 600 == 500) goal = high + 0.1 * size * direction();
    Vec3 step = 0.05 * (goal - way.back()) + 2e-4 * size * direction();
    if (i % 37 == 0) step *= 1e-6;
    way.push_back(way.back() + step);
  }
  return way;
}

std::unique_ptr<ForceMethod> make_told(const TouchScene& scene, double crease_deg, double simplify_m) {
  auto method = SmoothMethod::make({.crease_deg = crease_deg, .simplify_m = simplify_m}, scene);
  EXPECT_TRUE(method) << (method ? "" : method.error().what);
  return method ? std::move(*method) : nullptr;
}

TEST(SmoothMethod, FewerTrianglesChangeTheForceByNoMoreThanTheBoundExplains) {
  constexpr double kBound = 2e-4;
  constexpr double kStiffness = 1000.0;
  constexpr unsigned kSeed = 12;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  const TouchScene scene = scene_of(make_icosphere(0.05, 5), {.stiffness_n_per_m = kStiffness});
  const auto all = make_told(scene, 40.0, 0.0);
  const auto fewer = make_told(scene, 40.0, kBound);
  const auto faces = [](const ForceMethod& method) { return dynamic_cast<const SmoothMethod&>(method).scene().surface(0).face_count; };
  EXPECT_LT(faces(*fewer), faces(*all) / 4);
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 300; ++i) {
    const Vec3 out = Vec3(normal(random), normal(random), normal(random)).normalized();
    MethodOutput expected;
    MethodOutput felt;
    all->reset(0.051 * out);
    fewer->reset(0.051 * out);
    for (int step = 1; step <= 30; ++step) {
      const Vec3 P = (0.051 - 1e-4 * step) * out;
      expected = all->step({.p_SD = P});
      felt = fewer->step({.p_SD = P});
    }
    ASSERT_GT(expected.force_n.norm(), 1.9);
    EXPECT_NEAR(felt.force_n.norm(), expected.force_n.norm(), kStiffness * kBound);
  }
}

TEST(SmoothMethod, TheCreaseAngleRoundsABoxesEdges) {
  const TouchScene scene = scene_of(make_box(Vec3::Constant(0.1), 8));
  const auto press_near_edge = [&](double crease_deg) {
    const auto method = make_told(scene, crease_deg, 0.0);
    MethodOutput felt;
    method->reset(Vec3(0.048, 0.001, 0.052));
    for (int i = 0; i <= 30; ++i) felt = method->step({.p_SD = Vec3(0.048, 0.001, 0.052 - 1e-4 * i)});
    return felt.force_n;
  };
  EXPECT_LT(angle_between(press_near_edge(40.0), Vec3::UnitZ()), 1e-6);
  EXPECT_GT(angle_between(press_near_edge(120.0), Vec3::UnitZ()), 0.3);
}

TEST(SmoothMethod, PressingAPlaneGivesHookesLaw) {
  const auto method = make(scene_of(make_plane_grid(0.1, 20), {.stiffness_n_per_m = 700.0}));
  method->reset(Vec3(0.0013, 0.0021, 0.004));
  for (int i = 0; i <= 100; ++i) {
    const Vec3 P(0.0013 + 1e-4 * i, 0.0021, 0.004 - 6e-5 * i);
    const MethodOutput felt = method->step({.p_SD = P});
    if (P.z() > 1e-6) {
      EXPECT_TRUE(felt.force_n.isZero(0.0));
      EXPECT_FALSE(felt.contact);
      EXPECT_EQ(felt.p_SP, P);
    } else if (P.z() < -1e-6) {
      EXPECT_LT((felt.force_n - Vec3(0, 0, -700.0 * P.z())).norm(), kHoverForce) << i;
      EXPECT_LT((felt.p_SP - Vec3(P.x(), P.y(), 0)).norm(), kHover);
      EXPECT_TRUE(felt.contact);
    }
  }
  EXPECT_EQ(method->counters().entries, 1U);
}

TEST(SmoothMethod, APlaneIsTouchedFromEitherSideUnlessOneSided) {
  for (const bool two_sided : {true, false}) {
    const auto method = make(scene_of(make_plane_grid(0.1, 20), {.two_sided = two_sided}));
    for (const double side : {1.0, -1.0}) {
      method->reset(Vec3(0.001, 0.002, side * 0.001));
      const MethodOutput felt = method->step({.p_SD = Vec3(0.001, 0.002, -side * 0.002)});
      const double expected = two_sided || side > 0.0 ? side * 2.0 : 0.0;
      EXPECT_NEAR(felt.force_n.z(), expected, kHoverForce);
    }
  }
}

// Inside a sphere the force is radial far closer than the facets are, and turns as evenly as the probe goes round: no bouncing across
// edges.
TEST(SmoothMethod, InsideASphereTheForceIsRadialAndEven) {
  constexpr double kRadius = 0.05;
  const TriangleMesh mesh = make_icosphere(kRadius, 3);
  const auto method = make(scene_of(mesh));
  double facet_error = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 n = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
    for (int k = 0; k < 3; ++k) facet_error = std::max(facet_error, angle_between(n, mesh.corner(t, k)));
  }
  method->reset(Vec3(kRadius * 1.1, 0, 0));
  constexpr int kSteps = 20000;
  Vec3 last;
  Vec3 last_P;
  double worst = 0.0;
  double worst_turn = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double a = 2.0 * kPi * i / kSteps;
    const Vec3 P = (kRadius - 0.0015) * Vec3(std::cos(a), 0.8 * std::sin(a), 0.6 * std::sin(a));
    const MethodOutput felt = method->step({.p_SD = P});
    ASSERT_TRUE(felt.contact) << "fell through at step " << i;
    worst = std::max(worst, angle_between(felt.force_n, P));
    if (i > 0) worst_turn = std::max(worst_turn, angle_between(felt.force_n, last) / angle_between(P, last_P));
    last = felt.force_n;
    last_P = P;
    EXPECT_NEAR(felt.force_n.norm(), 1.5, 0.5);
  }
  EXPECT_LT(worst, 0.3 * facet_error);
  EXPECT_LT(worst_turn, 3.0);
  EXPECT_EQ(method->counters().entries, 1U);
}

// With a layer the force builds up before the surface and goes on building up behind it, without a step on the surface.
TEST(SmoothMethod, TheLayerIsContinuousThroughTheSurface) {
  for (const TriangleMesh& mesh : {make_icosphere(0.05, 3), make_box(Vec3(0.07, 0.07, 0.07), 3)}) {
    SmoothMethod::Settings settings;
    settings.layer = 1.0;
    const auto method = make(scene_of(mesh), settings);
    const Vec3 inward = -Vec3(0.3, 0.25, 1.0).normalized();
    const double from = 0.053;
    method->reset(-from * inward);
    double last = 0.0;
    Vec3 last_P = -from * inward;
    bool began = false;
    constexpr double kStep = 2e-6;
    for (double way = kStep; way < from - 0.03; way += kStep) {
      const Vec3 P = -(from - way) * inward;
      const double force = method->step({.p_SD = P}).force_n.norm();
      EXPECT_LE(std::fabs(force - last), 1000.0 * kStep * 1.6) << "at " << P.transpose();
      if (force > 0.0) began = true;
      if (began) {
        EXPECT_GT(force, 0.0);
      }
      last = force;
      last_P = P;
    }
    EXPECT_GT(last, 1000.0 * method->radius_m());
    EXPECT_EQ(method->counters().entries, 1U);
  }
}

// What makes the exchange of sets imperceptible: any set that reaches far enough gives the force of all triangles, to the last bit.
TEST(SmoothMethod, ASetGivesTheForceOfAllTrianglesToTheLastBit) {
  struct Case {
    TriangleMesh mesh;
    double layer;
  };
  std::vector<Case> cases;
  cases.push_back({made::sphere(0.05, 16, 0.1), 0.0});
  cases.push_back({made::sphere(0.05, 16, 0.1), 1.0});
  cases.push_back({make_staircase(0.05, 4, 3), 1.0});
  cases.push_back({make_gutter(0.05, 0.02, 1.0, 4), 0.5});
  for (std::size_t c = 0; c < cases.size(); ++c) {
    const TouchScene scene = scene_of(cases[c].mesh);
    const std::vector<Vec3> way = wander(cases[c].mesh, 91 + c, 1200);
    const auto twin = make(scene, with_size(64, cases[c].layer));
    twin->use_all_triangles();
    std::vector<MethodOutput> expected;
    twin->reset(way[0]);
    int contacts = 0;
    for (const Vec3& P : way) {
      expected.push_back(twin->step({.p_SD = P}));
      contacts += expected.back().contact ? 1 : 0;
    }
    EXPECT_GT(contacts, 150);
    for (const std::uint32_t size : {24U, 64U, 256U}) {
      SmoothMethod::Settings settings = with_size(size, cases[c].layer);
      settings.radius_m = twin->radius_m();
      const auto method = make(scene, settings);
      method->reset(way[0]);
      for (std::size_t i = 0; i < way.size(); ++i) {
        const MethodOutput felt = method->step({.p_SD = way[i]});
        ASSERT_EQ(felt.force_n, expected[i].force_n) << "case " << c << " size " << size << " step " << i;
        ASSERT_EQ(felt.p_SP, expected[i].p_SP) << "case " << c << " size " << size << " step " << i;
      }
    }
  }
}

// A real mesh of open, creased, thin pieces, and sets far too small for RADIUS: still the same, and counted.
TEST(SmoothMethod, CorrectnessDoesNotDependOnTheSetsSize) {
  const TriangleMesh mesh = scaled_and_moved(made::obj_mesh("car_front_3300.obj"), 5e-5, Vec3::Zero());
  ASSERT_EQ(mesh.triangles.size(), 3300U);
  const TouchScene scene = scene_of(mesh);
  SmoothMethod::Settings settings = with_size(64);
  settings.radius_m = 0.003;
  const auto twin = make(scene, settings);
  twin->use_all_triangles();
  settings.set_size = 16;
  const auto method = make(scene, settings);
  const std::vector<Vec3> way = wander(mesh, 95, 400);
  twin->reset(way[0]);
  method->reset(way[0]);
  int contacts = 0;
  for (std::size_t i = 0; i < way.size(); ++i) {
    const MethodOutput expected = twin->step({.p_SD = way[i]});
    const MethodOutput felt = method->step({.p_SD = way[i]});
    ASSERT_EQ(felt.force_n, expected.force_n) << i;
    contacts += expected.contact ? 1 : 0;
  }
  EXPECT_GT(contacts, 30);
  EXPECT_GT(method->counters().overflows, 0U);
}

// Both tasks under a simulated clock: the slow one starts every `period` steps and its set arrives `latency` steps later. However late it
// is, the force is that of one task alone; how late it was shows in the counters.
TEST(SmoothMethod, TheSlowTaskMayBeLate) {
  const TriangleMesh mesh = made::sphere(0.05, 24, 0.1);
  const TouchScene scene = scene_of(mesh);
  const std::vector<Vec3> way = wander(mesh, 97, 3000);
  const auto alone = make(scene, with_size(64));
  std::vector<Vec3> expected;
  alone->reset(way[0]);
  for (const Vec3& P : way) expected.push_back(alone->step({.p_SD = P}).force_n);

  std::uint64_t late_when_quick = 0;
  std::uint64_t late_when_slow = 0;
  for (const auto& [period, latency] : {std::pair(1, 1), std::pair(4, 4), std::pair(10, 25), std::pair(100, 400)}) {
    const auto method = make(scene, with_size(64));
    method->reset(way[0]);
    std::deque<std::pair<std::size_t, std::unique_ptr<LocalSet>>> mail;
    for (std::size_t i = 0; i < way.size(); ++i) {
      if (i % static_cast<std::size_t>(period) == 0) {
        auto set = std::make_unique<LocalSet>();
        method->scene().select(method->wish(), method->set_size(), *set);
        mail.emplace_back(i + static_cast<std::size_t>(latency), std::move(set));
      }
      while (!mail.empty() && mail.front().first <= i) {
        method->offer(*mail.front().second);
        mail.pop_front();
      }
      ASSERT_EQ(method->step({.p_SD = way[i]}).force_n, expected[i]) << "period " << period << " latency " << latency << " step " << i;
    }
    if (latency == 1) {
      late_when_quick = method->counters().late;
      EXPECT_GT(method->counters().offered, 0U);
    }
    if (latency == 400) late_when_slow = method->counters().late;
  }
  EXPECT_LT(late_when_quick, 200U);
  EXPECT_GT(late_when_slow, late_when_quick);
}

// The two tasks as haptics_node runs them: prepare beside step. Here every tenth step, the period of the node's other thread at 1 kHz.
TEST(SmoothMethod, PrepareKeepsTheFastTaskFromSelecting) {
  const TriangleMesh mesh = make_bumpy_sphere(0.05, 0.05, 20000, 3);
  const auto at = [](int i) {
    const double a = 2e-3 * i;  // 94 mm/s
    return Vec3(0.047 * Vec3(std::cos(a), std::sin(a), 0.1 * std::sin(5.0 * a)));
  };
  const auto alone = make(scene_of(mesh));
  const auto with = make(scene_of(mesh));
  alone->reset(Vec3(0.07, 0, 0));
  with->reset(Vec3(0.07, 0, 0));
  for (int i = 0; i < 3000; ++i) {
    const Vec3 expected = alone->step({.p_SD = at(i)}).force_n;
    ASSERT_EQ(with->step({.p_SD = at(i)}).force_n, expected);
    if (i % 10 == 0) {
      while (with->prepare()) {
      }
    }
  }
  EXPECT_GT(with->counters().offered, 50U);
  EXPECT_LT(with->counters().selections, alone->counters().selections / 4);
}

// The paper at full strength (--layer 1) lives on the slow task's sets as well: a run in which none is offered fails here.
TEST(SmoothMethod, TheLayerLivesOnOfferedSets) {
  const TriangleMesh mesh = make_bumpy_sphere(0.05, 0.05, 20000, 3);
  auto told = SmoothMethod::make({.smooth_layer = kFdhPaperLayer}, scene_of(mesh));
  ASSERT_TRUE(told) << told.error().what;
  auto& method = dynamic_cast<SmoothMethod&>(**told);
  EXPECT_DOUBLE_EQ(method.layer_m(), method.radius_m());
  const auto alone = make(scene_of(mesh), with_size(64, kFdhPaperLayer));
  method.reset(Vec3(0.07, 0, 0));
  alone->reset(Vec3(0.07, 0, 0));
  int outside = 0;
  for (int i = 0; i < 3000; ++i) {
    const double a = 2e-3 * i;
    const Vec3 P = (0.0487 + 0.0025 * std::sin(0.02 * i)) * Vec3(std::cos(a), std::sin(a), 0.1 * std::sin(5.0 * a)).normalized();
    const MethodOutput felt = method.step({.p_SD = P});
    ASSERT_EQ(felt.force_n, alone->step({.p_SD = P}).force_n) << i;
    outside += felt.contact && !method.is_inside() ? 1 : 0;
    if (i % 10 == 0) {
      while (method.prepare()) {
      }
    }
  }
  EXPECT_GT(outside, 100) << "the layer is felt before the surface is reached";
  EXPECT_GT(method.counters().offered, 50U) << "no set ever came from the slow task";
  EXPECT_LT(method.counters().selections, alone->counters().selections / 2);
}

TEST(SmoothMethod, PrepareMayRunBesideStep) {
  const TriangleMesh mesh = made::sphere(0.05, 24, 0.1);
  const std::vector<Vec3> way = wander(mesh, 105, 4000);
  const auto alone = make(scene_of(mesh));
  const auto with = make(scene_of(mesh));
  alone->reset(way[0]);
  with->reset(way[0]);
  std::atomic<bool> stop = false;
  std::thread slow([&] {
    while (!stop.load()) {
      if (!with->prepare()) std::this_thread::yield();
    }
  });
  int differ = 0;
  do {  // a busy machine may let the other thread wait
    for (const Vec3& P : way) differ += with->step({.p_SD = P}).force_n != alone->step({.p_SD = P}).force_n ? 1 : 0;
  } while (with->counters().offered == 0);
  stop.store(true);
  slow.join();
  EXPECT_EQ(differ, 0);
  EXPECT_GT(with->counters().offered, 0U);
}

// The rate may change while running: time plays no part in this force, so going the same way in finer steps ends at the same force.
TEST(SmoothMethod, TheRateMayChangeWhileRunning) {
  const TriangleMesh mesh = make_icosphere(0.05, 4);
  const auto steady = make(scene_of(mesh));
  const auto changing = make(scene_of(mesh));
  const auto at = [](double t) { return Vec3(0.0485 * std::cos(t), 0.0485 * std::sin(t), 0.003 * std::sin(3.0 * t)); };
  steady->reset(Vec3(0.06, 0, 0));
  changing->reset(Vec3(0.06, 0, 0));
  std::mt19937_64 random(99);
  Vec3 last = Vec3::Zero();
  for (int i = 0; i < 1000; ++i) {
    const double t = 0.003 * i;
    const Vec3 expected = steady->step({.p_SD = at(t), .dt_s = 1e-3}).force_n;
    const int parts = std::array{1, 10, 3, 25}[random() % 4];
    Vec3 felt;
    for (int k = 1; k <= parts; ++k) {
      felt = changing->step({.p_SD = at(t - 0.003 * (parts - k) / parts * (i > 0 ? 1 : 0)), .dt_s = 1e-3 / parts}).force_n;
      if (i > 0) {
        EXPECT_LT((felt - last).norm(), 0.5) << "no pop when the rate changes";
      }
      last = felt;
    }
    EXPECT_LT((felt - expected).norm(), 1e-5) << i;
  }
}

TEST(SmoothMethod, ExchangingSetsCannotBeFelt) {
  const TriangleMesh mesh = make_bumpy_sphere(0.05, 0.05, 20000, 3);
  const auto method = make(scene_of(mesh), with_size(32));
  method->reset(Vec3(0.07, 0, 0));
  Vec3 last = Vec3::Zero();
  Vec3 last_P;
  std::uint64_t selections = 0;
  int exchanged = 0;
  double worst_exchanged = 0.0;
  double worst_kept = 0.0;
  for (int i = 0; i < 6000; ++i) {
    const double a = 0.5 * kPi * i / 6000.0;
    const Vec3 P = 0.0465 * Vec3(std::cos(a), std::sin(a), 0.1 * std::sin(5.0 * a));
    const Vec3 force = method->step({.p_SD = P}).force_n;
    if (i > 1) {
      const double jump = (force - last).norm() / (1000.0 * (P - last_P).norm());
      const bool is_new = method->counters().selections != selections;
      exchanged += is_new ? 1 : 0;
      (is_new ? worst_exchanged : worst_kept) = std::max(is_new ? worst_exchanged : worst_kept, jump);
    }
    selections = method->counters().selections;
    last = force;
    last_P = P;
  }
  EXPECT_GT(exchanged, 30);
  EXPECT_LT(worst_exchanged, std::max(2.0, 1.2 * worst_kept));
}

TEST(SmoothMethod, StepUsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP();
  const TriangleMesh mesh = made::sphere(0.05, 24, 0.1);
  for (const std::uint32_t size : {16U, 64U, 256U}) {
    const auto method = make(scene_of(mesh), with_size(size, 1.0));
    const std::vector<Vec3> way = wander(mesh, 101, 2000);
    method->reset(way[0]);
    auto set = std::make_unique<LocalSet>();
    const AllocationGuard guard;
    for (const Vec3& P : way) {
      method->step({.p_SD = P});
      method->scene().select(method->wish(), size, *set);
      method->offer(*set);
    }
    EXPECT_EQ(guard.count(), 0U);
    EXPECT_GT(method->counters().entries, 0U);
  }
}

// How often a closed surface goes round p: 1 inside, 0 outside.
double winding_number(const TriangleMesh& mesh, const Vec3& p) {
  double sum = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = mesh.corner(t, 0) - p;
    const Vec3 b = mesh.corner(t, 1) - p;
    const Vec3 c = mesh.corner(t, 2) - p;
    sum += std::atan2(a.dot(b.cross(c)), a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() + b.dot(c) * a.norm() + c.dot(a) * b.norm());
  }
  return sum / (2.0 * kPi);
}

// No step inside a closed mesh is without force, whatever the probe does; and none outside pulls it back from farther than it is deep.
TEST(SmoothMethod, NothingFallsThroughAClosedMesh) {
  const TriangleMesh wingnut = made::obj_mesh("wingnut.obj");
  const TriangleMesh fish = made::obj_mesh("fish_22k.obj");
  ASSERT_EQ(wingnut.triangles.size(), 6090U);
  int seed = 200;
  for (const TriangleMesh& mesh : {wingnut, fish, made::sphere(0.05, 24, 0.2), make_staircase(0.1, 5, 4), make_pit(0.1, 0.05),
                                   make_thin_wall(0.1, 0.002, 12), make_torus(0.05, 0.01, 40, 16)}) {
    const auto method = make(scene_of(mesh));
    const auto near = std::make_unique<LocalSet>();
    const double allowed = 0.0025 * method->scene().diagonal();
    const std::vector<Vec3> way = wander(mesh, static_cast<std::uint64_t>(seed++), 6000);
    method->reset(way[0]);
    int inside = 0;
    for (std::size_t i = 0; i < way.size(); ++i) {
      const MethodOutput felt = method->step({.p_SD = way[i]});
      ASSERT_TRUE(felt.force_n.allFinite());
      inside += felt.contact ? 1 : 0;
      if (felt.contact) continue;
      method->scene().select({way[i], way[i]}, 1, *near);
      ASSERT_FALSE(near->nearest > allowed && winding_number(mesh, way[i]) > 0.5) << "seed " << seed - 1 << " step " << i;
    }
    EXPECT_GT(inside, 500) << "seed " << seed - 1;
  }
}

// A plate thinner than the probe goes deep: the VCP's history keeps it on the side where it went in.
TEST(SmoothMethod, AThinPlateIsNotPushedThrough) {
  const auto method = make(scene_of(make_thin_wall(0.1, 0.0005, 20)));
  method->reset(Vec3(0.0013, 0.0021, 0.005));
  for (int i = 0; i < 3000; ++i) {
    const double depth = -0.005 + std::min(0.012, 1e-5 * i);
    const Vec3 P(0.0013 + 0.02 * std::sin(1e-3 * i), 0.0021 + 0.02 * std::sin(1.7e-3 * i), 0.00025 - depth);
    const MethodOutput felt = method->step({.p_SD = P});
    if (depth > 1e-6) {
      ASSERT_NEAR(felt.force_n.z(), 1000.0 * depth, 1e-6) << i;
    }
  }
}

// Round the outside of a box and off its edge: let go, and felt again from the next side.
TEST(SmoothMethod, LetsGoRoundAnEdge) {
  const auto method = make(scene_of(make_box(Vec3(0.1, 0.1, 0.1), 4)));
  method->reset(Vec3(0.04, 0.003, 0.055));
  ASSERT_NEAR(method->step({.p_SD = Vec3(0.04, 0.003, 0.049)}).force_n.z(), 1.0, kHoverForce);
  for (int i = 1; i <= 120; ++i) method->step({.p_SD = Vec3(0.04 + 1e-4 * i, 0.003, 0.049)});
  EXPECT_FALSE(method->is_inside());
  EXPECT_FALSE(method->step({.p_SD = Vec3(0.052, 0.003, 0.04)}).contact);
  const MethodOutput side = method->step({.p_SD = Vec3(0.0485, 0.003, 0.04)});
  EXPECT_NEAR(side.force_n.x(), 1.5, kHoverForce);
}

// In a groove the probe is held by both walls at once, at the bottom.
TEST(SmoothMethod, AGrooveHoldsAtItsBottom) {
  const auto method = make(scene_of(make_gutter(0.1, 0.03, 0.5 * kPi, 8)));
  const Vec3 bottom(0.0, 0.05 - 0.03, 0.011);
  method->reset(bottom + Vec3(0, 0.01, 0));
  MethodOutput felt;
  for (int i = 0; i <= 130; ++i) felt = method->step({.p_SD = bottom + Vec3(1e-6 * i, 0.01 - 1e-4 * i, 0)});
  EXPECT_LT((felt.p_SP - bottom).norm(), 5e-5);
  EXPECT_NEAR(felt.force_n.y(), 3.0, 0.1);
}

TEST(SmoothMethod, IsTheSameAtEveryScaleAndPlace) {
  const TriangleMesh mesh = made::sphere(0.05, 16, 0.1);
  const std::vector<Vec3> way = wander(mesh, 103, 1500);
  const auto base = make(scene_of(mesh));
  base->reset(way[0]);
  std::vector<MethodOutput> expected;
  for (const Vec3& P : way) expected.push_back(base->step({.p_SD = P}));
  struct Where {
    double scale;
    Vec3 move;
    double allowed;
  };
  for (const Where& where : {Where{1e-6, Vec3::Zero(), 1e-6}, Where{1e6, Vec3::Zero(), 1e-6}, Where{1.0, Vec3(1e3, -2e3, 1e3), 1e-6},
                             Where{1e3, Vec3(1e6, 1e6, -1e6), 1e-6}}) {
    const auto method = make(scene_of(scaled_and_moved(mesh, where.scale, where.move)));
    method->reset(where.scale * way[0] + where.move);
    int differ = 0;
    int contacts = 0;
    for (std::size_t i = 0; i < way.size(); ++i) {
      const MethodOutput felt = method->step({.p_SD = where.scale * way[i] + where.move});
      contacts += expected[i].contact ? 1 : 0;
      differ += (felt.force_n / where.scale - expected[i].force_n).norm() > where.allowed * (1.0 + expected[i].force_n.norm()) ? 1 : 0;
    }
    EXPECT_GT(contacts, 100);
    // At a tie rounding may choose the other side; hardly ever.
    EXPECT_LE(differ, contacts / 50) << "scale " << where.scale << " at " << where.move.transpose();
  }
}

TEST(SmoothMethod, ANotFiniteSampleIsIgnored) {
  const auto method = make(scene_of(make_icosphere(0.05, 3)));
  const Vec3 inside(0.049, 0.001, 0.002);
  method->reset(Vec3(0.06, 0, 0));
  const Vec3 before = method->step({.p_SD = inside}).force_n;
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    const MethodOutput felt = method->step({.p_SD = Vec3(0, bad, 0)});
    EXPECT_TRUE(felt.force_n.isZero(0.0));
    EXPECT_FALSE(felt.contact);
    EXPECT_TRUE(felt.p_SP.allFinite());
  }
  EXPECT_LT((method->step({.p_SD = inside}).force_n - before).norm(), 1e-9);
  EXPECT_GT(before.norm(), 0.5);
}

// A surface that moves: the probe inside is carried along, the probe outside is caught, and the force is that of a scene built there.
TEST(SmoothMethod, MovingAndDeformingSurfacesAreFelt) {
  TriangleMesh mesh = make_icosphere(0.05, 3);
  const auto method = make(scene_of(mesh));
  const Vec3 still(0.0485, 0.004, -0.003);
  method->reset(Vec3(0.06, 0, 0));
  ASSERT_TRUE(method->step({.p_SD = still}).contact);
  const std::vector<Vec3> rest = mesh.vertices;
  for (int i = 1; i <= 60; ++i) {
    // It swells along x and drifts along y.
    for (std::size_t v = 0; v < rest.size(); ++v)
      mesh.vertices[v] = Vec3(rest[v].x() * (1.0 + 2e-4 * i), rest[v].y() + 1e-5 * i, rest[v].z());
    ASSERT_TRUE(method->move_vertices(0, mesh.vertices));
    const Vec3 felt = method->step({.p_SD = still}).force_n;
    const auto anew = make(scene_of(mesh));
    anew->reset(Vec3(0.07, 0, 0));
    anew->step({.p_SD = Vec3(0.052 + 2e-5 * i, 0.004, -0.003)});
    const Vec3 expected = anew->step({.p_SD = still}).force_n;
    ASSERT_GT(expected.norm(), 0.5);
    EXPECT_LT((felt - expected).norm(), 1e-4) << i;
  }
  EXPECT_EQ(method->counters().entries, 1U);
}

TEST(SmoothMethod, ASurfaceThatSweepsOverTheProbeCatchesIt) {
  TriangleMesh mesh = make_plane_grid(0.1, 10);
  const auto method = make(scene_of(mesh));
  const Vec3 still(0.0013, 0.0021, 0.002);
  method->reset(still);
  EXPECT_FALSE(method->step({.p_SD = still}).contact);
  for (Vec3& v : mesh.vertices) v.z() += 0.003;
  ASSERT_TRUE(method->move_vertices(0, mesh.vertices));
  EXPECT_NEAR(method->step({.p_SD = still}).force_n.z(), 1.0, 1e-6);
  for (Vec3& v : mesh.vertices) v.z() -= 0.003;
  ASSERT_TRUE(method->move_vertices(0, mesh.vertices));
  EXPECT_FALSE(method->step({.p_SD = still}).contact);
  EXPECT_EQ(method->counters().releases, 1U);
}

TEST(SmoothMethod, FreeSpaceIsSkipped) {
  const auto method = make(scene_of(make_icosphere(0.05, 4)));
  method->reset(Vec3(0.2, 0, 0));
  for (int i = 0; i < 1000; ++i) method->step({.p_SD = Vec3(0.2 - 1e-5 * i, 1e-5 * i, 0)});
  EXPECT_GT(method->counters().skipped, 990U);
  EXPECT_LE(method->counters().selections, 2U);
}

TEST(SmoothMethod, SettingsAreChecked) {
  const TouchScene scene = scene_of(make_icosphere(0.05, 1));
  MethodSettings settings;
  settings.name = "smooth";
  EXPECT_TRUE(make_method(settings, scene));
  const auto refused = [&](const std::function<void(MethodSettings&)>& change) {
    MethodSettings wrong = settings;
    change(wrong);
    const auto made = make_method(wrong, scene);
    return !made && made.error().what.find("smooth") != std::string::npos;
  };
  EXPECT_TRUE(refused([](MethodSettings& s) { s.set_size = 15; }));
  EXPECT_TRUE(refused([](MethodSettings& s) { s.set_size = 257; }));
  EXPECT_TRUE(refused([](MethodSettings& s) { s.smooth_radius_m = -1.0; }));
  EXPECT_TRUE(refused([](MethodSettings& s) { s.smooth_radius_m = std::nan(""); }));
  EXPECT_TRUE(refused([](MethodSettings& s) { s.smooth_layer = 1.5; }));
  EXPECT_TRUE(refused([](MethodSettings& s) { s.hull_directions = 8; }));
  EXPECT_TRUE(refused([](MethodSettings& s) { s.probe_radius_m = 0.001; }));
}

TEST(SmoothMethod, DescribesWhatItDid) {
  const auto method = make(scene_of(make_icosphere(0.05, 2)));
  method->reset(Vec3(0.06, 0, 0));
  method->step({.p_SD = Vec3(0.049, 0, 0)});
  const std::string text = method->describe();
  for (const char* word : {"RADIUS", "mend:", "hulls of 14", "1 entries", "selected here"})
    EXPECT_NE(text.find(word), std::string::npos) << word;
}

TEST(SmoothMethod, SaysThatItLeavesOutFriction) {
  const auto with = make(scene_of(make_icosphere(0.05, 1), {.friction_static = 0.5}));
  const auto without = make(scene_of(make_icosphere(0.05, 1)));
  EXPECT_NE(with->describe().find("friction"), std::string::npos);
  EXPECT_EQ(without->describe().find("friction"), std::string::npos);
}

}  // namespace
}  // namespace hapton
