#include "closed_loop/touch_wall.h"

#include <cstdint>
#include <utility>

namespace hapton {
namespace {

constexpr int kCells = 20;  // cells along each side
constexpr double kSideM = 0.2;

}  // namespace

std::shared_ptr<const TriangleMesh> make_wall_mesh() {
  TriangleMesh plate;
  for (int i = 0; i <= kCells; ++i) {
    for (int j = 0; j <= kCells; ++j)
      plate.vertices.emplace_back(0.0, kSideM * i / kCells - 0.5 * kSideM, kSideM * j / kCells - 0.5 * kSideM);
  }
  const auto at = [](int i, int j) { return static_cast<std::uint32_t>(i * (kCells + 1) + j); };
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      plate.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      plate.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return std::make_shared<const TriangleMesh>(std::move(plate));
}

Result<std::unique_ptr<TouchLaw>> make_touch_wall(double stiffness_n_per_m, double damping_ns_per_m) {
  TouchScene scene;
  scene.objects.push_back(
      {make_wall_mesh(), {.stiffness_n_per_m = stiffness_n_per_m, .damping_ns_per_m = damping_ns_per_m, .two_sided = false}});
  auto method = make_method({}, scene);
  if (!method) return tl::unexpected(method.error());
  return std::make_unique<TouchLaw>(std::move(*method));
}

}  // namespace hapton
