#include "scene/mesh_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// Another program computed these figures, not Hapton.
struct Figures {
  const char* file;
  std::size_t triangles, file_vertices, vertices, boundary_edges, nonmanifold_edges, inconsistent_edges, nonmanifold_vertices;
  std::size_t degenerate_triangles, needle_triangles, duplicate_triangles, components, parts;
  double extents[3];
  double signed_volume;
  bool closed;
};

const Figures kFigures[] = {
    {"CesiumMilkTruck.gltf", 3624, 3564, 1840, 8, 0, 0, 2, 0, 110, 0, 13, 3, {4.86891, 2.58292, 2.792}, 19.249, false},
    {"barkour_body_dirty.stl", 23390, 70170, 10699, 0, 295, 0, 24, 0, 69, 171, 166, 1, {0.279306, 0.210175, 0.10468}, 0.0012726, false},
    {"car_body_20k.glb", 20000, 10841, 10841, 1682, 0, 0, 13, 0, 700, 0, 47, 1, {1.87083, 1.16246, 3.83788}, 5.3332, false},
    {"car_front_3300.obj", 3300, 1876, 1876, 454, 0, 0, 12, 0, 68, 0, 30, 1, {1872.91, 933.204, 1137.2}, 1.6375e+09, false},
    {"demosthenes_17k_open.obj", 16719, 8394, 8394, 67, 0, 0, 0, 0, 0, 0, 1, 1, {1.75077, 2.69362, 1.5354}, 1.9461, false},
    {"featuretype.stl", 3476, 10428, 2010, 576, 0, 0, 0, 0, 78, 0, 1, 1, {5, 2.5, 1.375}, 11.628, false},
    {"fish_22k.obj", 21568, 10786, 10786, 0, 0, 0, 0, 0, 0, 0, 1, 1, {1.47021, 1.6731, 2.80063}, 1.3529, true},
    {"kenney_motorcycle.glb", 960, 1786, 504, 0, 16, 0, 0, 0, 0, 0, 15, 4, {1.09004, 1.26603, 2.43506}, 0.59987, false},
    {"mosquito_dirty.glb", 14349, 18678, 10140, 4208, 157, 99, 65, 0, 5, 0, 1208, 3, {0.0972461, 0.0996699, 0.0879222}, 0.00041097, false},
    {"mountain_51k_open.ply", 50562, 25600, 25600, 636, 0, 0, 0, 0, 0, 0, 1, 1, {32.9878, 17.8561, 32.9824}, 6920.3, false},
    {"multibody_ascii.stl", 32, 96, 20, 0, 0, 12, 0, 0, 0, 0, 2, 2, {0.636032, 1.08843, 0.339928}, 0.0036977, false},
    {"nefertiti_70k.ply", 70000, 35002, 35002, 0, 0, 0, 0, 0, 0, 0, 1, 1, {238.733, 494.656, 362.599}, 1.1553e+07, true},
    {"nist_assembly_insert.obj", 7216, 3592, 3544, 0, 75, 0, 0, 28, 424, 6, 18, 6, {0.5, 0.655, 0.186}, 0.0081938, false},
    {"nist_pump_assembly.glb", 1712, 856, 826, 0, 29, 0, 3, 0, 17, 6, 2, 8, {0.119989, 0.12, 0.12}, 0.00092724, false},
    {"octagonal_pocket.ply", 3262, 1658, 1658, 54, 0, 0, 3, 0, 92, 0, 2, 1, {0.2286, 0.164715, 0.015875}, 0.00025035, false},
    {"skull_100k.ply", 100002, 49999, 49999, 0, 0, 0, 0, 0, 30, 0, 1, 1, {8.68849, 13.9027, 12.1119}, 563.42, true},
    {"toycar_full_109k.glb", 108936, 77429, 56394, 3842, 0, 0, 13, 0, 2101, 0, 50, 3, {0.0734429, 0.0288229, 0.0739623}, 1.1876e-05, false},
    {"tray_bottom_thin.stl", 4520, 13560, 2216, 0, 0, 0, 0, 0, 438, 0, 1, 1, {355.6, 3.175, 355.6}, 3.4787e+05, true},
    {"wingnut.obj", 6090, 3047, 3047, 0, 0, 0, 0, 0, 2, 0, 1, 1, {3.02667, 4.27549, 7.19874}, 22.097, true},
};

void PrintTo(const Figures& figures, std::ostream* out) { *out << figures.file; }

// Equal up to the digits with which the figure was written.
void expect_equal_to_digits(double value, double figure, int digits) {
  EXPECT_NEAR(value, figure, std::abs(figure) * std::pow(10.0, 1 - digits));
}

class MeshReports : public ::testing::TestWithParam<Figures> {};

TEST_P(MeshReports, AgreeWithTheFiguresOfTheMeshes) {
  const Figures& expected = GetParam();
  const auto report = make_mesh_report(std::string(HAPTON_SOURCE_DIR "/meshes/") + expected.file, std::nullopt);
  ASSERT_TRUE(report) << report.error().what;
  const MeshTopology& t = report->flaws.topology;
  EXPECT_EQ(t.triangles, expected.triangles);
  EXPECT_EQ(report->file.file_vertices, expected.file_vertices);
  EXPECT_EQ(t.vertices, expected.vertices);
  EXPECT_EQ(t.boundary_edges, expected.boundary_edges);
  EXPECT_EQ(t.nonmanifold_edges, expected.nonmanifold_edges);
  EXPECT_EQ(t.inconsistent_edges, expected.inconsistent_edges);
  EXPECT_EQ(t.nonmanifold_vertices, expected.nonmanifold_vertices);
  EXPECT_EQ(t.degenerate_triangles, expected.degenerate_triangles);
  EXPECT_EQ(t.needle_triangles, expected.needle_triangles);
  EXPECT_EQ(t.duplicate_triangles, expected.duplicate_triangles);
  EXPECT_EQ(t.components, expected.components);
  EXPECT_EQ(report->file.parts.size(), expected.parts);
  EXPECT_EQ(report->flaws.borders.open + report->flaws.borders.cracks, expected.boundary_edges);
  EXPECT_EQ(report->flaws.repair.dropped_duplicates + report->flaws.repair.double_faces, expected.duplicate_triangles);
  EXPECT_EQ(t.is_closed(), expected.closed);
  for (int axis = 0; axis < 3; ++axis) expect_equal_to_digits(t.highest[axis] - t.lowest[axis], expected.extents[axis], 6);
  expect_equal_to_digits(t.signed_volume, expected.signed_volume, 5);
}

INSTANTIATE_TEST_SUITE_P(OfEveryMesh, MeshReports, ::testing::ValuesIn(kFigures));

TEST(MeshReport, SaysTheSameAsTextAndAsJson) {
  const auto report = make_mesh_report(HAPTON_SOURCE_DIR "/meshes/tray_bottom_thin.stl", Unit::mm);
  ASSERT_TRUE(report) << report.error().what;
  const std::string text = to_text(*report);
  EXPECT_THAT(text, HasSubstr("0.3556 x 0.003175 x 0.3556 m"));
  EXPECT_THAT(text, HasSubstr("ASCII STL, numbers read as mm"));
  const auto json = nlohmann::json::parse(to_json(*report));
  EXPECT_EQ(json["triangles"], 4520);
  EXPECT_EQ(json["vertices"], 2216);
  EXPECT_EQ(json["file_vertices"], 13560);
  EXPECT_EQ(json["closed"], true);
  EXPECT_EQ(json["unit"], "mm");
  EXPECT_NEAR(json["highest_m"][0].get<double>(), 0.3556, 1e-9);
}

TEST(MeshReport, SaysWhatSmoothWouldRepair) {
  const auto report = make_mesh_report(HAPTON_SOURCE_DIR "/meshes/multibody_ascii.stl", std::nullopt);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_GT(report->flaws.repair.turned, 0U);
  EXPECT_THAT(to_text(*report), HasSubstr(report->flaws.repair.describe()));
  EXPECT_EQ(nlohmann::json::parse(to_json(*report))["repair"]["turned"], report->flaws.repair.turned);
}

// A square of two triangles, once with one of them repeated, once with one of them repeated in the opposite winding.
TEST(MeshReport, DistinguishesDuplicatesFromDoubleFaces) {
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
  const ScratchFolder folder;
  const auto twice = make_mesh_report(folder.write("twice.obj", square + "f 2 3 1\n"), std::nullopt);
  const auto both_sides = make_mesh_report(folder.write("both.obj", square + "f 1 3 2\n"), std::nullopt);
  ASSERT_TRUE(twice && both_sides);
  EXPECT_THAT(to_text(twice->flaws), HasSubstr("duplicates 1"));
  EXPECT_THAT(to_text(twice->flaws), Not(HasSubstr("double faces")));
  EXPECT_THAT(to_text(both_sides->flaws), HasSubstr("double faces 1"));
  EXPECT_THAT(to_text(both_sides->flaws), Not(HasSubstr("duplicates")));
}

// "no (0 boundary edges)" alone would not tell the reason.
TEST(MeshReport, SaysWhyASurfaceWithoutABoundaryIsNotClosed) {
  const ScratchFolder scratch;
  // A tetrahedron with one face the other way round: three edges whose triangles face opposite sides.
  const auto flipped = make_mesh_report(
      scratch.write("flipped.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 3 4\n"), std::nullopt);
  ASSERT_TRUE(flipped) << flipped.error().what;
  EXPECT_THAT(to_text(*flipped), HasSubstr("no (0 boundary edges: 0 open, 0 of cracks; 3 inconsistent edges)\n"));
  // Two tetrahedra that share one corner.
  const auto pinched = make_mesh_report(scratch.write("pinched.obj",
                                                      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
                                                      "v -1 0 0\nv 0 -1 0\nv 0 0 -1\nf 1 5 6\nf 1 6 7\nf 5 7 6\nf 1 7 5\n"),
                                        std::nullopt);
  ASSERT_TRUE(pinched) << pinched.error().what;
  EXPECT_THAT(to_text(*pinched), HasSubstr("no (0 boundary edges: 0 open, 0 of cracks; 1 non-manifold vertices)\n"));
  const auto good =
      make_mesh_report(scratch.write("good.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"), std::nullopt);
  ASSERT_TRUE(good) << good.error().what;
  EXPECT_THAT(to_text(*good), HasSubstr("yes (0 boundary edges: 0 open, 0 of cracks)\n"));
}

TEST(MeshReport, SaysThatABodyIsInsideOut) {
  const ScratchFolder folder;
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  const auto right = make_mesh_report(folder.write("right.obj", vertices + "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"), std::nullopt);
  const auto wrong = make_mesh_report(folder.write("wrong.obj", vertices + "f 1 2 3\nf 1 4 2\nf 2 4 3\nf 1 3 4\n"), std::nullopt);
  ASSERT_TRUE(right && wrong);
  EXPECT_THAT(to_text(*right), Not(HasSubstr("inside out")));
  EXPECT_THAT(to_text(*wrong), HasSubstr("1 of 1 closed body is inside out"));
  EXPECT_THAT(to_text(wrong->flaws), HasSubstr("bodies inside out 1"));
  EXPECT_EQ(nlohmann::json::parse(to_json(*wrong))["bodies_inside_out"], 1);
}

// Two squares side by side with a gap of 1e-4: six edges are on the outer boundary, two face each other across the gap.
TEST(MeshReport, DistinguishesCracksFromBoundaries) {
  const ScratchFolder folder;
  const auto report = make_mesh_report(folder.write("a.obj",
                                                    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1.0001 0 0\nv 2 0 0\nv 2 1 0\nv 1.0001 1 0\n"
                                                    "f 1 2 3\nf 1 3 4\nf 5 6 7\nf 5 7 8\n"),
                                       std::nullopt);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_EQ(to_text(report->flaws), "not closed: open boundary edges 6, crack edges 2");
}

TEST(MeshReport, SaysThatNotAllCracksWereLookedFor) {
  auto report = make_mesh_report(HAPTON_SOURCE_DIR "/meshes/featuretype.stl", std::nullopt);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_THAT(to_text(*report), Not(HasSubstr("not all cracks")));
  EXPECT_TRUE(nlohmann::json::parse(to_json(*report)).at("crack_edges_all_counted").get<bool>());
  report->flaws.borders.has_given_up = true;
  EXPECT_THAT(to_text(*report), HasSubstr("not all cracks were looked for: too many boundary edges lie across each other"));
  EXPECT_THAT(to_text(report->flaws), HasSubstr(", not all cracks looked for"));
  EXPECT_FALSE(nlohmann::json::parse(to_json(*report)).at("crack_edges_all_counted").get<bool>());
}

TEST(MeshReport, WritesValidJsonWhateverAPartIsCalled) {
  const ScratchFolder folder;
  const auto report = make_mesh_report(folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\no \"q\xff\\\nf 1 2 3\n"), std::nullopt);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_TRUE(nlohmann::json::accept(to_json(*report)));
}

}  // namespace
}  // namespace hapton
