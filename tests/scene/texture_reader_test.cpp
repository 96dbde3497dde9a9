#include "scene/texture_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "core/force/touch_step.h"
#include "scene/scene_file.h"
#include "scene/scene_hash.h"
#include "scene/scene_report.h"
#include "tests/scene/made_texture_file.h"
#include "tests/scene/sample_files.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class TextureReader : public ::testing::Test {
 protected:
  TextureReader() {
    folder_.write("a.obj", sample::obj(sample::tetrahedron()));
    folder_.write("made.xml", made::texture_file());
  }

  // The material's keys begin with line 5.
  std::filesystem::path write(const std::string& lines, const std::string& object = "") {
    return folder_.write("a.toml", "[[object]]\nmesh = 'a.obj'\nmaterial = 'm'\n[material.m]\n" + lines + "\n" + object);
  }
  std::string error_of(const std::string& lines, const std::string& object = "") {
    const auto scene = load_scene(write(lines, object));
    if (scene) return "it was read";
    EXPECT_THAT(scene.error().what, StartsWith((folder_.path() / "a.toml").string() + ": line "));
    EXPECT_EQ(scene.error().what.find('\n'), std::string::npos) << scene.error().what;
    return scene.error().what;
  }
  std::uint64_t hash_of(const std::string& lines) {
    const auto scene = load_scene(write(lines));
    EXPECT_TRUE(scene) << lines << scene.error().what;
    return scene ? hash_scene(scene->touch_scene()) : 0;
  }

  ScratchFolder folder_;
};

TEST_F(TextureReader, ReadsItsKeys) {
  const auto scene = load_scene(write("recorded_texture = 'made.xml'\ntexture_mass_kg = 0.08\ntexture_max_force_n = 1.5",
                                      "[[object]]\nmesh = 'a.obj'\nmaterial = 'n'\n[material.n]\nrecorded_texture = 'made.xml'"));
  ASSERT_TRUE(scene) << scene.error().what;
  const RecordedTexture& texture = scene->objects[0].effects.texture;
  ASSERT_TRUE(texture.is_on());
  EXPECT_EQ(texture.models->models().size(), 9U);
  EXPECT_EQ(texture.mass_kg, 0.08);
  EXPECT_EQ(texture.max_force_n, 1.5);
  EXPECT_EQ(scene->objects[1].effects.texture.models, texture.models) << "read once";
  EXPECT_EQ(scene->objects[1].effects.texture.mass_kg, RecordedTexture().mass_kg);
  EXPECT_TRUE(scene->touch_scene().has_effects());
}

TEST_F(TextureReader, SaysWhatIsWrong) {
  EXPECT_THAT(error_of("recorded_texture = ''"), HasSubstr("line 5: 'recorded_texture' is empty"));
  EXPECT_THAT(error_of("recorded_texture = 7"), HasSubstr("must be a text in quotes"));
  EXPECT_THAT(error_of("texture_mass_kg = 0.1"), HasSubstr("'texture_mass_kg' has no effect without 'recorded_texture'"));
  EXPECT_THAT(error_of("texture_max_force_n = 1"), HasSubstr("'texture_max_force_n' has no effect without 'recorded_texture'"));
  EXPECT_THAT(error_of("recorded_texture = 'made.xml'\ntexture_mass_kg = 0"), HasSubstr("line 6: 'texture_mass_kg'"));
  EXPECT_THAT(error_of("recorded_texture = 'made.xml'\ntexture_max_force_n = 101"), HasSubstr("line 6: 'texture_max_force_n'"));
  EXPECT_THAT(error_of("two_sided = true\nrecorded_texture = 'gone.xml'"),
              AllOf(HasSubstr("line 6: 'recorded_texture': " + (folder_.path() / "gone.xml").string()), HasSubstr("no such file")));
  folder_.write("broken.xml", "<modelSet/>");
  EXPECT_THAT(error_of("recorded_texture = 'broken.xml'"), HasSubstr("broken.xml: line 1: <modelSet> has no <SampleRate>"));
  EXPECT_THAT(error_of("recorded_textures = 'made.xml'"), HasSubstr("recorded_texture"));
}

TEST_F(TextureReader, EveryNumberIsPartOfTheHash) {
  folder_.write("slow.xml", made::texture_file(made::nine_models(20, 18), made::eight_triangles(), 900.0));
  folder_.write("ar.xml", made::texture_file(made::nine_models(20, 0), made::eight_triangles()));
  auto triangles = made::eight_triangles();
  triangles.pop_back();
  folder_.write("open.xml", made::texture_file(made::nine_models(20, 18), triangles));
  int count = 0;
  std::set<std::uint64_t> hashes;
  const auto add = [&](const std::string& lines) {
    hashes.insert(hash_of(lines));
    ++count;
  };
  add("");
  for (const char* file : {"made.xml", "slow.xml", "ar.xml", "open.xml"}) add(std::string("recorded_texture = '") + file + "'");
  add("recorded_texture = 'made.xml'\ntexture_mass_kg = 0.07");
  add("recorded_texture = 'made.xml'\ntexture_max_force_n = 0.7");
  const auto changed = [&](auto change) {
    auto models = made::nine_models(20, 18);
    change(models[4]);
    folder_.write("changed.xml", made::texture_file(models, made::eight_triangles()));
    add("recorded_texture = 'changed.xml'");
  };
  changed([](TextureModel& m) { m.ar[7] += 1e-5; });
  changed([](TextureModel& m) { m.ma[7] += 1e-5; });
  changed([](TextureModel& m) { m.variance += 1e-5; });
  changed([](TextureModel& m) { m.gain += 1e-5; });
  changed([](TextureModel& m) { m.speed_m_per_s += 1e-5; });
  changed([](TextureModel& m) { m.force_n += 1e-5; });
  EXPECT_EQ(static_cast<int>(hashes.size()), count);
}

// The same samples give the same forces to the last bit, in a new TouchStep and after a reset: `hapton replay` compares them exactly.
TEST_F(TextureReader, ForcesRepeatBitForBit) {
  folder_.write("floor.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3\nf 1 3 4\n");
  const auto scene = load_scene(folder_.write("floor.toml",
                                              "[[object]]\nmesh = 'floor.obj'\nunit = 'm'\nmaterial = 'm'\n[material.m]\n"
                                              "stiffness_n_per_m = 800\nrecorded_texture = 'made.xml'\ntexture_mass_kg = 0.05\n"));
  ASSERT_TRUE(scene) << scene.error().what;
  const TouchScene touch = scene->touch_scene();
  const auto begin = [&](const char* name) {
    auto method = make_method({.name = name}, touch);
    EXPECT_TRUE(method);
    return TouchStep(std::move(*method), touch);
  };
  const auto run = [](TouchStep& step) {
    std::vector<Vec3> forces;
    for (int n = 0; n < 3000; ++n) {
      const Vec3 p(0.1 * std::sin(0.002 * n), 0.05 * std::cos(0.003 * n), 0.004 * std::cos(0.004 * n) - 0.001);
      if (n == 0) step.reset({.p_WD = p});
      forces.push_back(step.step({.p_WD = p, .dt_s = 1e-3}).force_n);
    }
    return forces;
  };
  for (const char* name : {"proxy", "smooth", "sweep", "reference"}) {
    TouchStep step = begin(name);
    TouchStep new_step = begin(name);
    const auto forces = run(step);
    EXPECT_EQ(forces, run(step)) << name << ": after a reset";
    EXPECT_EQ(forces, run(new_step)) << name << ": in a new step";
    double sideways_n = 0.0;
    for (const Vec3& force_n : forces) sideways_n = std::max(sideways_n, force_n.head<2>().norm());
    EXPECT_GT(sideways_n, 0.02) << name;
  }
}

TEST_F(TextureReader, TheReportNamesIt) {
  const auto report = make_scene_report(write("recorded_texture = 'made.xml'"));
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_THAT(to_text(*report), HasSubstr("effects: recorded texture (9 models of 1000 Hz, at most"));
  EXPECT_THAT(to_json(*report), HasSubstr("recorded texture"));
}

}  // namespace
}  // namespace hapton
