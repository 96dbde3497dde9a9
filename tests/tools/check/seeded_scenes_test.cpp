// Scenes with one fault each in how they are put together: materials, effects, motion, places, camera. The faults of meshes are in
// seeded_faults_test.cpp.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/scene/made_texture_file.h"
#include "tests/support/scratch_folder.h"
#include "tests/tools/command_run.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

struct SeededScene {
  std::string name;
  std::string object;  // lines of [[object]] 'seeded', a block of 40 x 30 x 20 mm
  std::string tables;  // lines of its material, then other tables
  std::string fault;   // as the JSON names it
  std::string expected_object = "seeded";
  std::string expected_text = {};  // a part of the text of the finding or of its fix
};

std::vector<SeededScene> seeded_scenes() {
  const std::string effect = "[[effect]]\nname = 'seeded'\n";
  return {
      {"ALayerThatNoDevicePunctures", "",
       "two_sided = false\n[[material.m.layer]]\ndepth_m = 0\nstiffness_n_per_m = 20\npop_force_n = 20\n[[material.m.layer]]\ndepth_m = "
       "0.01\n"
       "stiffness_n_per_m = 20\n",
       "stronger-than-device", "seeded", "layer 1 gives way at 20 N"},
      {"ASnapThatNoDeviceHolds", "", "snap_range_m = 0.04\nsnap_stiffness_n_per_m = 300\n", "stronger-than-device", "seeded", "12 N"},
      {"ATapThatNoDeviceGives", "", "tap_ns_per_m = 5\ntap_frequency_hz = 100\ntap_max_force_n = 20\n", "stronger-than-device", "seeded",
       "tap_max_force_n"},
      {"ATextureThatNoDeviceGives", "", "recorded_texture = 'canvas.xml'\ntexture_max_force_n = 20\n", "stronger-than-device", "seeded",
       "texture_max_force_n"},
      {"ASpringThatNoDeviceGives", "", effect + "type = 'spring'\nposition_m = [0, 0, 0]\nmax_force_n = 20\n", "stronger-than-device",
       "effect seeded"},
      {"AWaveThatNoDeviceGives", "", effect + "type = 'wave'\ndirection = [1, 0, 0]\namplitude_n = 20\n", "stronger-than-device",
       "effect seeded"},
      {"AWaveTooFast", "", effect + "type = 'wave'\ndirection = [1, 0, 0]\nfrequency_hz = 800\n", "faster-than-loop", "effect seeded"},
      {"ABurstTooFast", "", effect + "type = 'burst'\nbutton = 1\ndirection = [1, 0, 0]\nfrequency_hz = 500\n", "faster-than-loop",
       "effect seeded"},
      {"AKeyframeOutside",
       "[[object.keyframe]]\ntime_s = 0\n[[object.keyframe]]\ntime_s = 3\nposition_m = [0.5, 0, 0]\n[[object.keyframe]]\ntime_s = 6\n", "",
       "out-of-reach"},
      {"AMagnetOutside", "", effect + "type = 'magnet'\nposition_m = [1, 0, 0]\n", "out-of-reach", "effect seeded"},
      {"AVolumeOutside", "", effect + "type = 'viscous'\ndamping_ns_per_m = 2\nposition_m = [1, 0, 0]\nradius_m = 0.02\n", "out-of-reach",
       "effect seeded"},
      {"APlaneOutside", "", effect + "type = 'plane_snap'\nposition_m = [1, 0, 0]\nnormal = [1, 0, 0]\n", "out-of-reach", "effect seeded"},
      {"AWellOutside", "", effect + "type = 'gravity_well'\nposition_m = [5, 0, 0]\n", "out-of-reach", "effect seeded"},
      {"ASpringTooStiff", "", effect + "type = 'spring'\nposition_m = [0, 0, 0]\nstiffness_n_per_m = 5000\n", "stiffer-than-device",
       "effect seeded"},
      {"AVolumeTooViscous", "", effect + "type = 'viscous'\ndamping_ns_per_m = 1000\n", "more-damped-than-loop", "effect seeded"},
      {"AMassTooHeavy", "", effect + "type = 'mass'\nmass_kg = 4\nfilter_s = 0.005\n", "heavier-than-loop", "effect seeded"},
      {"APointLeftOutOfTheFriction", "", "friction_static = 8\nfriction_dynamic = 0.6\n", "rough", "seeded", "friction_static = 8"},
      {"TheSameObjectTwice", "[[object]]\nmesh = 'block.obj'\nname = 'twin'\nmaterial = 'good'\n", "", "coincides", "twin",
       "in the same place as object 'seeded'"},
      {"AnObjectInsideAnother",
       "[[object]]\nmesh = 'block.obj'\nname = 'kernel'\nscale = 0.3\nrotation_deg = [0, 30, 0]\nmaterial = 'good'\n", "", "enclosed",
       "kernel", "inside object 'seeded'"},
      {"TheCameraInABody", "", "[camera]\nposition_m = [0.01, 0, 0.005]\nlook_at_m = [0, 0, -0.1]\n", "view-inside", "", "[camera]"},
      {"ALightInABody", "", "[[light]]\ndirection = [0, -1, 0]\n[[light]]\nposition_m = [0.01, 0, 0]\n", "view-inside", "", "[[light]] 2"},
      {"APartThatLiesInAnother",
       "movable = true\n[[object]]\nmesh = 'block.obj'\nname = 'shelf'\nposition_m = [0.02, 0, 0]\nmaterial = 'good'\n", "", "overlaps"},
      {"AToolInMillimetres", "", "[tool]\nmesh = 'block.obj'\nname = 'seeded'\nunit = 'mm'\n", "odd-tool"},
  };
}

nlohmann::json check_seeded_scene(const SeededScene& seeded, const ScratchFolder& folder) {
  const std::string block =
      "v -.02 -.015 -.01\nv .02 -.015 -.01\nv .02 .015 -.01\nv -.02 .015 -.01\nv -.02 -.015 .01\nv .02 -.015 .01\nv .02 .015 .01\n"
      "v -.02 .015 .01\nf 1 4 3\nf 1 3 2\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";
  folder.write("block.obj", block);
  folder.write("canvas.xml", made::texture_file());
  // Layers have a stiffness of their own.
  const std::string stiffness = seeded.tables.find(".layer]]") == std::string::npos ? "stiffness_n_per_m = 20.0\n" : "";
  const auto scene =
      folder.write("scene.toml", "[[object]]\nmesh = 'block.obj'\nname = 'seeded'\nmaterial = 'm'\n" + seeded.object +
                                     "[[object]]\nmesh = 'block.obj'\nname = 'good'\nposition_m = [0, 0.05, 0]\nmaterial = 'good'\n" +
                                     "[material.good]\nstiffness_n_per_m = 20.0\n[material.m]\n" + stiffness + seeded.tables);
  const CommandRun run = run_hapton({"check", scene.string(), "--json"});
  EXPECT_EQ(run.err, "");
  const auto json = nlohmann::json::parse(run.out, nullptr, false);
  // How long a step takes depends on the machine.
  const bool is_slow =
      json.is_object() && std::ranges::any_of(json["findings"], [](const auto& one) { return one["fault"] == "too-slow"; });
  EXPECT_EQ(run.code, seeded.fault.empty() && !is_slow ? 0 : 1);
  return json;
}

TEST(SeededScenes, EachFaultIsFoundAndWhatIsGoodIsNotNamed) {
  EXPECT_GE(seeded_scenes().size(), 20U);
  const ScratchFolder folder;
  for (const SeededScene& seeded : seeded_scenes()) {
    SCOPED_TRACE(seeded.name);
    const nlohmann::json json = check_seeded_scene(seeded, folder);
    if (!json.is_object()) {
      ADD_FAILURE() << "no JSON";
      continue;
    }
    bool is_found = false;
    for (const auto& finding : json["findings"]) {
      EXPECT_NE(finding["object"], "good") << finding;
      if (finding["fault"] != seeded.fault) continue;
      is_found = true;
      EXPECT_EQ(finding["object"], seeded.expected_object) << finding;
      EXPECT_THAT(std::string(finding["what"]) + "; " + std::string(finding["fix"]), HasSubstr(seeded.expected_text));
    }
    EXPECT_TRUE(is_found) << json["findings"].dump();
  }
}

TEST(SeededScenes, WhatOnlyLooksLikeSuchAFaultIsNone) {
  const ScratchFolder folder;
  const std::string kernel = "[[object]]\nmesh = 'block.obj'\nname = 'kernel'\nscale = 0.3\nmaterial = 'good'\n";
  const std::vector<SeededScene> good = {
      {"Nothing", "", "", ""},
      {"AKernelUnderALayer", kernel,
       "two_sided = false\n[[material.m.layer]]\ndepth_m = 0\nstiffness_n_per_m = 20\npop_force_n = 1\n[[material.m.layer]]\ndepth_m = "
       "0.01\n"
       "stiffness_n_per_m = 20\n",
       ""},
      {"AKernelToCarveOut", "sculpt = true\nvoxel_mm = 1\ntool_radius_mm = 4\n" + kernel, "", ""},
      {"AKernelThatIsMeant", kernel + "accepted_findings = ['enclosed']\n", "", ""},
      {"TheSameMeshBeside", "[[object]]\nmesh = 'block.obj'\nname = 'twin'\nposition_m = [0.0401, 0, 0]\nmaterial = 'good'\n", "", ""},
      {"RubberOnRubber", "", "friction_static = 1.5\nfriction_dynamic = 1.2\n", ""},
      {"ACameraAndALightOutside", "", "[camera]\nposition_m = [0, 0, 0.5]\n[[light]]\nposition_m = [0, 0.3, 0.2]\n", ""},
  };
  for (const SeededScene& scene : good) {
    SCOPED_TRACE(scene.name);
    const nlohmann::json json = check_seeded_scene(scene, folder);
    if (!json.is_object()) {
      ADD_FAILURE() << "no JSON";
      continue;
    }
    for (const auto& finding : json["findings"]) EXPECT_EQ(finding["fault"], "too-slow") << finding;  // depends on the machine
  }
}

}  // namespace
}  // namespace hapton
