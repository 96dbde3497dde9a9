#include <gtest/gtest.h>

#include "tests/core/force/smooth/smooth_scenes.h"

namespace hapton {
namespace {

// The reason that an exchange of sets cannot be felt: any set that covers enough gives the force of all triangles, to the last bit.
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
    SCOPED_TRACE(testing::Message() << "seed " << 91 + c);
    const std::vector<Vec3> path = wandering_path(cases[c].mesh, 91 + c, 1200);
    const auto twin = make_smooth(scene, with_size(64, cases[c].layer));
    twin->use_all_triangles();
    std::vector<MethodOutput> expected;
    twin->reset(path[0]);
    int contacts = 0;
    for (const Vec3& P : path) {
      expected.push_back(twin->step({.p_SD = P}));
      contacts += expected.back().contact ? 1 : 0;
    }
    EXPECT_GT(contacts, 150);
    for (const std::uint32_t size : {24U, 64U, 256U}) {
      MethodSettings settings = with_size(size, cases[c].layer);
      settings.smooth_radius_m = twin->radius_m();
      const auto method = make_smooth(scene, settings);
      method->reset(path[0]);
      for (std::size_t i = 0; i < path.size(); ++i) {
        const MethodOutput felt = method->step({.p_SD = path[i]});
        ASSERT_EQ(felt.force_n, expected[i].force_n) << "case " << c << " size " << size << " step " << i;
        ASSERT_EQ(felt.p_SP, expected[i].p_SP) << "case " << c << " size " << size << " step " << i;
      }
    }
  }
}

// A real mesh of open, creased, thin pieces, and sets far too small for RADIUS: the force is still the same, and the overflows are counted.
TEST(SmoothMethod, CorrectnessDoesNotDependOnTheSetsSize) {
  SCOPED_TRACE("seed 95");
  const TriangleMesh mesh = scaled_and_moved(made::obj_mesh("car_front_3300.obj"), 5e-5, Vec3::Zero());
  ASSERT_EQ(mesh.triangles.size(), 3300U);
  const TouchScene scene = scene_of(mesh);
  MethodSettings settings = with_size(64);
  settings.smooth_radius_m = 0.003;
  const auto twin = make_smooth(scene, settings);
  twin->use_all_triangles();
  settings.set_size = 16;
  const auto method = make_smooth(scene, settings);
  const std::vector<Vec3> path = wandering_path(mesh, 95, 400);
  twin->reset(path[0]);
  method->reset(path[0]);
  int contacts = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const MethodOutput expected = twin->step({.p_SD = path[i]});
    const MethodOutput felt = method->step({.p_SD = path[i]});
    ASSERT_EQ(felt.force_n, expected.force_n) << i;
    contacts += expected.contact ? 1 : 0;
  }
  EXPECT_GT(contacts, 30);
  EXPECT_GT(method->counters().overflows, 0U);
}

// Both tasks under a simulated clock: the slow one starts every `period` steps and its set arrives `latency` steps later. However late the
// set is, the force is that of one task alone; the counters show how late it was.
TEST(SmoothMethod, TheSlowTaskMayBeLate) {
  SCOPED_TRACE("seed 97");
  const TriangleMesh mesh = made::sphere(0.05, 24, 0.1);
  const TouchScene scene = scene_of(mesh);
  const std::vector<Vec3> path = wandering_path(mesh, 97, 3000);
  const auto alone = make_smooth(scene, with_size(64));
  std::vector<Vec3> expected;
  alone->reset(path[0]);
  for (const Vec3& P : path) expected.push_back(alone->step({.p_SD = P}).force_n);

  std::uint64_t late_when_quick = 0;
  std::uint64_t late_when_slow = 0;
  for (const auto& [period, latency] : {std::pair(1, 1), std::pair(4, 4), std::pair(10, 25), std::pair(100, 400)}) {
    const auto method = make_smooth(scene, with_size(64));
    method->reset(path[0]);
    std::deque<std::pair<std::size_t, std::unique_ptr<LocalSet>>> pending_sets;
    for (std::size_t i = 0; i < path.size(); ++i) {
      if (i % static_cast<std::size_t>(period) == 0) {
        auto set = std::make_unique<LocalSet>();
        method->scene().select(method->request(), method->set_size(), *set);
        pending_sets.emplace_back(i + static_cast<std::size_t>(latency), std::move(set));
      }
      while (!pending_sets.empty() && pending_sets.front().first <= i) {
        method->offer(*pending_sets.front().second);
        pending_sets.pop_front();
      }
      ASSERT_EQ(method->step({.p_SD = path[i]}).force_n, expected[i]) << "period " << period << " latency " << latency << " step " << i;
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

// Both tasks as in haptics_node: prepare() runs beside step(), here in every tenth step, the period of the node's other thread at 1 kHz.
TEST(SmoothMethod, PrepareKeepsTheFastTaskFromSelecting) {
  const TriangleMesh mesh = make_bumpy_sphere(0.05, 0.05, 20000, 3);
  const auto at = [](int i) {
    const double a = 2e-3 * i;  // 94 mm/s
    return Vec3(0.047 * Vec3(std::cos(a), std::sin(a), 0.1 * std::sin(5.0 * a)));
  };
  const auto alone = make_smooth(scene_of(mesh));
  const auto with_prepare = make_smooth(scene_of(mesh));
  alone->reset(Vec3(0.07, 0, 0));
  with_prepare->reset(Vec3(0.07, 0, 0));
  for (int i = 0; i < 3000; ++i) {
    const Vec3 expected = alone->step({.p_SD = at(i)}).force_n;
    ASSERT_EQ(with_prepare->step({.p_SD = at(i)}).force_n, expected);
    if (i % 10 == 0) {
      while (with_prepare->prepare()) {
      }
    }
  }
  EXPECT_GT(with_prepare->counters().offered, 50U);
  EXPECT_LT(with_prepare->counters().selections, alone->counters().selections / 4);
}

// The paper's full layer (--layer 1) uses the slow task's sets as well: a run in which none is offered fails here.
TEST(SmoothMethod, TheFullLayerUsesOfferedSets) {
  const TriangleMesh mesh = make_bumpy_sphere(0.05, 0.05, 20000, 3);
  auto made = SmoothMethod::make({.smooth_layer = kFdhPaperLayer}, scene_of(mesh));
  ASSERT_TRUE(made) << made.error().what;
  auto& method = dynamic_cast<SmoothMethod&>(**made);
  EXPECT_DOUBLE_EQ(method.layer_m(), method.radius_m());
  const auto alone = make_smooth(scene_of(mesh), with_size(64, kFdhPaperLayer));
  method.reset(Vec3(0.07, 0, 0));
  alone->reset(Vec3(0.07, 0, 0));
  int steps_outside = 0;
  for (int i = 0; i < 3000; ++i) {
    const double a = 2e-3 * i;
    const Vec3 P = (0.0487 + 0.0025 * std::sin(0.02 * i)) * Vec3(std::cos(a), std::sin(a), 0.1 * std::sin(5.0 * a)).normalized();
    const MethodOutput felt = method.step({.p_SD = P});
    ASSERT_EQ(felt.force_n, alone->step({.p_SD = P}).force_n) << i;
    steps_outside += felt.contact && !method.is_inside() ? 1 : 0;
    if (i % 10 == 0) {
      while (method.prepare()) {
      }
    }
  }
  EXPECT_GT(steps_outside, 100) << "the layer is felt before the surface is reached";
  EXPECT_GT(method.counters().offered, 50U) << "no set ever came from the slow task";
  EXPECT_LT(method.counters().selections, alone->counters().selections / 2);
}

TEST(SmoothMethod, PrepareMayRunBesideStep) {
  SCOPED_TRACE("seed 105");
  const TriangleMesh mesh = made::sphere(0.05, 24, 0.1);
  const std::vector<Vec3> path = wandering_path(mesh, 105, 4000);
  const auto alone = make_smooth(scene_of(mesh));
  const auto with_prepare = make_smooth(scene_of(mesh));
  alone->reset(path[0]);
  with_prepare->reset(path[0]);
  std::atomic<bool> stop = false;
  std::thread slow([&] {
    while (!stop.load()) {
      if (!with_prepare->prepare()) std::this_thread::yield();
    }
  });
  int different_steps = 0;
  for (int round = 0; round < 1000 && with_prepare->counters().offered == 0; ++round) {  // a busy machine may let the other thread wait
    for (const Vec3& P : path) different_steps += with_prepare->step({.p_SD = P}).force_n != alone->step({.p_SD = P}).force_n ? 1 : 0;
  }
  stop.store(true);
  slow.join();
  EXPECT_EQ(different_steps, 0);
  EXPECT_GT(with_prepare->counters().offered, 0U);
}

// The rate may change while running: the force does not depend on time, so the same path in finer steps ends at the same force.
TEST(SmoothMethod, TheRateMayChangeWhileRunning) {
  const TriangleMesh mesh = make_icosphere(0.05, 4);
  const auto steady = make_smooth(scene_of(mesh));
  const auto changing = make_smooth(scene_of(mesh));
  const auto at = [](double t) { return Vec3(0.0485 * std::cos(t), 0.0485 * std::sin(t), 0.003 * std::sin(3.0 * t)); };
  steady->reset(Vec3(0.06, 0, 0));
  changing->reset(Vec3(0.06, 0, 0));
  const std::uint64_t seed = 99;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  Vec3 last = Vec3::Zero();
  for (int i = 0; i < 1000; ++i) {
    const double t = 0.003 * i;
    const Vec3 expected = steady->step({.p_SD = at(t), .dt_s = 1e-3}).force_n;
    const int parts = std::array{1, 10, 3, 25}[random() % 4];
    Vec3 felt;
    for (int k = 1; k <= parts; ++k) {
      felt = changing->step({.p_SD = at(t - 0.003 * (parts - k) / parts * (i > 0 ? 1 : 0)), .dt_s = 1e-3 / parts}).force_n;
      if (i > 0) {
        EXPECT_LT((felt - last).norm(), 0.5) << "no discontinuity when the rate changes";
      }
      last = felt;
    }
    EXPECT_LT((felt - expected).norm(), 1e-5) << i;
  }
}

TEST(SmoothMethod, ExchangingSetsDoesNotChangeTheForce) {
  const TriangleMesh mesh = make_bumpy_sphere(0.05, 0.05, 20000, 3);
  const auto method = make_smooth(scene_of(mesh), with_size(32));
  method->reset(Vec3(0.07, 0, 0));
  Vec3 last = Vec3::Zero();
  Vec3 last_P;
  std::uint64_t selections = 0;
  int exchanges = 0;
  double worst_at_exchange = 0.0;
  double worst_otherwise = 0.0;
  for (int i = 0; i < 6000; ++i) {
    const double a = 0.5 * std::numbers::pi * i / 6000.0;
    const Vec3 P = 0.0465 * Vec3(std::cos(a), std::sin(a), 0.1 * std::sin(5.0 * a));
    const Vec3 force = method->step({.p_SD = P}).force_n;
    if (i > 1) {
      const double jump = (force - last).norm() / (1000.0 * (P - last_P).norm());
      const bool is_new = method->counters().selections != selections;
      exchanges += is_new ? 1 : 0;
      (is_new ? worst_at_exchange : worst_otherwise) = std::max(is_new ? worst_at_exchange : worst_otherwise, jump);
    }
    selections = method->counters().selections;
    last = force;
    last_P = P;
  }
  EXPECT_GT(exchanges, 30);
  EXPECT_LT(worst_at_exchange, std::max(2.0, 1.2 * worst_otherwise));
}

TEST(SmoothMethod, StepUsesNoHeap) {
  SCOPED_TRACE("seed 101");
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "allocations cannot be counted in this build";
  const TriangleMesh mesh = made::sphere(0.05, 24, 0.1);
  for (const std::uint32_t size : {16U, 64U, 256U}) {
    const auto method = make_smooth(scene_of(mesh), with_size(size, 1.0));
    const std::vector<Vec3> path = wandering_path(mesh, 101, 2000);
    method->reset(path[0]);
    auto set = std::make_unique<LocalSet>();
    const AllocationGuard guard;
    for (const Vec3& P : path) {
      method->step({.p_SD = P});
      method->scene().select(method->request(), size, *set);
      method->offer(*set);
    }
    EXPECT_EQ(guard.count(), 0U);
    EXPECT_GT(method->counters().entries, 0U);
  }
}

}  // namespace
}  // namespace hapton
