// Component core alone: a hand slides over a dome with friction, once with each method. Only proxy has to give a force.
#include <cmath>
#include <cstdio>
#include <memory>
#include <string_view>

#include "core/force/touch_step.h"

using namespace hapton;

namespace {

std::shared_ptr<const TriangleMesh> make_dome(double radius_m, std::uint32_t n) {
  auto dome = std::make_shared<TriangleMesh>();
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i <= n; ++i) {
      const double x = 2.0 * i / n - 1.0;
      const double y = 2.0 * j / n - 1.0;
      dome->vertices.emplace_back(radius_m * x, radius_m * y, radius_m * std::sqrt(std::max(0.0, 2.25 - x * x - y * y)));
    }
  }
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = j * (n + 1) + i;
      dome->triangles.push_back({a, a + 1, a + n + 2});
      dome->triangles.push_back({a, a + n + 2, a + n + 1});
    }
  }
  return dome;
}

// The largest force of a motion from above that presses into the dome.
double stroke(const char* method_name) {
  const TouchScene scene{{{make_dome(0.05, 40), {.stiffness_n_per_m = 800.0, .friction_static = 0.3, .friction_dynamic = 0.2}}}};
  auto method = make_method({.name = method_name}, scene);
  if (!method) return std::fprintf(stderr, "%s\n", method.error().what.c_str()), -1.0;
  TouchStep touch(std::move(*method), scene);
  touch.reset({.p_WD = {0.0, 0.0, 0.09}});
  double largest_n = 0.0;
  for (int k = 0; k < 2000; ++k) {
    const double t = k / 2000.0;
    while (touch.share_method()->prepare()) {
    }
    largest_n = std::max(largest_n, touch.step({.p_WD = {0.02 * t, 0.01 * t, 0.09 - 0.02 * t}}).force_n.norm());
  }
  return largest_n;
}

}  // namespace

int main() {
  for (const char* name : {"proxy", "smooth", "sweep", "reference"}) {
    const double largest_n = stroke(name);
    std::printf("%s: at most %.3f N\n", name, largest_n);
    if (largest_n < 0.0 || (!(largest_n > 0.1) && std::string_view(name) == "proxy")) return 1;
  }
  return 0;
}
