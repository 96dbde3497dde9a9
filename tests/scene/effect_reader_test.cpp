#include "scene/effect_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "scene/scene_file.h"
#include "scene/scene_hash.h"
#include "tests/scene/sample_files.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using ::testing::StartsWith;

class EffectReader : public ::testing::Test {
 protected:
  EffectReader() { folder_.write("a.obj", sample::obj(sample::tetrahedron())); }

  Result<Scene> load(const std::string& text) { return load_scene(folder_.write("a.toml", text)); }
  std::string error_of(const std::string& text) {
    const auto scene = load(text);
    if (scene) return "it was read";
    EXPECT_THAT(scene.error().what, StartsWith((folder_.path() / "a.toml").string() + ": line "));
    EXPECT_EQ(scene.error().what.find('\n'), std::string::npos) << scene.error().what;
    return scene.error().what;
  }
  // The object and the header of the next table take lines 1 to 4, so `lines` begins at line 5.
  static std::string with_material(const std::string& lines) {
    return "[[object]]\nmesh = 'a.obj'\nmaterial = 'm'\n[material.m]\n" + lines + "\n";
  }
  static std::string with_effect(const std::string& lines) { return "[[object]]\nmesh = 'a.obj'\n\n[[effect]]\n" + lines + "\n"; }

  std::uint64_t hash_of(const std::string& text) {
    const auto scene = load(text);
    EXPECT_TRUE(scene) << text << scene.error().what;
    return scene ? hash_scene(scene->touch_scene()) : 0;
  }

  ScratchFolder folder_;
};

TEST_F(EffectReader, ReadsEverySurfaceEffect) {
  const auto scene = load(with_material(R"(progressive_n_per_m2 = 2e5
viscosity_ns_per_m = 3
snap_range_m = 0.002
snap_stiffness_n_per_m = 250
bump_height_m = 0.001
bump_length_m = 0.006
bump_pattern = "ridges"
bump_direction = [0, 2, 0]
tap_ns_per_m = 6
tap_frequency_hz = 250
tap_decay_s = 0.03
tap_max_force_n = 1.5)"));
  ASSERT_TRUE(scene) << scene.error().what;
  const SurfaceEffects& effects = scene->objects[0].effects;
  EXPECT_EQ(effects.progressive.n_per_m2, 2e5);
  EXPECT_EQ(effects.viscosity.damping_ns_per_m, 3);
  EXPECT_EQ(effects.snap.range_m, 0.002);
  EXPECT_EQ(effects.snap.stiffness_n_per_m, 250);
  EXPECT_EQ(effects.bumps.height_m, 0.001);
  EXPECT_EQ(effects.bumps.length_m, 0.006);
  EXPECT_EQ(effects.bumps.pattern, SurfaceBumps::Pattern::ridges);
  EXPECT_EQ(effects.bumps.direction, Vec3::UnitY());
  EXPECT_EQ(effects.tap.ns_per_m, 6);
  EXPECT_EQ(effects.tap.frequency_hz, 250);
  EXPECT_EQ(effects.tap.decay_s, 0.03);
  EXPECT_EQ(effects.tap.max_force_n, 1.5);
  EXPECT_TRUE(scene->touch_scene().has_effects());
  EXPECT_TRUE(scene->touch_scene().objects[0].effects.any());
}

TEST_F(EffectReader, ReadsLayers) {
  const auto scene = load(with_material(R"(two_sided = false
[[material.m.layer]]
depth_m = 0
stiffness_n_per_m = 300
pop_force_n = 1
[[material.m.layer]]
depth_m = 0.01
stiffness_n_per_m = 800
pop_force_n = 2.5
drag_ns_per_m = 4
[[material.m.layer]]
depth_m = 0.03
stiffness_n_per_m = 2000)"));
  ASSERT_TRUE(scene) << scene.error().what;
  const TissueLayers& layers = scene->objects[0].effects.layers;
  ASSERT_EQ(layers.count(), 3U);
  EXPECT_EQ(layers[1].depth_m, 0.01);
  EXPECT_EQ(layers[1].stiffness_n_per_m, 800);
  EXPECT_EQ(layers[1].pop_force_n, 2.5);
  EXPECT_EQ(layers[1].drag_ns_per_m, 4);
  EXPECT_EQ(layers[2].pop_force_n, std::numeric_limits<double>::infinity());
}

TEST_F(EffectReader, ReadsEverySpaceEffect) {
  const auto scene = load(
      "[[object]]\nmesh = 'a.obj'\n"
      R"(
[[effect]]
type = "spring"
name = "home"
position_m = [1, 2, 3]
stiffness_n_per_m = 80
max_force_n = 1.5
[[effect]]
type = "constant"
force_n = [0, -0.5, 0]
[[effect]]
type = "magnet"
position_m = [0, 0, 1]
range_m = 0.03
max_force_n = 2.5
[[effect]]
type = "line_snap"
position_m = [0, 0, 1]
direction = [0, 3, 4]
[[effect]]
type = "plane_snap"
position_m = [0, 0, 1]
normal = [0, 0, -2]
[[effect]]
type = "gravity_well"
position_m = [0, 0, 1]
radius_m = 0.04
max_force_n = 1
[[effect]]
type = "viscous"
damping_ns_per_m = 5
max_force_n = 4
position_m = [0, 0, 0]
radius_m = 0.1
[[effect]]
type = "wave"
waveform = "triangle"
direction = [1, 0, 0]
amplitude_n = 0.3
frequency_hz = 7
position_m = [0, 0, 0]
size_m = [0.1, 0.2, 0.3]
[[effect]]
type = "burst"
object = "a"
direction = [0, 0, 1]
amplitude_n = 1.1
frequency_hz = 90
decay_s = 0.04
duration_s = 0.15
[[effect]]
type = "mass"
mass_kg = 0.3
filter_s = 0.05
max_force_n = 4
position_m = [0, 0, 0]
radius_m = 0.1
)");
  ASSERT_TRUE(scene) << scene.error().what;
  ASSERT_THAT(scene->effects, SizeIs(10));
  EXPECT_EQ(scene->effects[0].name, "home");
  EXPECT_EQ(scene->effects[1].name, "constant");
  const auto& spring = std::get<SpringEffect>(scene->effects[0].effect);
  EXPECT_EQ(spring.centre, Vec3(1, 2, 3));
  EXPECT_EQ(spring.stiffness_n_per_m, 80);
  EXPECT_EQ(spring.max_force_n, 1.5);
  EXPECT_EQ(std::get<ConstantEffect>(scene->effects[1].effect).force({}), Vec3(0, -0.5, 0));
  const auto& magnet = std::get<SnapEffect>(scene->effects[2].effect);
  EXPECT_EQ(magnet.target, SnapEffect::Target::point);
  EXPECT_EQ(magnet.range_m, 0.03);
  EXPECT_EQ(magnet.max_force_n, 2.5);
  EXPECT_EQ(std::get<SnapEffect>(scene->effects[3].effect).target, SnapEffect::Target::line);
  EXPECT_LT((std::get<SnapEffect>(scene->effects[3].effect).direction - Vec3(0, 0.6, 0.8)).norm(), 1e-15);
  EXPECT_EQ(std::get<SnapEffect>(scene->effects[4].effect).target, SnapEffect::Target::plane);
  EXPECT_EQ(std::get<SnapEffect>(scene->effects[4].effect).direction, Vec3(0, 0, -1));
  EXPECT_EQ(std::get<GravityWellEffect>(scene->effects[5].effect).radius_m, 0.04);
  const auto& viscous = std::get<ViscousEffect>(scene->effects[6].effect);
  EXPECT_EQ(viscous.damping_ns_per_m, 5);
  EXPECT_TRUE(viscous.volume.contains({0.09, 0, 0}));
  EXPECT_FALSE(viscous.volume.contains({0.11, 0, 0}));
  const auto& wave = std::get<WaveEffect>(scene->effects[7].effect);
  EXPECT_EQ(wave.waveform, Waveform::triangle);
  EXPECT_EQ(wave.frequency_hz, 7);
  EXPECT_TRUE(wave.volume.contains({0.05, 0.1, 0.15}));
  EXPECT_FALSE(wave.volume.contains({0.06, 0, 0}));
  const auto& burst = std::get<BurstEffect>(scene->effects[8].effect);
  EXPECT_EQ(burst.decay_s, 0.04);
  EXPECT_EQ(burst.duration_s, 0.15);
  const auto& mass = std::get<MassEffect>(scene->effects[9].effect);
  EXPECT_EQ(mass.mass_kg, 0.3);
  EXPECT_EQ(mass.filter_s, 0.05);
  EXPECT_EQ(mass.max_force_n, 4);
  EXPECT_FALSE(mass.volume.contains({0.11, 0, 0}));
  // The tetrahedron's box is 1.5 x 2.25 x 0.125.
  EXPECT_TRUE(burst.volume.contains({1.4, 2.2, -0.1}));
  EXPECT_FALSE(burst.volume.contains({1.6, 0.1, -0.1}));
  EXPECT_FALSE(burst.volume.contains({1.4, 2.2, 0.1}));
}

TEST_F(EffectReader, AnyEffectMayHaveAButton) {
  const auto scene = load(
      "[[object]]\nmesh = 'a.obj'\n[[effect]]\ntype = 'burst'\ndirection = [0, 0, 1]\nbutton = 2\n"
      "[[effect]]\ntype = 'spring'\nobject = 'a'\nbutton = 32\n[[effect]]\ntype = 'spring'\nobject = 'a'\n");
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_EQ(scene->effects[0].on.button, 2U);
  EXPECT_TRUE(std::get<BurstEffect>(scene->effects[0].effect).volume.is_everywhere());
  EXPECT_EQ(scene->effects[1].on.button, 1U << 31);
  EXPECT_EQ(scene->effects[2].on.button, 0U);
  EXPECT_EQ(scene->touch_scene().effects[1].on.button, 1U << 31);
}

TEST_F(EffectReader, AnObjectPlacesAnEffectWhereItIs) {
  const auto scene =
      load("fit_m = [0.2, 0.2, 0.2]\n[[object]]\nmesh = 'a.obj'\nname = 'ball'\n[[effect]]\ntype = 'spring'\nobject = 'ball'\n");
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_LT(std::get<SpringEffect>(scene->effects[0].effect).centre.norm(), 1e-12) << "after fit_m";
}

TEST_F(EffectReader, AnObjectPlacesAnEffectAtTheMiddleOfItsBox) {
  const auto scene = load(
      "[[object]]\nmesh = 'a.obj'\n[[effect]]\ntype = 'spring'\nobject = 'a'\n[[effect]]\ntype = 'magnet'\nobject = 'a'\n"
      "[[effect]]\ntype = 'gravity_well'\nobject = 'a'\n");
  ASSERT_TRUE(scene) << scene.error().what;
  const Vec3 middle(0.75, 1.125, -0.0625);
  EXPECT_LT((std::get<SpringEffect>(scene->effects[0].effect).centre - middle).norm(), 1e-12);
  EXPECT_LT((std::get<SnapEffect>(scene->effects[1].effect).position - middle).norm(), 1e-12);
  EXPECT_LT((std::get<GravityWellEffect>(scene->effects[2].effect).centre - middle).norm(), 1e-12);
}

TEST_F(EffectReader, NamesTheLineTheKeyAndWhatIsAllowed) {
  EXPECT_THAT(error_of(with_material("\nviscosity_ns_per_m = -1")),
              HasSubstr("line 6: 'viscosity_ns_per_m' in [material.m] is -1: it must be at least 0 and at most 1000"));
  EXPECT_THAT(error_of(with_material("viscosty_ns_per_m = 1")), HasSubstr("did you mean 'viscosity_ns_per_m'?"));
  EXPECT_THAT(error_of(with_material("bump_length_m = 0.01")),
              HasSubstr("line 5: 'bump_length_m' has no effect: give 'bump_height_m' above 0 too"));
  EXPECT_THAT(error_of(with_material("bump_height_m = 0.004\nbump_length_m = 0.01")), HasSubstr("at most a third"));
  EXPECT_THAT(error_of(with_material("bump_height_m = 0.001\nbump_length_m = 0.01\ndamping_ns_per_m = 1")),
              HasSubstr("a source of energy"));
  EXPECT_THAT(error_of(with_material("bump_height_m = 0.001\nbump_pattern = 'dots'")), HasSubstr("'dots': choose one of ridges, grid"));
  EXPECT_THAT(error_of(with_material("bump_height_m = 0.001\nbump_direction = [1, 0, 0]")), HasSubstr("is for 'bump_pattern' \"ridges\""));
  EXPECT_THAT(error_of(with_material("bump_height_m = 0.001\nbump_pattern = 'ridges'\nbump_direction = [0, 0, 0]")),
              HasSubstr("has length 0: give a direction"));
  EXPECT_THAT(error_of(with_material("tap_decay_s = 0.01")), HasSubstr("give 'tap_ns_per_m' above 0 too"));
  EXPECT_THAT(error_of(with_material("snap_stiffness_n_per_m = 10")), HasSubstr("give 'snap_range_m' above 0 too"));
  EXPECT_THAT(error_of(with_material("snap_range_m = 1\nsnap_stiffness_n_per_m = 1e6")), HasSubstr("at most 100 N"));
  EXPECT_THAT(error_of(with_material("layer = 3")), HasSubstr("line 5: 'layer' must be tables that begin with [[material.m.layer]]"));

  EXPECT_THAT(error_of(with_effect("name = 'x'")), HasSubstr("[[effect]] 1 has no 'type': add it"));
  EXPECT_THAT(error_of(with_effect("type = 'magnit'")),
              AllOf(HasSubstr("line 5: "), HasSubstr("choose one of spring, constant, magnet, ")));
  EXPECT_THAT(error_of(with_effect("type = 'spring'")), HasSubstr("[[effect]] 1 has no 'position_m': add it"));
  EXPECT_THAT(error_of(with_effect("type = 'spring'\nposition_m = [0, 0]")), HasSubstr("must be a list of 3 numbers"));
  EXPECT_THAT(error_of(with_effect("type = 'spring'\nposition_m = [0, 0, 0]\nrange_m = 1")), HasSubstr("line 7: unknown key 'range_m'"));
  EXPECT_THAT(error_of(with_effect("type = 'constant'\nforce_n = [90, 90, 0]")), HasSubstr("has length 127"));
  EXPECT_THAT(error_of(with_effect("type = 'constant'\nforce_n = [1, 0, 0]\nradius_m = 1")), HasSubstr("give both, or neither"));
  EXPECT_THAT(error_of(with_effect("type = 'constant'\nforce_n = [1, 0, 0]\nposition_m = [0, 0, 0]")), HasSubstr("give both, or neither"));
  EXPECT_THAT(error_of(with_effect("type = 'constant'\nforce_n = [1, 0, 0]\nposition_m = [0, 0, 0]\nradius_m = 1\nsize_m = [1, 1, 1]")),
              HasSubstr("keep one"));
  EXPECT_THAT(error_of(with_effect("type = 'mass'")), HasSubstr("has no 'mass_kg'"));
  EXPECT_THAT(error_of(with_effect("type = 'mass'\nmass_kg = 0.1\nfilter_s = 0.001")), HasSubstr("it must be at least 0.005"));
  EXPECT_THAT(error_of(with_effect("type = 'viscous'")), HasSubstr("has no 'damping_ns_per_m'"));
  EXPECT_THAT(error_of(with_effect("type = 'viscous'\ndamping_ns_per_m = nan")), HasSubstr("it must be above 0"));
  EXPECT_THAT(error_of(with_effect("type = 'burst'\ndirection = [0, 0, 1]")), HasSubstr("a burst needs a volume to enter"));
  EXPECT_THAT(error_of(with_effect("type = 'constant'\nforce_n = [1, 0, 0]\nbutton = 0")),
              HasSubstr("line 7: 'button' in [[effect]] 1 is 0"));
  EXPECT_THAT(error_of(with_effect("type = 'constant'\nforce_n = [1, 0, 0]\nbutton = 33")), HasSubstr("at most 32"));
  EXPECT_THAT(error_of(with_effect("type = 'constant'\nforce_n = [1, 0, 0]\nbutton = 1.5")), HasSubstr("buttons are counted 1, 2, 3"));
  EXPECT_THAT(error_of(with_effect("type = 'constant'\nforce_n = [1, 0, 0]\nbutton = 'a'")), HasSubstr("must be a number"));
  EXPECT_THAT(error_of(with_effect("type = 'wave'\nfrequency_hz = 3")), HasSubstr("has no 'direction'"));
  EXPECT_THAT(error_of(with_effect("type = 'plane_snap'\nposition_m = [0, 0, 0]\ndirection = [0, 0, 1]")),
              HasSubstr("unknown key 'direction'"));
  EXPECT_THAT(error_of(with_effect("type = 'spring'\nobject = 'b'")), HasSubstr("line 6: there is no object named b"));
  EXPECT_THAT(error_of(with_effect("type = 'spring'\nobject = ''")), HasSubstr("is empty"));
  EXPECT_THAT(error_of(with_effect("type = 'spring'\nobject = 'a'\nposition_m = [0, 0, 0]")), HasSubstr("keep one"));
  EXPECT_THAT(error_of("effect = 3\n[[object]]\nmesh = 'a.obj'\n"),
              HasSubstr("line 1: 'effect' must be tables that begin with [[effect]]"));
  EXPECT_THAT(error_of("[[object]]\nmesh = 'a.obj'\n[[object]]\nmesh = 'a.obj'\n[[effect]]\ntype = 'spring'\nobject = 'a'\n"),
              HasSubstr("line 7: several objects have the name a"));
}

TEST_F(EffectReader, RejectsLayersThatCannotBe) {
  const auto layers_error = [&](const std::string& head, const std::string& tail) {
    return error_of(with_material(head + "\n[[material.m.layer]]\ndepth_m = 0\nstiffness_n_per_m = 100\n" + tail));
  };
  const std::string one_sided = "two_sided = false";
  EXPECT_THAT(layers_error("", ""), HasSubstr("need 'two_sided = false'"));
  EXPECT_THAT(layers_error(one_sided + "\ndamping_ns_per_m = 1", ""), HasSubstr("line 6: layers have no 'damping_ns_per_m'"));
  EXPECT_THAT(layers_error(one_sided + "\nprogressive_n_per_m2 = 1", ""), HasSubstr("layers have no 'progressive_n_per_m2'"));
  EXPECT_THAT(layers_error(one_sided + "\nstiffness_n_per_m = 1", ""), HasSubstr("layers replace 'stiffness_n_per_m'"));
  EXPECT_THAT(layers_error(one_sided, "drag_ns_per_m = 1"), HasSubstr("never punctured"));
  EXPECT_THAT(layers_error(one_sided, "[[material.m.layer]]\ndepth_m = 0.01\nstiffness_n_per_m = 1"), HasSubstr("is never reached"));
  EXPECT_THAT(layers_error(one_sided, "pop_force_n = 1\n[[material.m.layer]]\ndepth_m = 0\nstiffness_n_per_m = 1"),
              HasSubstr("must be more than"));
  EXPECT_THAT(layers_error(one_sided, "pop_force_n = 1\n[[material.m.layer]]\nstiffness_n_per_m = 1"),
              HasSubstr("[[material.m.layer]] 2 has no 'depth_m'"));
  EXPECT_THAT(layers_error(one_sided, "pop_froce_n = 1"), HasSubstr("did you mean 'pop_force_n'?"));
  std::string many;
  for (int i = 1; i < 9; ++i) many += fmt::format("pop_force_n = 1\n[[material.m.layer]]\ndepth_m = {}\nstiffness_n_per_m = 1\n", 0.01 * i);
  EXPECT_THAT(layers_error(one_sided, many), HasSubstr("9 layers: give at most 8"));
}

// A recording must be replayed with the scene in which it was made: every key of an effect in a scene file is part of the hash.
TEST_F(EffectReader, EveryKeyIsPartOfTheHash) {
  std::set<std::uint64_t> hashes;
  std::size_t count = 0;
  const auto add = [&](const std::string& text) {
    hashes.insert(hash_of(text));
    ++count;
  };
  add(with_material(""));
  for (const char* line :
       {"progressive_n_per_m2 = 1", "viscosity_ns_per_m = 1", "snap_range_m = 0.001", "snap_range_m = 0.001\nsnap_stiffness_n_per_m = 7",
        "bump_height_m = 0.001", "bump_height_m = 0.001\nbump_length_m = 0.007", "bump_height_m = 0.001\nbump_pattern = 'ridges'",
        "bump_height_m = 0.001\nbump_pattern = 'ridges'\nbump_direction = [0, 1, 0]", "tap_ns_per_m = 1",
        "tap_ns_per_m = 1\ntap_frequency_hz = 7", "tap_ns_per_m = 1\ntap_decay_s = 0.7", "tap_ns_per_m = 1\ntap_max_force_n = 0.7"}) {
    add(with_material(line));
  }
  const std::string layer = "two_sided = false\n[[material.m.layer]]\n";
  for (const char* line :
       {"depth_m = 0\nstiffness_n_per_m = 1", "depth_m = 0.1\nstiffness_n_per_m = 1", "depth_m = 0\nstiffness_n_per_m = 2",
        "depth_m = 0\nstiffness_n_per_m = 1\npop_force_n = 1", "depth_m = 0\nstiffness_n_per_m = 1\npop_force_n = 1\ndrag_ns_per_m = 1",
        "depth_m = 0\nstiffness_n_per_m = 1\npop_force_n = 1\n[[material.m.layer]]\ndepth_m = 1\nstiffness_n_per_m = 1"}) {
    add(with_material(layer + line));
  }
  const std::string position = "\nposition_m = [0, 0, 0]\n";
  for (const char* type : {"spring", "magnet", "gravity_well"}) {
    const std::string begin = std::string("type = '") + type + "'";
    add(with_effect(begin + position));
    add(with_effect(begin + "\nposition_m = [0, 0, 1]\n"));
    add(with_effect(begin + position + "max_force_n = 0.7"));
  }
  add(with_effect("type = 'spring'" + position + "stiffness_n_per_m = 7"));
  add(with_effect("type = 'magnet'" + position + "range_m = 7"));
  add(with_effect("type = 'gravity_well'" + position + "radius_m = 7"));
  add(with_effect("type = 'line_snap'" + position + "direction = [0, 0, 1]"));
  add(with_effect("type = 'line_snap'" + position + "direction = [0, 1, 0]"));
  add(with_effect("type = 'plane_snap'" + position + "normal = [0, 0, 1]"));
  add(with_effect("type = 'constant'\nforce_n = [1, 0, 0]"));
  add(with_effect("type = 'constant'\nforce_n = [2, 0, 0]"));
  add(with_effect("type = 'constant'\nforce_n = [2, 0, 0]\nbutton = 1"));
  add(with_effect("type = 'constant'\nforce_n = [2, 0, 0]\nbutton = 3"));
  add(with_effect("type = 'constant'\nforce_n = [1, 0, 0]\nradius_m = 1" + position));
  add(with_effect("type = 'constant'\nforce_n = [1, 0, 0]\nradius_m = 2" + position));
  add(with_effect("type = 'constant'\nforce_n = [1, 0, 0]\nsize_m = [2, 2, 2]" + position));
  add(with_effect("type = 'viscous'\ndamping_ns_per_m = 1"));
  add(with_effect("type = 'viscous'\ndamping_ns_per_m = 2"));
  add(with_effect("type = 'viscous'\ndamping_ns_per_m = 1\nmax_force_n = 0.7"));
  const std::string mass = "type = 'mass'\nmass_kg = ";
  for (const char* line : {"0.1", "0.2", "0.1\nfilter_s = 0.07", "0.1\nmax_force_n = 0.7"}) add(with_effect(mass + line));
  add(with_effect(mass + "0.1\nradius_m = 1" + position));
  const std::string wave = "type = 'wave'\ndirection = [1, 0, 0]\n";
  for (const char* line : {"", "waveform = 'square'", "amplitude_n = 0.7", "frequency_hz = 7"}) add(with_effect(wave + line));
  add(with_effect("type = 'wave'\ndirection = [0, 1, 0]\n"));
  const std::string burst = "type = 'burst'\ndirection = [1, 0, 0]\nradius_m = 1" + position;
  for (const char* line : {"", "amplitude_n = 0.7", "frequency_hz = 7", "decay_s = 0.7", "duration_s = 0.7"})
    add(with_effect(burst + line));
  EXPECT_EQ(hashes.size(), count);
}

TEST_F(EffectReader, ASceneWithoutEffectsKeepsItsHash) {
  // Versions of Hapton without effects computed this value, so recordings made with them can still be replayed.
  TouchScene scene;
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  scene.objects.push_back({std::make_shared<const TriangleMesh>(mesh), {}});
  EXPECT_EQ(hash_scene(scene), 0x53B183C1F2E50A7BULL);
}

}  // namespace
}  // namespace hapton
