#include "core/force/evaluation/close_up_minimum.h"

#include <memory>
#include <numbers>

#include "core/force/reference/reference_method.h"
#include "core/geometry/crop_to_cube.h"

namespace hapton {
namespace {

constexpr double kStaysShare =
    0.25;  // of the half side: more than any contact offset moves the proxy, less than the distance to the part that is cut off

}  // namespace

bool is_minimum_in_close_up(const TriangleMesh& mesh, TriangleBoxes& boxes, const Material& material, const Vec3& centre, double half_side,
                            const Vec3& start, const Vec3& device) {
  const auto near = boxes.find_near(centre, std::numbers::sqrt3 * half_side);
  TouchScene scene;
  scene.objects.push_back({std::make_shared<TriangleMesh>(crop_to_cube(mesh, near, centre, half_side)), material});
  MethodSettings settings;
  settings.name = "reference";
  const auto reference = ReferenceMethod::make_reference(settings, scene);
  if (!reference) return false;
  const Vec3 from = start - centre;
  return ((*reference)->settle_from(from, device - centre).p_SP - from).norm() < kStaysShare * half_side;
}

}  // namespace hapton
