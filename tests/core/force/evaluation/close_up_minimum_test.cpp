#include "core/force/evaluation/close_up_minimum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>

#include "core/force/reference/reference_method.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

constexpr double kHalfSide = 1e-4;  // of the close-up; the bodies are about 0.1 m long

// By how much the reference gets nearer to the device than p, started at p on the whole mesh.
double gain_on_whole_mesh(const TriangleMesh& mesh, const Vec3& p, const Vec3& device) {
  TouchScene scene;
  scene.objects.push_back({std::make_shared<TriangleMesh>(mesh), Material{}});
  MethodSettings settings;
  settings.name = "reference";
  const auto reference = ReferenceMethod::make_reference(settings, scene);
  return (p - device).norm() - ((*reference)->settle_from(p, device).p_SP - device).norm();
}

bool is_minimum_close_up(const TriangleMesh& mesh, const Vec3& p, const Vec3& device) {
  TriangleBoxes boxes(mesh.vertices, mesh.triangles);
  return is_minimum_in_close_up(mesh, boxes, {}, p, kHalfSide, p, device);
}

TriangleMesh block(const Vec3& low, const Vec3& high) { return scaled_and_moved(make_box(high - low), 1.0, 0.5 * (low + high)); }

// A wall that ends `lip` below the underside of a block beside it: in the corner between them the lip holds a point. The device is behind
// the wall and above.
TEST(CloseUpMinimum, ALipLowerThanTheReferenceLiftsItselfHolds) {
  for (const double lip : {8e-10, 1e-9}) {
    const TriangleMesh parts = joined(block({-0.01, -0.04, 0.0}, {0.0, 0.04, 0.05}), block({0.0, -0.03, lip}, {0.05, 0.03, 0.05}));
    const Vec3 minimum(1e-10, 0.0, lip - 1e-10);
    const Vec3 device(-0.03, 0.0, 0.02);
    EXPECT_GT(gain_on_whole_mesh(parts, minimum, device), 0.001) << lip;
    EXPECT_TRUE(is_minimum_close_up(parts, minimum, device)) << lip;
  }
}

TEST(CloseUpMinimum, AProxyThatNothingHoldsIsAtNoMinimum) {
  const TriangleMesh box = block({-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05});
  const auto is_minimum = [&](const Vec3& p, const Vec3& device) { return is_minimum_close_up(box, p, device); };
  EXPECT_TRUE(is_minimum(Vec3(0.01, 0.02, 0.05 + 1e-10), Vec3(0.01, 0.02, 0.03)));
  EXPECT_FALSE(is_minimum(Vec3(0.01, 0.02, 0.05 + 1e-10), Vec3(0.012, 0.02, 0.03)));         // the device is beside p, not straight below
  EXPECT_FALSE(is_minimum(Vec3(0.01, 0.02, 0.05 + 1e-10), Vec3(0.01, 0.02, 0.06)));          // the device is outside
  EXPECT_FALSE(is_minimum(Vec3(0.05, 0.02, 0.05 + 1e-10), Vec3(0.06, 0.02, 0.03)));          // the device is beyond an edge
  EXPECT_FALSE(is_minimum(Vec3(0.05 + 1e-10, 0.05, 0.05 + 1e-10), Vec3(0.06, 0.06, 0.03)));  // the device is beyond a corner
  const TriangleMesh room = flipped(box);
  const Vec3 corner = Vec3::Constant(0.05 - 1e-10);
  EXPECT_TRUE(is_minimum_close_up(room, corner, Vec3(0.06, 0.07, 0.08)));
  EXPECT_FALSE(is_minimum_close_up(room, corner, Vec3(0.06, 0.04, 0.08)));
}

}  // namespace
}  // namespace hapton
