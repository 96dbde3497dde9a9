#include "bench/measure/method_run.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

// Methods that are compared with the reference compute the effects of the scene, so the reference must compute them too.
TEST(RunReference, HasTheEffectsOfTheScene) {
  const auto sheet = std::make_shared<const TriangleMesh>(make_plane_grid(0.1, 4));
  const TouchScene plain{.objects = {{.mesh = sheet, .material = {}}}};
  TouchScene scene = plain;
  scene.objects[0].effects.progressive.n_per_m2 = 1e5;
  TouchTrajectory trajectory;
  for (int i = 0; i < 20; ++i) trajectory.p_SD.emplace_back(1e-4 * i, 0.003, 1e-3 - 2e-4 * i);
  const auto reference = run_reference(Stopwatch::calibrate(), scene, trajectory, 0.0);
  ASSERT_TRUE(reference) << reference.error().what;
  const auto with_effects = compute_forces({.name = "reference"}, scene, trajectory);
  ASSERT_TRUE(with_effects) << with_effects.error().what;
  const auto without_effects = compute_forces({.name = "reference"}, plain, trajectory);
  ASSERT_TRUE(without_effects) << without_effects.error().what;
  ASSERT_EQ(reference->felt.size(), with_effects->size());
  for (std::size_t i = 0; i < with_effects->size(); ++i) EXPECT_EQ(reference->felt[i].force_n, (*with_effects)[i].force_n) << i;
  EXPECT_GT((reference->felt.back().force_n - without_effects->back().force_n).norm(), 0.1) << "the effect acts";
}

}  // namespace
}  // namespace hapton
