#include "core/force/evaluation/stress_sealed_bodies.h"

#include <utility>

#include "core/force/evaluation/stress_parts.h"
#include "core/geometry/cracked_shapes.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/seal_cracks.h"

namespace hapton {
namespace {

constexpr double kExtent = 0.1;

StressBody sealed(TriangleMesh cracked) {
  SealReport report;
  TriangleMesh mesh = seal_cracks(std::move(cracked), report);
  return {.name = {}, .touched = mesh, .solid = mesh};
}

}  // namespace

StressBody make_sealed_tears(double width_share) { return sealed(make_shaken(make_icosphere(0.5 * kExtent, 3), width_share * kExtent, 1)); }

StressBody make_sealed_star(double width_share) { return sealed(make_shaken(make_star(), 0.9 * width_share * kExtent, 2)); }

StressBody make_sealed_box(double width_share) { return sealed(make_patched_box(Vec3(1.0, 0.8, 0.6) * kExtent, width_share * kExtent, 3)); }

StressBody make_sealed_ball(double width_share) { return sealed(make_patched_sphere(0.5 * kExtent, 0.0, width_share * kExtent, 4)); }

StressBody make_sealed_waves(double width_share) {
  return sealed(make_patched_sphere(0.48 * kExtent, 0.1, 0.9 * width_share * kExtent, 5));
}

}  // namespace hapton
