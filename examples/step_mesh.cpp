// Shows: touch a mesh file in your own process, 10,000 steps a second, without nodes or network.
// Run:   step_mesh meshes/relief.obj mm
#include <cstdio>
#include <memory>

#include "core/force/touch_step.h"
#include "runtime/clock.h"
#include "runtime/latency_histogram.h"
#include "runtime/realtime.h"
#include "scene/touch_mesh.h"

using namespace hapton;

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: step_mesh FILE m|cm|mm|in\n"), 2;
  const auto unit = parse_unit(argv[2]);
  if (!unit) return std::fprintf(stderr, "%s\n", unit.error().what.c_str()), 2;
  const auto file = load_touch_mesh(argv[1], *unit);  // cracks are sealed
  if (!file) return std::fprintf(stderr, "%s\n", file.error().what.c_str()), 1;

  const auto mesh = std::make_shared<TriangleMesh>(file->mesh);
  const TouchScene scene{{{mesh, {.stiffness_n_per_m = 800.0, .friction_static = 0.3, .friction_dynamic = 0.2}}}};
  auto method = make_method({.name = "proxy"}, scene);
  if (!method) return std::fprintf(stderr, "%s\n", method.error().what.c_str()), 1;
  TouchStep touch(std::move(*method), scene);

  // The hand starts above the mesh and moves down through its middle at 0.1 m/s. Your program uses the position of its device instead.
  Vec3 low = mesh->vertices[0];
  Vec3 high = low;
  for (const Vec3& v : mesh->vertices) low = low.cwiseMin(v), high = high.cwiseMax(v);
  Vec3 hand = 0.5 * (low + high);
  hand.z() = high.z() + 0.01;
  touch.reset({.p_WD = hand});

  if (const auto rights = enter_realtime({}); rights) std::printf("%s\n", rights->to_text().c_str());
  SteadyClock clock;
  LatencyHistogram step_times;
  constexpr std::int64_t kPeriodNs = 100'000;
  double max_force_n = 0.0;
  int contact_steps = 0;
  const std::int64_t start_ns = clock.now_ns();
  for (int k = 1; k <= 10'000; ++k) {
    clock.sleep_until_ns(start_ns + k * kPeriodNs);
    hand.z() -= (k < 2000 ? 0.1 : k % 2000 < 1000 ? 0.002 : -0.002) * 1e-4;
    const std::int64_t begin_ns = clock.now_ns();
    const TouchOutput felt = touch.step({.p_WD = hand, .dt_s = 1e-4});
    step_times.record(clock.now_ns() - begin_ns);
    contact_steps += felt.contact;
    max_force_n = std::max(max_force_n, felt.force_n.norm());
  }
  const double seconds = 1e-9 * static_cast<double>(clock.now_ns() - start_ns);
  std::printf("%.0f steps/s, %d in contact, at most %.2f N; step p50 %.2f us, p99 %.2f us\n", 10'000 / seconds, contact_steps, max_force_n,
              1e-3 * step_times.quantile_ns(0.5), 1e-3 * step_times.quantile_ns(0.99));
  return contact_steps > 0 ? 0 : 1;
}
