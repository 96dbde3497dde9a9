// The touched place of deforming surfaces (ForceMethod::find_place), compared with the closed form that affine deformations have.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "core/force/streamed_method.h"
#include "tests/core/force/moving_plates.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

// The matrix A of the deformation: with weight 1, a point p of the shape at rest is at p + A p.
Mat3 whole_stretch() { return (Mat3() << 0.15, 0.05, 0.0, -0.04, -0.1, 0.06, 0.0, 0.08, 0.12).finished(); }

TouchScene stretched_ball(double scale) {
  TouchScene scene;
  scene.objects.push_back({.mesh = made::shared(made::sphere(0.05 * scale, 12, 0.02)), .material = {}});
  MorphTarget target;
  for (std::uint32_t v = 0; v < scene.objects[0].mesh->vertices.size(); ++v) {
    target.vertices.push_back(v);
    target.displacements.push_back(whole_stretch() * scene.objects[0].mesh->vertices[v]);
  }
  scene.objects[0].deformation =
      std::make_shared<const MeshDeformation>(std::vector{target}, std::vector<MorphKey>{{0.0, {0.0}}, {0.7, {1.0}}, {1.4, {0.0}}}, true);
  return scene;
}

double weight_at(double time_s) {
  const double in_period = std::fmod(time_s, 1.4);
  return in_period < 0.7 ? in_period / 0.7 : 2.0 - in_period / 0.7;
}

// A hand that moves over the ball, into it and out of it.
Vec3 wandering_point(double time_s, double scale) {
  const double depth = 0.0005 * std::sin(21.0 * time_s);
  const Vec3 direction(std::cos(2.1 * time_s), std::sin(2.1 * time_s), std::sin(3.3 * time_s));
  return scale * ((0.049 + depth) * direction.normalized());
}

TEST(TouchedPlace, OfAnAffineDeformationIsWhatItsFormulaSays) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    const TouchScene scene = stretched_ball(scale);
    const auto method = make_method_for(scene);
    int places = 0;
    const AllocationGuard guard;
    for (int i = 0; i < 3000; ++i) {
      const double time_s = 1e-3 * i;
      const MethodOutput felt = method->step({.p_SD = wandering_point(time_s, scale), .dt_s = 1e-3, .time_s = time_s});
      if (!felt.contact) continue;
      const auto place = method->find_place(0);
      ASSERT_TRUE(place) << i;
      const Mat3 now = Mat3::Identity() + weight_at(time_s) * whole_stretch();
      ASSERT_LT((now * place->p_rest - felt.p_SP).norm(), 1e-8 * scale) << i;
      const double weight_change = weight_at(time_s) - weight_at(time_s - 1e-3);
      if (i > 0) {
        ASSERT_LT((weight_change * whole_stretch() * place->p_rest - place->moved).norm(), 1e-12 * scale) << i;
      }
      ++places;
    }
    EXPECT_TRUE(!AllocationGuard::is_available() || guard.count() == 0U);
    EXPECT_GT(places, 1000) << scale;
    EXPECT_FALSE(method->find_place(1));
  }
}

// The same deformation, by shapes that a program gives.
TEST(TouchedPlace, OfStreamedShapesIsThatOfKeyframes) {
  const TouchScene scene = stretched_ball(1.0);
  const auto mesh = scene.objects[0].mesh;
  auto streamed = StreamedMethod::make({}, mesh, {}, 0.02);
  ASSERT_TRUE(streamed) << streamed.error().what;
  std::vector<Vec3> wide = mesh->vertices;
  for (Vec3& p : wide) p += 0.5 * (whole_stretch() * p);
  auto stage = (*streamed)->stager().make((*streamed)->stager().rest(), wide);
  ASSERT_TRUE(stage) << stage.error().what;
  (void)(*streamed)->step({.p_SD = wandering_point(0.0, 1.0), .dt_s = 1e-3});
  (void)(*streamed)->offer_at(std::move(*stage), 0.1, 0.3);
  const auto share_at = [](double time_s) { return 0.5 * std::clamp((time_s - 0.1) / 0.3, 0.0, 1.0); };
  int places = 0;
  for (int i = 1; i < 600; ++i) {
    const double time_s = 1e-3 * i;
    const MethodOutput felt = (*streamed)->step({.p_SD = wandering_point(time_s, 1.0), .dt_s = 1e-3, .time_s = time_s});
    if (!felt.contact) continue;
    const auto place = (*streamed)->find_place(0);
    ASSERT_TRUE(place) << i;
    const Mat3 now = Mat3::Identity() + share_at(time_s) * whole_stretch();
    ASSERT_LT((now * place->p_rest - felt.p_SP).norm(), 1e-8) << i;
    const double weight_change = share_at(time_s) - share_at(time_s - 1e-3);
    ASSERT_LT((weight_change * whole_stretch() * place->p_rest - place->moved).norm(), 1e-12) << i;
    ++places;
  }
  EXPECT_GT(places, 50);
}

}  // namespace
}  // namespace hapton
