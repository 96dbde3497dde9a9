#include "tools/live/touched_names.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "scene/scene_hash.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

TEST(TouchedNames, AreThoseOfTheSceneThatTheHubReports) {
  const ScratchFolder scratch;
  scratch.write("a.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n");
  const auto file = scratch.write("a.toml", "[[object]]\nmesh = 'a.obj'\nname = 'hood'\nmaterial = 'tin'\n[material.tin]\n");
  nlohmann::ordered_json report;
  report["notes"] = {{"scene", file.string()},    {"scene_hash", fmt::format("{:016x}", hash_scene(load_scene(file)->touch_scene()))},
                     {"scene_unit", "not given"}, {"scene_sealed", "yes"},
                     {"scene_fitted", "no"},      {"touched_object", "0"}};
  TouchedNames names;
  EXPECT_EQ(names.describe(report), "touching hood (tin)");
  report["notes"]["touched_object"] = "none";
  EXPECT_EQ(names.describe(report), "");
  report["notes"]["touched_object"] = "7";
  EXPECT_EQ(names.describe(report), "touching object 7");
  report["notes"]["touched_object"] = "0";
  report["notes"]["scene_hash"] = "0123456789abcdef";
  EXPECT_EQ(names.describe(report), "touching object 0") << "another scene, or one of another host";
}

// With `haptics_node --watch-scene`, the hash of the scene stays that of the start while only materials change, and becomes another one
// when meshes change.
TEST(TouchedNames, AreKnownWhenTheFileWasSavedWithOtherMaterialsOrMeshes) {
  const ScratchFolder scratch;
  scratch.write("a.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n");
  const std::string object = "[[object]]\nmesh = 'a.obj'\nname = 'hood'\nmaterial = 'tin'\n";
  const auto file = scratch.write("a.toml", object + "[material.tin]\n");
  const auto report_of = [&](const Scene& scene) {
    nlohmann::ordered_json report;
    report["notes"] = {{"scene", file.string()},    {"scene_hash", fmt::format("{:016x}", hash_scene(scene.touch_scene()))},
                       {"scene_unit", "not given"}, {"scene_shape_hash", fmt::format("{:016x}", scene.given_hash)},
                       {"scene_sealed", "yes"},     {"scene_fitted", "no"},
                       {"touched_object", "0"}};
    return report;
  };
  const auto at_start = report_of(*load_scene(file));
  scratch.write("a.toml", object + "[material.tin]\nstiffness_n_per_m = 300\n");
  TouchedNames names;
  EXPECT_EQ(names.describe(at_start), "touching hood (tin)");

  scratch.write("a.toml", "[[object]]\nmesh = 'a.obj'\nname = 'roof'\nposition_m = [0, 0, 0.01]\n");
  const auto later = report_of(*load_scene(file));
  EXPECT_EQ(names.describe(later), "touching roof");
  EXPECT_EQ(TouchedNames().describe(at_start), "touching object 0") << "the file has other objects than those that are touched";
}

TEST(TouchedNames, AHubThatDoesNotReportTheObjectGivesNoText) {
  TouchedNames names;
  EXPECT_EQ(names.describe(nlohmann::ordered_json::object()), "");
  EXPECT_EQ(names.describe({{"notes", {{"touched_object", 3}}}}), "");
  EXPECT_EQ(names.describe({{"notes", {{"touched_object", "-3"}}}}), "");
  EXPECT_EQ(names.describe({{"notes", "none"}}), "");
}

}  // namespace
}  // namespace hapton
