// The method `sweep` of the memo against its brute-force twin, on every mesh that comes with the project.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "core/force/sweep/sweep_method.h"
#include "scene/mesh_file.h"
#include "tests/support/brute_force_sweep.h"

namespace hapton {
namespace {

std::vector<std::string> mesh_names() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(HAPTON_SOURCE_DIR "/meshes")) {
    if (is_mesh_file_name(entry.path())) {
      names.push_back(entry.path().filename().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

class SweepOnMeshes : public ::testing::TestWithParam<std::string> {};

TEST_P(SweepOnMeshes, EqualsTheTwin) {
  constexpr std::uint64_t kSeed = 2;
  RecordProperty("seed", std::to_string(kSeed));
  const auto file = load_mesh_file(std::filesystem::path(HAPTON_SOURCE_DIR "/meshes") / GetParam());
  ASSERT_TRUE(file) << file.error().what;
  const auto mesh = std::make_shared<const TriangleMesh>(file->mesh);
  Vec3 low = mesh->vertices.front();
  Vec3 high = low;
  for (const Vec3& v : mesh->vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  const double size = (high - low).maxCoeff();

  MethodSettings settings;
  settings.offset_m = 1e-4 * size;
  const TouchScene scene = {.objects = {{mesh, {}}}};
  const double stiffness_n_per_m = scene.objects.front().material.stiffness_n_per_m;
  const auto made = SweepMethod::make(settings, scene);
  ASSERT_TRUE(made) << made.error().what;
  auto& method = static_cast<SweepMethod&>(**made);
  made::BruteForceSweep twin(scene, settings.offset_m);

  // Walks that start off a random triangle, press into it and slide, with a jump at the end of each.
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal(0.0, 1.0);
  const auto random_vector = [&] { return Vec3(normal(random), normal(random), normal(random)); };
  const std::size_t walk_count = std::clamp<std::size_t>(2'000'000 / (mesh->triangles.size() * 25), 4, 40);
  std::size_t contacts = 0;
  for (std::size_t walk = 0; walk < walk_count; ++walk) {
    const std::size_t t = random() % mesh->triangles.size();
    const Vec3 target = (mesh->corner(t, 0) + mesh->corner(t, 1) + mesh->corner(t, 2)) / 3.0;
    const Vec3 approach = 0.02 * size * random_vector().normalized();
    Vec3 p = target + approach;
    method.reset(p);
    twin.reset(p);
    for (int i = 0; i < 25; ++i) {
      p += i == 24 ? Vec3(0.5 * size * random_vector()) : Vec3((i < 10 ? -0.13 : 0.0) * approach + 0.001 * size * random_vector());
      const std::uint64_t collisions_before = method.counters().collisions;
      const MethodOutput output = method.step({.p_SD = p});
      const MethodOutput expected = twin.step(p);
      // The twin rounds differently.
      ASSERT_LE((output.force_n - expected.force_n).norm(), 1e-12 * stiffness_n_per_m * size) << "walk " << walk << " step " << i;
      ASSERT_LE((output.p_SP - expected.p_SP).norm(), 1e-12 * size) << "walk " << walk << " step " << i;
      ASSERT_EQ(method.counters().collisions - collisions_before, twin.collisions) << "walk " << walk << " step " << i;
      contacts += output.contact ? 1 : 0;
    }
  }
  EXPECT_GT(contacts, 10 * walk_count);
  const GridOccupancy& occupancy = method.grid().occupancy();
  EXPECT_GT(occupancy.occupied_share(), 0.001);
  EXPECT_LT(occupancy.occupied_share(), 0.6);
}

INSTANTIATE_TEST_SUITE_P(Meshes, SweepOnMeshes, ::testing::ValuesIn(mesh_names()), [](const auto& test) {
  std::string name = test.param;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '.' || c == '-'; }, '_');
  return name;
});

}  // namespace
}  // namespace hapton
