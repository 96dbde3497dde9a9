#include "tools/bench/evaluate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "core/geometry/mesh_shapes.h"
#include "tools/bench/bench_meshes.h"

namespace hapton {
namespace {

TouchScene bumpy_scene() {
  TouchScene scene;
  scene.objects.push_back({std::make_shared<TriangleMesh>(make_bumpy_sphere(0.045, 0.2, 1000, 3)), Material{}});
  return scene;
}

TEST(Evaluate, ThreadsChangeNothing) {
  const TouchScene scene = bumpy_scene();
  const auto trajectory = make_tap_trajectory(*scene.objects[0].mesh, {.seed = 4, .rows = 400});
  MethodSettings settings;
  settings.name = "reference";
  const auto with_one_thread = run_method(settings, scene, *trajectory, 1);
  const auto with_three_threads = run_method(settings, scene, *trajectory, 3);
  ASSERT_TRUE(with_one_thread.has_value() && with_three_threads.has_value());
  int contact_steps = 0;
  for (std::size_t i = 0; i < with_one_thread->size(); ++i) {
    ASSERT_EQ((*with_one_thread)[i].force_n, (*with_three_threads)[i].force_n);
    contact_steps += (*with_one_thread)[i].force_n.norm() > 0.0;
  }
  EXPECT_GT(contact_steps, 50);
}

TEST(Evaluate, ReferenceAgainstItselfHasNoError) {
  const TouchScene scene = bumpy_scene();
  const auto trajectory = make_slide_trajectory(*scene.objects[0].mesh, {.seed = 4, .rows = 600});
  EvaluationSettings settings;
  settings.method.name = "reference";
  const auto evaluation = evaluate_method(settings, scene, *trajectory);
  ASSERT_TRUE(evaluation.has_value());
  EXPECT_EQ(evaluation->error.error.most, 0.0);
  EXPECT_GT(evaluation->error.contact_steps, 300u);
  EXPECT_EQ(evaluation->error.fall_throughs + evaluation->error.stuck_steps + evaluation->error.discontinuities +
                evaluation->error.false_contacts,
            0u);
  EXPECT_THAT(to_text(*evaluation), ::testing::HasSubstr("fall-throughs 0, false contacts 0, stuck steps 0, force discontinuities 0"));
  EXPECT_THAT(to_json(*evaluation), ::testing::HasSubstr("\"branch_switches\""));
}

TEST(Evaluate, ProxyIsWithinATenthOfAPercentInAllButAHundredthOfTheSteps) {
  const TouchScene scene = bumpy_scene();
  const auto trajectory = make_slide_trajectory(*scene.objects[0].mesh, {.seed = 4, .rows = 1000});
  EvaluationSettings settings;
  settings.method.name = "proxy";
  const auto evaluation = evaluate_method(settings, scene, *trajectory);
  ASSERT_TRUE(evaluation.has_value());
  EXPECT_LT(evaluation->error.error.p99, 1e-3);
  EXPECT_EQ(evaluation->error.fall_throughs, 0u);
}

// Slides in which proxy and reference once went different ways; each ends just after that row. A note below names the one that was wrong.
struct Row {
  const char* mesh;
  std::uint64_t seed;
  std::size_t row;
  bool has_friction;
};

class EvaluatedRow : public ::testing::TestWithParam<Row> {};

TEST_P(EvaluatedRow, ProxyAndReferenceGoTheSameWay) {
  const Row row = GetParam();
  const auto mesh = make_bench_mesh(row.mesh, std::filesystem::path(HAPTON_SOURCE_DIR) / "meshes");
  ASSERT_TRUE(mesh.has_value()) << mesh.error().what;
  TouchScene scene;
  Material material;
  if (row.has_friction) {
    material.friction_static = 0.5;
    material.friction_dynamic = 0.4;
  }
  scene.objects.push_back({mesh->mesh, material});
  const auto whole = make_slide_trajectory(*mesh->mesh, {.seed = row.seed, .rows = 2000});
  ASSERT_TRUE(whole.has_value());
  TouchTrajectory trajectory = *whole;
  trajectory.p_SD.resize(row.row + 20);
  EvaluationSettings settings;
  settings.method.name = "proxy";
  const auto evaluation = evaluate_method(settings, scene, trajectory);
  ASSERT_TRUE(evaluation.has_value());
  EXPECT_EQ(evaluation->error.branch_switches, 0u)
      << "at worst " << evaluation->error.error.most << " in row " << evaluation->error.worst_step;
  EXPECT_EQ(evaluation->error.false_contacts + evaluation->error.fall_throughs, 0u);
}

INSTANTIATE_TEST_SUITE_P(Rows, EvaluatedRow,
                         ::testing::Values(Row{"mountain_51k_open.ply", 3, 849, true},      // proxy: held at an edge for ever
                                           Row{"octagonal_pocket.ply", 2, 564, true},       // the same
                                           Row{"nefertiti_70k.ply", 1, 1227, true},         // reference: contacts of its sphere at a vertex
                                           Row{"demosthenes_17k_open.obj", 1, 1626, true},  // the same
                                           Row{"toycar_full_109k.glb", 3, 788, true},       // the same
                                           Row{"wingnut.obj", 2, 298, true},                // reference: beside a concave edge
                                           Row{"demosthenes_17k_open.obj", 2, 618, false}),  // proxy: stuck a step too long at a boundary
                         [](const auto& test) {
                           std::string name = test.param.mesh;
                           std::replace_if(
                               name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
                           return name + "_" + std::to_string(test.param.seed) + (test.param.has_friction ? "_friction" : "");
                         });

TEST(Evaluate, AShadedForceIsComparedWithTheUnshadedReferenceAndSaysSo) {
  const TouchScene scene = bumpy_scene();
  const auto trajectory = make_slide_trajectory(*scene.objects[0].mesh, {.seed = 4, .rows = 600});
  EvaluationSettings settings;
  const auto plain = evaluate_method(settings, scene, *trajectory);
  settings.method.shading = 1.0;
  const auto shaded = evaluate_method(settings, scene, *trajectory);
  ASSERT_TRUE(plain.has_value() && shaded.has_value());
  for (std::size_t i = 0; i < plain->reference.size(); ++i) {
    ASSERT_EQ(shaded->reference[i].force_n, plain->reference[i].force_n);
    ASSERT_EQ(shaded->method[i].proxy, plain->method[i].proxy);
  }
  EXPECT_GT(shaded->error.direction_rad.p50, 10.0 * plain->error.direction_rad.p50);
  EXPECT_THAT(to_text(*shaded), ::testing::HasSubstr("force shading 1: the shaded force against the unshaded reference"));
  EXPECT_THAT(to_json(*shaded), ::testing::HasSubstr("\"shading\": 1.0"));
  EXPECT_THAT(to_json(*shaded), ::testing::HasSubstr("\"reference_shading\": 0.0"));
  EXPECT_THAT(to_text(*plain), ::testing::Not(::testing::HasSubstr("shading")));
}

TEST(Evaluate, SaysWhyAMethodCannotRun) {
  MethodSettings settings;
  settings.name = "no such method";
  const auto samples = run_method(settings, bumpy_scene(), TouchTrajectory{.p_SD = {Vec3::Zero()}}, 1);
  ASSERT_FALSE(samples);
  EXPECT_THAT(samples.error().what, testing::StartsWith("method 'no such method' is not known; choose one of: "));
}

}  // namespace
}  // namespace hapton
