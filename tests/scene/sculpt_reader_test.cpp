#include "scene/sculpt_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/geometry/mesh_shapes.h"
#include "scene/scene_file.h"
#include "scene/scene_hash.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using testing::HasSubstr;

Result<SculptSpec> read_clay(const std::string& text) {
  const auto table = parse_toml(text);
  EXPECT_TRUE(table);
  return read_sculpt(*table, "[[object]] 1");
}

std::string clay_error(const std::string& text) {
  const auto read = read_clay(text);
  return read ? "it was read" : read.error().what;
}

TEST(SculptReader, ReadsEveryKey) {
  const auto spec = read_clay("sculpt = true\nvoxel_mm = 0.5\ntool_radius_mm = 3\ncarve_button = 2");
  ASSERT_TRUE(spec) << spec.error().what;
  EXPECT_TRUE(spec->is_on);
  EXPECT_EQ(spec->line, 1U);
  const auto made = make_sculpt(*spec, "clay", make_icosphere(0.02, 3));
  ASSERT_TRUE(made) << made.error().what;
  EXPECT_DOUBLE_EQ(made->voxel_m, 0.0005);
  EXPECT_DOUBLE_EQ(made->tool_radius_m, 0.003);
  EXPECT_EQ(made->button, 2U);
  EXPECT_FALSE(read_clay("")->is_on);
  EXPECT_FALSE(read_clay("sculpt = false")->is_on);
}

TEST(SculptReader, DefaultsFollowTheSize) {
  const auto made = make_sculpt(*read_clay("sculpt = true"), "clay", make_box(Vec3(0.128, 0.05, 0.02)));
  ASSERT_TRUE(made) << made.error().what;
  EXPECT_DOUBLE_EQ(made->voxel_m, 0.001);
  EXPECT_DOUBLE_EQ(made->tool_radius_m, 0.005);
  EXPECT_EQ(made->button, 1U);
}

TEST(SculptReader, RejectsWithTheLine) {
  EXPECT_EQ(clay_error("voxel_mm = 1"), "line 1: 'voxel_mm' in [[object]] 1 goes with 'sculpt = true': add it, or leave this out");
  EXPECT_THAT(clay_error("sculpt = false\ncarve_button = 1"), HasSubstr("line 2: 'carve_button'"));
  EXPECT_THAT(clay_error("sculpt = true\ncarve_button = 1.5"), HasSubstr("buttons are counted 1, 2, 3"));
  EXPECT_THAT(clay_error("sculpt = true\ncarve_button = 33"), HasSubstr("at most 32"));
  EXPECT_THAT(clay_error("sculpt = true\nvoxel_mm = 0"), HasSubstr("above 0"));
  EXPECT_THAT(clay_error("sculpt = 1"), HasSubstr("must be true or false"));
  EXPECT_EQ(clay_error("sculpt = true\nmovable = true"), "line 1: [[object]] 1 has 'sculpt' and 'movable': keep one");
  EXPECT_EQ(clay_error("sculpt = true\nmoved_by = \"program\""), "line 1: [[object]] 1 has 'sculpt' and 'moved_by': keep one");
}

TEST(SculptReader, RejectsMeshesAndToolsThatDoNotFit) {
  const auto spec = *read_clay("sculpt = true");
  EXPECT_THAT(make_sculpt(spec, "clay", make_plane_grid(0.1, 3)).error().what,
              HasSubstr("'clay' cannot be carved: the mesh is not closed"));
  EXPECT_THAT(make_sculpt(*read_clay("sculpt = true\nvoxel_mm = 0.1"), "clay", make_icosphere(0.05, 3)).error().what,
              HasSubstr("at most 16 are possible"));
  EXPECT_THAT(make_sculpt(*read_clay("sculpt = true\nvoxel_mm = 1\ntool_radius_mm = 1.9"), "clay", make_icosphere(0.05, 3)).error().what,
              HasSubstr("give a radius of 2 mm or more"));
  EXPECT_THAT(make_sculpt(*read_clay("sculpt = true\nvoxel_mm = 1\ntool_radius_mm = 12.1"), "clay", make_icosphere(0.05, 3)).error().what,
              HasSubstr("give a radius of 12 mm or less"));
  EXPECT_TRUE(make_sculpt(*read_clay("sculpt = true\nvoxel_mm = 1\ntool_radius_mm = 12"), "clay", make_icosphere(0.05, 3)));
  EXPECT_TRUE(make_sculpt(*read_clay("sculpt = true\nvoxel_mm = 1\ntool_radius_mm = 2"), "clay", make_icosphere(0.05, 3)));
}

// A scene file with a carvable object: its keys reach the object, the input of the force methods and both hashes.
class SculptScene : public testing::Test {
 protected:
  Result<Scene> load(const std::string& keys, const std::string& material = "") {
    const std::filesystem::path path = folder_.path() / "clay.toml";
    std::ofstream(path) << "[[object]]\nmesh = \"" << HAPTON_SOURCE_DIR << "/meshes/peg.obj\"\nunit = \"mm\"\n" << keys << "\n" << material;
    return load_scene(path);
  }
  ScratchFolder folder_;
};

TEST_F(SculptScene, EveryKeyIsPartOfTheHash) {
  const auto plain = load("");
  ASSERT_TRUE(plain) << plain.error().what;
  EXPECT_FALSE(plain->touch_scene().has_sculpt());
  std::vector<std::uint64_t> hashes = {hash_scene(plain->touch_scene())}, given_hashes = {plain->given_hash};
  for (const char* keys : {"sculpt = true", "sculpt = true\nvoxel_mm = 0.9\ntool_radius_mm = 3",
                           "sculpt = true\nvoxel_mm = 0.9\ntool_radius_mm = 4", "sculpt = true\ncarve_button = 2"}) {
    const auto scene = load(keys);
    ASSERT_TRUE(scene) << scene.error().what;
    ASSERT_TRUE(scene->touch_scene().has_sculpt());
    hashes.push_back(hash_scene(scene->touch_scene()));
    given_hashes.push_back(scene->given_hash);
  }
  std::sort(hashes.begin(), hashes.end());
  std::sort(given_hashes.begin(), given_hashes.end());
  EXPECT_EQ(std::unique(hashes.begin(), hashes.end()), hashes.end());
  EXPECT_EQ(std::unique(given_hashes.begin(), given_hashes.end()), given_hashes.end());
}

TEST_F(SculptScene, RejectsEffectsAndTooSmallVoxelsWithTheLine) {
  EXPECT_THAT(load("material = \"soft\"\nsculpt = true", "[material.soft]\nviscosity_ns_per_m = 1\n").error().what,
              HasSubstr("line 5: 'peg' can be carved: its material may have stiffness, damping and friction only"));
  EXPECT_THAT(load("sculpt = true\nvoxel_mm = 0.001\ntool_radius_mm = 1").error().what,
              HasSubstr("line 4: 'peg' cannot be carved: voxels of"));
}

}  // namespace
}  // namespace hapton
