// Compares Fixed Direction Hulls (FDH) of 6, 14, 18 and 26 directions on the same queries: time, nodes opened, triangles tested. Also
// measures how long trees take to build and to refit, and the two tasks of method `smooth`. Mesh: a bumpy sphere with a diameter of 100 mm,
// seed 1. The queries follow a path over its whole surface.
//   build/release/bin/fdh_bench --benchmark_filter=nearest_64
#include <benchmark/benchmark.h>

#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <vector>

#include "core/collision/fdh_tree.h"
#include "core/force/smooth/smooth_method.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

constexpr double kDiameterM = 0.1;  // of the sphere

const TriangleMesh& mesh_of(std::int64_t triangles) {
  static std::map<std::int64_t, TriangleMesh> made;
  auto [at, is_new] = made.try_emplace(triangles);
  if (is_new) at->second = make_bumpy_sphere(0.5 * kDiameterM, 0.1, static_cast<std::size_t>(triangles), 1);
  return at->second;
}

template <int K>
const FdhTree<K>& tree_of(std::int64_t triangles) {
  static std::map<std::int64_t, FdhTree<K>> built;
  const auto at = built.find(triangles);
  if (at != built.end()) return at->second;
  const TriangleMesh& mesh = mesh_of(triangles);
  return built.emplace(triangles, std::move(*FdhTree<K>::build(mesh.vertices, mesh.triangles))).first->second;
}

// The positions of a probe at 100 mm/s and 1 kHz, on a spiral from pole to pole over the whole surface, 2 mm below to 2 mm above it.
const std::vector<Vec3>& walk_over(std::int64_t triangles) {
  static std::map<std::int64_t, std::vector<Vec3>> made;
  auto [at, is_new] = made.try_emplace(triangles);
  if (!is_new) return at->second;
  const FdhTree<6>& tree = tree_of<6>(triangles);
  const TriangleMesh& mesh = mesh_of(triangles);
  constexpr int kSteps = 20000;  // steps of the spiral over the sphere; a free choice
  for (int i = 0; i < kSteps; ++i) {
    const double s = (i + 0.5) / kSteps;
    const double polar = std::acos(1.0 - 2.0 * s);
    const double azimuth = 2.0 * std::numbers::pi * 8.0 * s;
    const Vec3 direction(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar));
    const Vec3 near = 0.5 * kDiameterM * direction;
    const Vec3 on = mesh.corner(tree.find_nearest(near).triangle, 0);
    at->second.push_back(on + 0.002 * std::sin(0.01 * i) * direction);
  }
  return at->second;
}

void count(benchmark::State& state, const FdhVisits& visits) {
  const auto per_query = [&](std::uint32_t n) {
    return benchmark::Counter(static_cast<double>(n) / static_cast<double>(state.iterations()));
  };
  state.counters["nodes"] = per_query(visits.nodes);
  state.counters["leaves"] = per_query(visits.leaves);
  state.counters["triangles"] = per_query(visits.items);
}

template <int K>
void build(benchmark::State& state) {
  const TriangleMesh& mesh = mesh_of(state.range(0));
  FdhStats stats;
  for (auto _ : state) {
    auto tree = FdhTree<K>::build(mesh.vertices, mesh.triangles);
    stats = tree->stats();
    benchmark::DoNotOptimize(tree);
  }
  state.counters["MB"] = static_cast<double>(stats.bytes) * 1e-6;
  state.counters["depth"] = stats.depth;
  state.counters["mesh_triangles"] = static_cast<double>(stats.triangles);
}

template <int K>
void refit(benchmark::State& state) {
  const TriangleMesh& mesh = mesh_of(state.range(0));
  auto tree = FdhTree<K>::build(mesh.vertices, mesh.triangles);
  for (auto _ : state) benchmark::DoNotOptimize(tree->refit(mesh.vertices));
}

// Finds a local set without copying it: the 64 triangles nearest to the probe, and the radius within which this set is complete.
template <int K>
void nearest_64(benchmark::State& state) {
  const FdhTree<K>& tree = tree_of<K>(state.range(0));
  const auto& walk = walk_over(state.range(0));
  FdhVisits visits;
  std::size_t i = 0;
  for (auto _ : state) {
    FdhNearest nearest(64, std::numeric_limits<double>::infinity());
    visits += tree.collect_nearest(walk[i], 0, nearest);
    benchmark::DoNotOptimize(nearest.finish().data());
    if (++i == walk.size()) i = 0;
  }
  count(state, visits);
}

// Does the same for the triangles nearest to the path of the next two steps.
template <int K>
void nearest_64_to_way(benchmark::State& state) {
  const FdhTree<K>& tree = tree_of<K>(state.range(0));
  const auto& walk = walk_over(state.range(0));
  FdhVisits visits;
  std::size_t i = 0;
  for (auto _ : state) {
    FdhNearest nearest(64, std::numeric_limits<double>::infinity());
    visits += tree.collect_nearest(walk[i], walk[i] + 2.0 * (walk[i + 1] - walk[i]), 0, nearest);
    benchmark::DoNotOptimize(nearest.finish().data());
    if (++i + 1 == walk.size()) i = 0;
  }
  count(state, visits);
}

template <int K>
void nearest_1(benchmark::State& state) {
  const FdhTree<K>& tree = tree_of<K>(state.range(0));
  const auto& walk = walk_over(state.range(0));
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(tree.find_nearest(walk[i]));
    if (++i == walk.size()) i = 0;
  }
}

// Each iteration makes one query, at one sample of the path after the other, except the last `ahead` samples, and then begins again.
// make_query(walk, i) returns the query at sample i.
template <int K, class MakeQuery>
void query_along_walk(benchmark::State& state, std::size_t ahead, MakeQuery&& make_query) {
  const FdhTree<K>& tree = tree_of<K>(state.range(0));
  const auto& walk = walk_over(state.range(0));
  FdhVisits visits;
  std::size_t i = 0;
  std::uint64_t found = 0;
  for (auto _ : state) {
    visits += tree.for_each_overlapping(make_query(walk, i), [&](std::uint32_t) { ++found; });
    if (++i + ahead == walk.size()) i = 0;
  }
  benchmark::DoNotOptimize(found);
  count(state, visits);
}

// Each query is the segment from one sample to the next.
template <int K>
void segment(benchmark::State& state) {
  query_along_walk<K>(state, 1, [](const auto& walk, std::size_t i) { return FdhSweep{walk[i], walk[i + 1], 0.0}; });
}

// Each query is a long segment through the mesh, between samples two fifths of the spiral apart.
template <int K>
void long_segment(benchmark::State& state) {
  query_along_walk<K>(state, 0, [](const auto& walk, std::size_t i) { return FdhSweep{walk[i], walk[(i + 7919) % walk.size()], 0.0}; });
}

template <int K>
void ball(benchmark::State& state) {
  query_along_walk<K>(state, 0, [](const auto& walk, std::size_t i) { return FdhBall{walk[i], 0.0005}; });
}

TouchScene touch_scene(std::int64_t triangles) {
  TouchScene scene;
  scene.objects.push_back({std::make_shared<TriangleMesh>(mesh_of(triangles)), {}});
  return scene;
}

void smooth_prepare(benchmark::State& state) {
  const TouchScene scene = touch_scene(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(SmoothScene::build(scene, {}));
}

// Times the slow task: it selects the nearest triangles and copies all that the fast task needs to know about them.
void smooth_select(benchmark::State& state) {
  const auto scene = SmoothScene::build(touch_scene(state.range(0)), {});
  const auto& walk = walk_over(state.range(0));
  const auto set = std::make_unique<LocalSet>();
  std::size_t i = 0;
  for (auto _ : state) {
    scene->select({walk[i], walk[i]}, static_cast<std::uint32_t>(state.range(1)), *set);
    benchmark::DoNotOptimize(set->radius);
    if (++i == walk.size()) i = 0;
  }
}

// Times the fast task along the path, partly inside the mesh. Without a slow task, it selects its sets itself when it needs one.
void smooth_step(benchmark::State& state) {
  const auto made = SmoothMethod::make({.set_size = static_cast<int>(state.range(1))}, touch_scene(state.range(0)));
  auto* const method = static_cast<SmoothMethod*>(made->get());
  const auto& walk = walk_over(state.range(0));
  std::size_t i = 0;
  method->reset(walk[0] * 1.1);
  for (auto _ : state) {
    benchmark::DoNotOptimize(method->step({.p_SD = walk[i]}));
    if (++i == walk.size()) i = 0;
  }
  const SmoothCounters& counters = method->counters();
  state.counters["selections"] = static_cast<double>(counters.selections) / static_cast<double>(counters.steps);
  state.counters["overflows"] = static_cast<double>(counters.overflows) / static_cast<double>(counters.steps);
}

#define HAPTON_ALL_HULLS(query)                                    \
  BENCHMARK(query<6>)->Arg(20'000)->Arg(300'000)->Arg(1'000'000);  \
  BENCHMARK(query<14>)->Arg(20'000)->Arg(300'000)->Arg(1'000'000); \
  BENCHMARK(query<18>)->Arg(20'000)->Arg(300'000)->Arg(1'000'000); \
  BENCHMARK(query<26>)->Arg(20'000)->Arg(300'000)->Arg(1'000'000)

HAPTON_ALL_HULLS(nearest_64);
HAPTON_ALL_HULLS(nearest_64_to_way);
HAPTON_ALL_HULLS(nearest_1);
HAPTON_ALL_HULLS(segment);
HAPTON_ALL_HULLS(long_segment);
HAPTON_ALL_HULLS(ball);
BENCHMARK(build<6>)->Arg(1'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK(build<14>)->Arg(1'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK(build<18>)->Arg(1'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK(build<26>)->Arg(1'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK(refit<6>)->Arg(1'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK(refit<14>)->Arg(1'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK(smooth_prepare)->Arg(1'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK(smooth_select)->Args({20'000, 64})->Args({1'000'000, 16})->Args({1'000'000, 64})->Args({1'000'000, 256});
BENCHMARK(smooth_step)->Args({20'000, 64})->Args({1'000'000, 64})->Args({1'000'000, 256});

}  // namespace
}  // namespace hapton
