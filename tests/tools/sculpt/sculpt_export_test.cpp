#include "tools/sculpt/sculpt_export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "scene/annotations_file.h"
#include "scene/mesh_file.h"
#include "scene/scene_file.h"
#include "tests/support/file_size_limit.h"
#include "tests/support/scratch_folder.h"
#include "tests/tools/command_run.h"

namespace hapton {
namespace {

using testing::HasSubstr;

// A slab of clay, 60 x 60 x 20 mm, and a slab that nobody carves.
struct SculptExportTest : testing::Test {
  SculptExportTest() {
    folder.write(
        "slab.obj",
        "v -0.03 -0.03 -0.01\nv 0.03 -0.03 -0.01\nv 0.03 0.03 -0.01\nv -0.03 0.03 -0.01\nv -0.03 -0.03 0.01\nv 0.03 -0.03 0.01\n"
        "v 0.03 0.03 0.01\nv -0.03 0.03 0.01\nf 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\n"
        "f 4 1 5\nf 4 5 8\n");
    scene = folder
                .write("clay.toml",
                       "[[object]]\nmesh = \"slab.obj\"\nname = \"clay\"\nsculpt = true\nvoxel_mm = 1\n\n[[object]]\nmesh = \"slab.obj\"\n"
                       "name = \"stone\"\nposition_m = [0.1, 0, 0]\n")
                .string();
    Annotations notes;
    notes.objects = {"clay", "stone"};
    notes.carved = {
        {.object = 0, .radius_m = 0.005F, .carves = {{.from_m = Vec3(0, 0, 0.02), .to_m = Vec3(0, 0, -0.02), .radius_m = 0.005F}}}};
    annotations = folder.write("notes.toml", write_annotations(notes, load_scene(scene)->given_hash)).string();
  }
  std::string out(const char* name) const { return (folder.path() / name).string(); }

  ScratchFolder folder;
  std::string scene, annotations;
};

TEST_F(SculptExportTest, TheHoleIsInEveryFormat) {
  for (const char* name : {"clay.stl", "clay.obj", "clay.ply"}) {
    const CommandRun run = run_hapton({"sculpt", scene, "--annotations", annotations, "--out", out(name)});
    ASSERT_EQ(run.code, 0) << run.err;
    EXPECT_THAT(run.out, HasSubstr("1 carves of one object"));
    const auto file = load_mesh_file(out(name));
    ASSERT_TRUE(file) << file.error().what;
    double volume = 0.0;
    const TriangleMesh& mesh = file->mesh;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      volume += mesh.corner(t, 0).dot(mesh.corner(t, 1).cross(mesh.corner(t, 2))) / 6.0;
    }
    EXPECT_NEAR(volume, 0.06 * 0.06 * 0.02 - std::numbers::pi * 0.005 * 0.005 * 0.02, 0.02 * 0.06 * 0.06 * 0.02) << name;
    for (const Vec3& v : mesh.vertices) ASSERT_FALSE(v.head<2>().norm() < 0.0045 && std::abs(v.z()) < 0.008) << "in the hole";
  }
}

// One slab lies above the other: each carve passes through both, but belongs to one of them.
TEST_F(SculptExportTest, TwoBodiesAreInOneFileEachWithItsOwnCarves) {
  const std::string slab = "[[object]]\nmesh = \"slab.obj\"\nsculpt = true\nvoxel_mm = 1\n";
  const std::string two_bodies =
      folder.write("two.toml", slab + "name = \"upper\"\n\n" + slab + "name = \"lower\"\nposition_m = [0, 0, -0.04]\n").string();
  const auto press = [](std::int32_t object, double x) {
    return CarvedPress{
        .object = object, .radius_m = 0.005F, .carves = {{.from_m = Vec3(x, 0, 0.02), .to_m = Vec3(x, 0, -0.06), .radius_m = 0.005F}}};
  };
  Annotations notes;
  notes.objects = {"upper", "lower"};
  notes.carved = {press(1, -0.015), press(0, 0.015)};
  const std::string file = folder.write("two-notes.toml", write_annotations(notes, load_scene(two_bodies)->given_hash)).string();
  const CommandRun run = run_hapton({"sculpt", two_bodies, "--annotations", file, "--out", out("two.ply")});
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("2 carves of 2 objects"));
  const auto read = load_mesh_file(out("two.ply"));
  ASSERT_TRUE(read) << read.error().what;
  const TriangleMesh& mesh = read->mesh;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) ASSERT_LT((mesh.corner(t, k) - mesh.corner(t, (k + 1) % 3)).norm(), 0.005) << "a triangle of both";
  }
  const auto has_hole = [&](double x, double top) {
    return std::ranges::none_of(mesh.vertices, [&](const Vec3& v) { return (v - Vec3(x, 0, top)).norm() < 0.004; });
  };
  EXPECT_TRUE(has_hole(0.015, 0.01));
  EXPECT_FALSE(has_hole(-0.015, 0.01));
  EXPECT_FALSE(has_hole(0.015, -0.03));
  EXPECT_TRUE(has_hole(-0.015, -0.03));
}

TEST_F(SculptExportTest, OnAFullDiskThereIsOneLineAndNoFile) {
  const std::size_t file_count = static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder.path()), {}));
  CommandRun run;
  {
    const FileSizeLimit full(20'000);
    run = run_hapton({"sculpt", scene, "--annotations", annotations, "--out", out("clay.stl")});
  }
  EXPECT_NE(run.code, 0);
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  EXPECT_THAT(run.err, HasSubstr("cannot write " + out("clay.stl") + ": File too large"));
  EXPECT_EQ(static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder.path()), {})), file_count);
}

// A scene may take minutes to read, so the output is checked first.
TEST_F(SculptExportTest, AnOutputThatCannotBeWrittenIsRejectedBeforeTheWork) {
  const CommandRun run = run_hapton({"sculpt", out("none.toml"), "--annotations", annotations, "--out", out("slab.obj/clay.stl")});
  EXPECT_EQ(run.code, 2);
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  EXPECT_THAT(run.err, HasSubstr("--out: " + out("slab.obj") + " cannot be a folder"));
}

TEST_F(SculptExportTest, WrongInputIsOneLine) {
  const auto error = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "sculpt");
    const CommandRun run = run_hapton(arguments);
    EXPECT_EQ(run.code, 2);
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    return run.err;
  };
  EXPECT_THAT(error({scene, "--annotations", annotations, "--out", out("clay.vtp")}), HasSubstr(".stl, .obj or .ply"));
  EXPECT_THAT(error({scene, "--annotations", out("none.toml"), "--out", out("clay.stl")}), HasSubstr("none.toml"));
  EXPECT_THAT(error({scene, "--annotations", annotations, "--out", out("clay.stl"), "--object", "stone"}),
              HasSubstr("no object 'stone' can be carved"));
  EXPECT_FALSE(std::filesystem::exists(out("clay.stl")));
}

}  // namespace
}  // namespace hapton
