#include "scene/touch_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>

#include "core/geometry/cracked_shapes.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "scene/mesh_file.h"
#include "scene/mesh_report.h"
#include "scene/scene_file.h"
#include "scene/scene_report.h"
#include "tests/scene/sample_files.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class TouchMeshes : public ::testing::Test {
 protected:
  TouchMeshes() {
    folder_.write("cracked.obj", sample::obj(make_torn(make_box(Vec3(0.1, 0.08, 0.06), 2), 5e-6)));
    folder_.write("whole.obj", sample::obj(make_box(Vec3(0.1, 0.08, 0.06), 2)));
  }
  ScratchFolder folder_;
};

TEST_F(TouchMeshes, AreSealedWhenTheyAreLoaded) {
  const auto touch = load_touch_mesh(folder_.path() / "cracked.obj");
  ASSERT_TRUE(touch) << touch.error().what;
  EXPECT_TRUE(count_edges(touch->mesh).closed());
  EXPECT_THAT(touch->notes, ElementsAre(AllOf(HasSubstr("sealed cracks up to"), HasSubstr("0 of 144 left"))));
  EXPECT_THAT(load_touch_mesh(folder_.path() / "whole.obj")->notes, IsEmpty());
}

TEST_F(TouchMeshes, AreLeftAsTheyAreOnRequest) {
  const auto touch = load_touch_mesh(folder_.path() / "cracked.obj", std::nullopt, CrackSealing::off);
  ASSERT_TRUE(touch) << touch.error().what;
  EXPECT_EQ(touch->mesh.triangles, load_mesh_file(folder_.path() / "cracked.obj")->mesh.triangles);
  EXPECT_THAT(touch->notes, IsEmpty());
}

TEST_F(TouchMeshes, AreSealedInMeshFilesAndInScenes) {
  const auto mesh = load_scene(folder_.path() / "cracked.obj");
  ASSERT_TRUE(mesh) << mesh.error().what;
  EXPECT_TRUE(count_edges(*mesh->objects[0].mesh).closed());
  EXPECT_THAT(mesh->notes, ElementsAre(HasSubstr("sealed cracks")));
  const auto scene = load_scene(folder_.write("a.toml",
                                              "[[object]]\nmesh = 'cracked.obj'\n[[object]]\nmesh = 'cracked.obj'\nscale = 2.0\n"
                                              "[[object]]\nmesh = 'cracked.obj'\nseal_cracks = false\n"));
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_TRUE(count_edges(*scene->objects[0].mesh).closed());
  EXPECT_TRUE(count_edges(*scene->objects[1].mesh).closed());
  EXPECT_EQ(count_edges(*scene->objects[2].mesh).boundary, 144U);
  EXPECT_THAT(scene->notes, ElementsAre(AllOf(HasSubstr("cracked.obj: sealed cracks"), HasSubstr("144"))));  // one note for both objects
  const auto unsealed = load_scene(folder_.path() / "a.toml", {.sealing = CrackSealing::off});
  ASSERT_TRUE(unsealed);
  EXPECT_EQ(count_edges(*unsealed->objects[0].mesh).boundary, 144U);
  EXPECT_THAT(unsealed->notes, IsEmpty());
  EXPECT_THAT(load_scene(folder_.write("b.toml", "[[object]]\nmesh = 'cracked.obj'\nseal_cracks = 1\n")).error().what,
              HasSubstr("'seal_cracks' in [[object]] 1 must be true or false"));
}

// The drawn mesh is not changed by the sealing of the touched one, and both are in the same place.
TEST_F(TouchMeshes, FittedAreInTheSamePlaceSealedAndUnsealed) {
  const auto path = folder_.write("fit.toml",
                                  "fit_m = [0.3, 0.3, 0.3]\n[[object]]\nmesh = 'cracked.obj'\n[[object]]\nmesh = 'whole.obj'\n"
                                  "position_m = [0.01, 0.02, 0.03]\nrotation_deg = [10, 20, 30]\nscale = 0.5\n");
  const auto touched = load_scene(path);
  const auto drawn = load_scene(path, {.sealing = CrackSealing::off});
  ASSERT_TRUE(touched && drawn);
  EXPECT_EQ(touched->objects[1].mesh->vertices, drawn->objects[1].mesh->vertices);
  for (const Vec3& vertex : touched->objects[0].mesh->vertices) EXPECT_THAT(drawn->objects[0].mesh->vertices, ::testing::Contains(vertex));
  EXPECT_LT(touched->objects[0].mesh->vertices.size(), drawn->objects[0].mesh->vertices.size());
  const SealReport& sealed = touched->objects[0].sealed;
  EXPECT_NEAR(sealed.tolerance, 1e-4 * 0.3, 1e-9);  // in metres of the fitted scene, not in those of the file
  EXPECT_GT(sealed.widest_gap, 1e-5);
  EXPECT_FALSE(drawn->objects[0].sealed.has_sealed());
}

TEST_F(TouchMeshes, TheReportSaysWhatWillBeSealed) {
  const auto report = make_mesh_report(folder_.path() / "cracked.obj", std::nullopt);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_EQ(report->flaws.topology.boundary_edges, 144U);
  EXPECT_THAT(to_text(*report), HasSubstr("sealed cracks up to"));
  EXPECT_THAT(to_json(*report), HasSubstr("\"boundary_edges_left\": 0"));
  EXPECT_THAT(to_text(*report), HasSubstr("yes (0 boundary edges: 0 open, 0 of cracks)"));
  EXPECT_TRUE(report->is_closed_for_touch());
  folder_.write("sheet.obj", sample::obj(make_torn(make_plane_grid(0.1, 4), 5e-6)));
  const auto sheet = make_mesh_report(folder_.path() / "sheet.obj", std::nullopt);
  EXPECT_THAT(to_text(*sheet), HasSubstr("no (16 boundary edges: 16 open, 0 of cracks)"));
  EXPECT_THAT(to_json(*sheet), HasSubstr("\"open_border_edges_left\": 16"));
  const auto scene = make_scene_report(folder_.write("scene.toml", "[[object]]\nmesh = 'cracked.obj'\nscale = 2.0\n"));
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_THAT(to_text(*scene), HasSubstr("0 of 144 left"));
  EXPECT_THAT(to_json(*scene), HasSubstr("\"boundary_edges_left\": 0"));
  EXPECT_THAT(to_text(*make_mesh_report(folder_.path() / "whole.obj", std::nullopt)), HasSubstr("nothing to seal"));
}

// Meshes with cracks from scans and CAD exports. Another program found the same numbers of boundary edges (mesh_report_test.cpp).
struct SealedFile {
  const char* file;
  std::size_t boundary_edges;
  std::size_t max_edges_left;
  bool is_closed;
};

void PrintTo(const SealedFile& sealed, std::ostream* out) { *out << sealed.file; }

class SealedFiles : public ::testing::TestWithParam<SealedFile> {};

TEST_P(SealedFiles, LoseTheirCracks) {
  const auto report = make_mesh_report(std::string(HAPTON_SOURCE_DIR "/meshes/") + GetParam().file, std::nullopt);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_EQ(report->flaws.topology.boundary_edges, GetParam().boundary_edges);
  EXPECT_EQ(report->sealed.boundary_edges, GetParam().boundary_edges);
  EXPECT_LE(report->sealed.boundary_edges_left, GetParam().max_edges_left);
  EXPECT_EQ(report->borders_left.open + report->borders_left.cracks, report->sealed.boundary_edges_left);
  EXPECT_EQ(report->is_closed_for_touch(), GetParam().is_closed);
}

INSTANTIATE_TEST_SUITE_P(OfTheProject, SealedFiles,
                         ::testing::Values(SealedFile{"featuretype.stl", 576, 0, true}, SealedFile{"octagonal_pocket.ply", 54, 0, true},
                                           SealedFile{"toycar_full_109k.glb", 3842, 3060, false},
                                           SealedFile{"car_body_20k.glb", 1682, 1681, false},
                                           SealedFile{"car_front_3300.obj", 454, 454, false},
                                           SealedFile{"demosthenes_17k_open.obj", 67, 67, false},
                                           SealedFile{"tray_bottom_thin.stl", 0, 0, true}),
                         [](const auto& sealed) {
                           std::string name = sealed.param.file;
                           std::replace_if(
                               name.begin(), name.end(), [](char c) { return c == '.'; }, '_');
                           return name;
                         });

}  // namespace
}  // namespace hapton
