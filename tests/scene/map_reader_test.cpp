#include "scene/map_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "scene/scene_file.h"
#include "scene/scene_hash.h"
#include "tests/scene/made_pictures.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

class MapReader : public ::testing::Test {
 protected:
  MapReader() {
    // A square of 100 mm. OBJ files count v upwards.
    folder_.write("sheet.obj",
                  "v 0 0 0\nv 100 0 0\nv 100 100 0\nv 0 100 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n");
    folder_.write("bare.obj", "v 0 0 0\nv 100 0 0\nv 100 100 0\nf 1 2 3\n");
    folder_.write("ramp.png", picture::png_of(64, 64, picture::grey_rows(64, 64, [](int x, int) { return 4 * x; })));
    folder_.write("other.png", picture::png_of(64, 64, picture::grey_rows(64, 64, [](int, int y) { return 4 * y; })));
    folder_.write("steps.png", picture::png_of(64, 64, picture::grey_rows(64, 64, [](int x, int y) { return (x + y) % 2 * 255; })));
  }

  // The keys of the material begin at line 6.
  std::string scene(const std::string& lines, const char* mesh = "sheet.obj", const char* object = "") {
    return std::string("[[object]]\nmesh = '") + mesh + "'\nunit = 'mm'\nmaterial = 'm'" + object + "\n[material.m]\n" + lines + "\n";
  }
  Result<Scene> load(const std::string& text) { return load_scene(folder_.write("a.toml", text)); }
  SurfaceMaps maps_of(const std::string& lines, const char* object = "") {
    const auto loaded = load(scene(lines, "sheet.obj", object));
    EXPECT_TRUE(loaded) << loaded.error().what;
    return loaded ? loaded->objects[0].effects.maps : SurfaceMaps();
  }
  std::string error_of(const std::string& lines, const char* mesh = "sheet.obj") {
    const auto loaded = load(scene(lines, mesh));
    if (loaded) return "it was read";
    EXPECT_THAT(loaded.error().what, StartsWith((folder_.path() / "a.toml").string() + ": line "));
    EXPECT_EQ(loaded.error().what.find('\n'), std::string::npos) << loaded.error().what;
    return loaded.error().what;
  }

  ScratchFolder folder_;
};

TEST_F(MapReader, ReadsEveryMapWithItsRange) {
  const auto loaded = load(
      scene("bump_map = 'ramp.png'\nbump_height_m = 0.0002\nstiffness_map = 'other.png'\nstiffness_map_n_per_m = [200, 1000]\n"
            "friction_map = 'ramp.png'\nfriction_map_range = [0.1, 0.9]\nviscosity_map = 'other.png'\nviscosity_map_ns_per_m = [0, 6]\n"
            "map_repeat = [2, 3]"));
  ASSERT_TRUE(loaded) << loaded.error().what;
  const SceneObject& object = loaded->objects[0];
  const SurfaceMaps& maps = object.effects.maps;
  EXPECT_FALSE(object.effects.bumps.is_on());
  EXPECT_EQ(object.material.stiffness_n_per_m, 1000.0);
  EXPECT_EQ(maps.height.at_black, -0.0002);
  EXPECT_EQ(maps.height.at_white, 0.0);
  EXPECT_EQ(maps.stiffness.at_black, 0.2);
  EXPECT_EQ(maps.stiffness.at_white, 1.0);
  EXPECT_EQ(maps.friction.at_black, 0.1);
  EXPECT_EQ(maps.friction.at_white, 0.9);
  EXPECT_EQ(maps.viscosity.at_black, 0.0);
  EXPECT_EQ(maps.viscosity.at_white, 6.0);
  EXPECT_EQ(maps.height.image, maps.friction.image) << "read once";
  EXPECT_EQ(maps.stiffness.image, maps.viscosity.image);
  ASSERT_EQ(maps.triangles->size(), 2U);
  EXPECT_EQ(maps.triangles->front().texcoord[1], Eigen::Vector2d(2, 3)) << "repeated; v downwards from the image's upper edge";
  EXPECT_LT((maps.triangles->front().corner[1] - Vec3(0.1, 0, 0)).norm(), 1e-12);
  EXPECT_TRUE(loaded->touch_scene().has_effects());
  EXPECT_EQ(loaded->objects[0].appearance, nullptr) << "colours were not asked for";
}

TEST_F(MapReader, FollowsThePoseAndTheFitOfItsObject) {
  const SurfaceMaps turned =
      maps_of("bump_map = 'ramp.png'\nbump_height_m = 0.001", "\nrotation_deg = [0, 0, 90]\nposition_m = [0.5, 0, 0]\nscale = 2");
  EXPECT_LT((turned.triangles->front().corner[1] - Vec3(0.5, 0.2, 0)).norm(), 1e-12);
  const auto fitted = load("fit_m = [0.05, 1, 1]\n" + scene("bump_map = 'ramp.png'\nbump_height_m = 0.001"));
  ASSERT_TRUE(fitted) << fitted.error().what;
  const auto& triangles = *fitted->objects[0].effects.maps.triangles;
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_LT((triangles[0].corner[k] - fitted->objects[0].mesh->corner(0, static_cast<int>(k))).norm(), 1e-12);
}

TEST_F(MapReader, TooSteepAReliefIsSmoothedAndSaysSo) {
  const auto loaded = load(scene("bump_map = 'steps.png'\nbump_height_m = 0.01"));
  ASSERT_TRUE(loaded) << loaded.error().what;
  const SurfaceMaps& maps = loaded->objects[0].effects.maps;
  EXPECT_LE(maps.height.steepest(*maps.triangles), SurfaceMaps::kSteepest);
  ASSERT_FALSE(loaded->notes.empty());
  EXPECT_THAT(loaded->notes.back(), AllOf(HasSubstr("steps.png"), HasSubstr("smoothed to 32 x 32 texels")));
  EXPECT_THAT(load(scene("bump_map = 'ramp.png'\nbump_height_m = 0.0001"))->notes, IsEmpty());
}

TEST_F(MapReader, ObjectsShareAnImageThatIsSmoothedForThem) {
  const auto loaded =
      load(scene("bump_map = 'steps.png'\nbump_height_m = 0.01\n[[instance]]\nname = 'moved'\nof = 'sheet'\n"
                 "position_m = [0.5, 0, 0]\n[[instance]]\nname = 'small'\nof = 'sheet'\nscale = 0.001"));
  ASSERT_TRUE(loaded) << loaded.error().what;
  ASSERT_EQ(loaded->objects.size(), 3U);
  const auto image = [&](std::size_t object) { return loaded->objects[object].effects.maps.height.image; };
  EXPECT_EQ(image(1), image(0));
  EXPECT_LE(image(2)->width(), image(0)->width()) << "as steep as it is small";
}

TEST_F(MapReader, SaysWhatIsWrongAndWhere) {
  EXPECT_THAT(error_of("bump_height_m = 0.001\nbump_map = 'none.png'"), AllOf(HasSubstr("line 7: 'bump_map'"), HasSubstr("none.png")));
  EXPECT_THAT(error_of("bump_height_m = 0.001\nbump_map = 'sheet.obj'"), HasSubstr("sheet.obj: is neither PNG nor JPEG"));
  EXPECT_THAT(error_of("bump_map = ''\nbump_height_m = 0.001"), HasSubstr("line 6: 'bump_map' is empty"));
  EXPECT_THAT(error_of("bump_map = 'ramp.png'\nbump_height_m = 0.001", "bare.obj"),
              HasSubstr("line 6: 'bump_map' needs texture coordinates, and the mesh of object 'bare' has none"));
  EXPECT_THAT(error_of("friction_map = 'ramp.png'\nfriction_map_range = [0, 1]", "bare.obj"), HasSubstr("line 6: 'friction_map' needs"));
  EXPECT_THAT(error_of("viscosity_map = 'ramp.png'\nviscosity_map_ns_per_m = [0, 1]", "bare.obj"),
              HasSubstr("line 6: 'viscosity_map' needs"));
  EXPECT_THAT(error_of("viscosity_map = 'ramp.png'"), HasSubstr("needs 'viscosity_map_ns_per_m'"));
  EXPECT_THAT(error_of("viscosity_map_ns_per_m = [0, 1]"), HasSubstr("line 6: 'viscosity_map_ns_per_m' has no effect"));
  EXPECT_THAT(error_of("viscosity_ns_per_m = 1\nviscosity_map = 'ramp.png'\nviscosity_map_ns_per_m = [0, 1]"),
              HasSubstr("line 7: 'viscosity_map' replaces 'viscosity_ns_per_m'"));
  EXPECT_THAT(error_of("viscosity_map = 'ramp.png'\nviscosity_map_ns_per_m = [0, -1]"), HasSubstr("viscosity_map_ns_per_m"));
  EXPECT_THAT(error_of("bump_map = 'ramp.png'"), HasSubstr("needs 'bump_height_m'"));
  EXPECT_THAT(error_of("bump_map = 'ramp.png'\nbump_height_m = 0"), HasSubstr("must be above 0"));
  EXPECT_THAT(error_of("bump_map = 'ramp.png'\nbump_height_m = 0.001\nbump_length_m = 1"), HasSubstr("line 8: 'bump_length_m'"));
  EXPECT_THAT(error_of("bump_map = 'ramp.png'\nbump_height_m = 0.001\ndamping_ns_per_m = 1"), HasSubstr("source of energy"));
  EXPECT_THAT(error_of("stiffness_map = 'ramp.png'"), HasSubstr("needs 'stiffness_map_n_per_m'"));
  EXPECT_THAT(error_of("stiffness_map_n_per_m = [1, 2]"), HasSubstr("no effect without 'stiffness_map'"));
  EXPECT_THAT(error_of("stiffness_map = 'ramp.png'\nstiffness_map_n_per_m = [0, 2]"), HasSubstr("number 1 of 'stiffness_map_n_per_m'"));
  EXPECT_THAT(error_of("stiffness_map = 'ramp.png'\nstiffness_map_n_per_m = [1, 2]\nstiffness_n_per_m = 5"), HasSubstr("keep one"));
  EXPECT_THAT(error_of("friction_map = 'ramp.png'\nfriction_map_range = [0, 11]"), HasSubstr("at most 10"));
  EXPECT_THAT(error_of("friction_map = 'ramp.png'\nfriction_map_range = [0, 1]\nfriction_static = 0.5"), HasSubstr("replaces"));
  EXPECT_THAT(error_of("map_repeat = [2, 2]"), HasSubstr("no effect without a map"));
  EXPECT_THAT(error_of("friction_map = 'ramp.png'\nfriction_map_range = [0, 1]\nmap_repeat = [0, 1]"),
              HasSubstr("line 8: number 1 of 'map_repeat'"));
  EXPECT_THAT(error_of("bump_mapp = 'ramp.png'"), HasSubstr("'bump_map'"));
}

TEST_F(MapReader, EveryNumberAndTexelIsPartOfTheHash) {
  std::set<std::uint64_t> hashes;
  std::size_t count = 0;
  for (const char* lines :
       {"", "bump_map = 'ramp.png'\nbump_height_m = 0.001", "bump_map = 'other.png'\nbump_height_m = 0.001",
        "bump_map = 'ramp.png'\nbump_height_m = 0.002", "bump_map = 'ramp.png'\nbump_height_m = 0.001\nmap_repeat = [1, 2]",
        "stiffness_map = 'ramp.png'\nstiffness_map_n_per_m = [200, 1000]",
        "stiffness_map = 'ramp.png'\nstiffness_map_n_per_m = [1000, 200]", "friction_map = 'ramp.png'\nfriction_map_range = [0, 1]",
        "friction_map = 'ramp.png'\nfriction_map_range = [0, 0.9]"}) {
    const auto loaded = load(scene(lines));
    ASSERT_TRUE(loaded) << loaded.error().what;
    hashes.insert(hash_scene(loaded->touch_scene()));
    ++count;
  }
  EXPECT_EQ(hashes.size(), count);
}

// A mesh that is sealed for touch has other triangles; its texture coordinates stay those of the file.
TEST_F(MapReader, AMeshThatIsSealedKeepsItsMap) {
  // Two squares with a crack of 1 micrometre between them.
  folder_.write(
      "crack.obj",
      "v 0 0 0\nv 100 0 0\nv 100 100 0\nv 0 100 0\nv 100.001 0 0\nv 200 0 0\nv 200 100 0\nv 100.001 100 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
      "f 1/1 2/2 3/3 4/4\nf 5/1 6/2 7/3 8/4\n");
  const auto loaded = load(scene("bump_map = 'ramp.png'\nbump_height_m = 0.001", "crack.obj"));
  ASSERT_TRUE(loaded) << loaded.error().what;
  EXPECT_TRUE(loaded->objects[0].sealed.has_sealed());
  EXPECT_EQ(loaded->objects[0].effects.maps.triangles->size(), 4U);
}

}  // namespace
}  // namespace hapton
