#include "haptics_node/scene_watcher.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <future>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/log_of.h"
#include "tests/support/patience.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using testing::HasSubstr;

// A scene of one triangle, its file, its watcher and the tasks that apply changes. The test polls, and takes results as ReplyLoop does.
struct SceneWatcherTest : testing::Test {
  SceneWatcherTest() {
    folder.write("a.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n");
    file = write("stiffness_n_per_m = 500");
    const auto loaded = load_scene(file);
    EXPECT_TRUE(loaded) << loaded.error().what;
    method = *make_method({}, loaded->touch_scene());
    material_task.emplace(*loaded, 0.0);
    builder.emplace(MethodSettings(), loaded->touch_scene(), method);
    watcher.emplace(SceneWatcher::Options{.path = file, .loading = {}, .on_scene = [this](const TouchScene& now) { felt_scene = now; }},
                    *loaded, *material_task, *builder);
  }

  std::filesystem::path write(const std::string& material, const std::string& object = "") {
    const auto path =
        folder.write("a.toml", "[[object]]\nmesh = 'a.obj'\nmaterial = 'm'\n" + object + "\n[material.m]\n" + material + "\n");
    // Two writes within the resolution of the file system's clock would look like one.
    std::filesystem::last_write_time(path, std::filesystem::file_time_type::clock::now() + std::chrono::seconds(++writes));
    return path;
  }
  SceneWatcher::Outcome poll_twice() {
    SceneWatcher::Outcome outcome = SceneWatcher::Outcome::waiting;
    log = log_of([&] {
      EXPECT_EQ(watcher->poll(), SceneWatcher::Outcome::waiting);
      outcome = watcher->poll();
    });
    return outcome;
  }
  std::unique_ptr<TunedMaterials> wait_for_materials() {
    std::unique_ptr<TunedMaterials> result;
    wait_until([&] { return (result = material_task->take()) != nullptr; });
    return result;
  }

  ScratchFolder folder;
  std::filesystem::path file;
  int writes = 0;
  std::string log;  // log of the last two polls
  TouchScene felt_scene;
  std::shared_ptr<ForceMethod> method;
  std::optional<MaterialTask> material_task;
  std::optional<MethodBuilder> builder;
  std::optional<SceneWatcher> watcher;
};

TEST_F(SceneWatcherTest, AFileThatIsNotTouchedIsNotRead) {
  EXPECT_EQ(watcher->poll(), SceneWatcher::Outcome::unchanged);
  write("stiffness_n_per_m = 500");
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::same) << "saved without a change";
  EXPECT_THAT(log, HasSubstr("a.toml was read again: nothing that affects the forces has changed"));
  EXPECT_EQ(watcher->poll(), SceneWatcher::Outcome::unchanged);
  std::filesystem::remove(file);
  EXPECT_EQ(watcher->poll(), SceneWatcher::Outcome::unchanged) << "an editor that replaces the file removes it for a moment";
}

// A mesh of ten million triangles takes many seconds: a person who quits does not wait for it.
TEST_F(SceneWatcherTest, ItsEndDoesNotWaitForAFileThatIsBeingRead) {
  std::promise<void> release;
  std::promise<void> read_begun;
  std::promise<void> read_ended;
  const std::future<void> read_end = read_ended.get_future();
  const auto read = [&, may_end = release.get_future().share()](const auto& path, const auto& loading) {
    read_begun.set_value();
    may_end.wait();
    auto scene = load_scene(path, loading);
    read_ended.set_value();
    return scene;
  };
  const auto loaded = load_scene(file);
  ASSERT_TRUE(loaded);
  watcher.emplace(SceneWatcher::Options{.path = file, .loading = {}, .read = read}, *loaded, *material_task, *builder);
  watcher->start();
  write("stiffness_n_per_m = 700");
  ASSERT_EQ(read_begun.get_future().wait_for(std::chrono::seconds(30)), std::future_status::ready);
  watcher.reset();
  EXPECT_EQ(read_end.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
  release.set_value();
  EXPECT_EQ(read_end.wait_for(std::chrono::seconds(30)), std::future_status::ready);
}

// The data prepared for picking up objects, and the places where objects were put down, must stay valid.
TEST_F(SceneWatcherTest, BesideMovableObjectsOnlyMaterialsChange) {
  constexpr const char* kRejected = "a.toml: the stylus picks up objects of this scene, so only stiffness, damping and friction may change";
  write("stiffness_n_per_m = 500", "movable = true");
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::rejected) << "it was not movable at the start";
  EXPECT_THAT(log, HasSubstr(kRejected));
  const auto loaded = load_scene(file);
  ASSERT_TRUE(loaded);
  watcher.emplace(SceneWatcher::Options{.path = file, .loading = {}}, *loaded, *material_task, *builder);
  write("stiffness_n_per_m = 700", "movable = true");
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::materials);
  const auto tuned = wait_for_materials();
  ASSERT_NE(tuned, nullptr);
  EXPECT_EQ(tuned->materials[0].stiffness_n_per_m, 700.0);
  for (const auto& [material, object] : {std::pair("stiffness_n_per_m = 700", "movable = true\nposition_m = [0, 0, 0.01]"),
                                         std::pair("stiffness_n_per_m = 700\nviscosity_ns_per_m = 1", "movable = true"),
                                         std::pair("stiffness_n_per_m = 700", "movable = true\nname = 'other'"),
                                         std::pair("stiffness_n_per_m = 700", ""), std::pair("stiffness_n_per_m = 800", "")}) {
    write(material, object);
    EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::rejected) << material << object;
    EXPECT_THAT(log, HasSubstr(kRejected));
  }
  EXPECT_EQ(builder->take(), nullptr);
  write("stiffness_n_per_m = 700", "movable = true");
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::same);
}

TEST_F(SceneWatcherTest, AToolStaysTheSame) {
  constexpr const char* kChanged = "a.toml: [tool] has changed: start haptics_node again";
  const std::string tool = "\n[tool]\nmesh = 'a.obj'";
  write("stiffness_n_per_m = 500" + tool);
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::rejected) << "there was none at the start";
  EXPECT_THAT(log, HasSubstr(kChanged));
  EXPECT_EQ(builder->take(), nullptr);
  const auto loaded = load_scene(file);
  ASSERT_TRUE(loaded);
  watcher.emplace(SceneWatcher::Options{.path = file, .loading = {}, .has_tool = true}, *loaded, *material_task, *builder);
  write("stiffness_n_per_m = 700" + tool);
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::materials);
  const auto tuned = wait_for_materials();
  ASSERT_NE(tuned, nullptr);
  EXPECT_EQ(tuned->materials[0].stiffness_n_per_m, 700.0);
  write("stiffness_n_per_m = 700\nviscosity_ns_per_m = 1" + tool);
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::rejected);
  EXPECT_THAT(log, HasSubstr("a.toml: the stylus holds a rigid tool in this scene, so only stiffness, damping and friction may change"));
  write("stiffness_n_per_m = 700" + tool + "\ngrip = 'centre'");
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::rejected);
  EXPECT_THAT(log, HasSubstr(kChanged));
  write("stiffness_n_per_m = 700");
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::rejected);
  EXPECT_THAT(log, HasSubstr(kChanged));
}

TEST_F(SceneWatcherTest, MaterialsAreTunedAndTheMethodStays) {
  write("stiffness_n_per_m = 700\nfriction_static = 0.3");
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::materials);
  EXPECT_THAT(log, HasSubstr("a.toml was read again: its materials fade in"));
  auto result = wait_for_materials();
  ASSERT_NE(result, nullptr);
  ASSERT_EQ(result->materials.size(), 1U);
  EXPECT_EQ(result->materials[0].stiffness_n_per_m, 700.0);
  EXPECT_EQ(result->materials[0].friction_static, 0.3);
  EXPECT_EQ(result->state.object_count, 1U);
  EXPECT_EQ(result->scene_revision, 0U);
  material_task->retire(std::move(result));
  EXPECT_EQ(builder->take(), nullptr);
  // Back to the stiffness at the start: the state then has no change of any object.
  write("stiffness_n_per_m = 500");
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::materials);
  result = wait_for_materials();
  ASSERT_NE(result, nullptr);
  EXPECT_EQ(result->materials[0].stiffness_n_per_m, 500.0);
  EXPECT_EQ(result->state.object_count, 0U);
}

TEST_F(SceneWatcherTest, OtherNamesComeWithTheSameMethodAndFadeNothing) {
  write("stiffness_n_per_m = 500", "name = 'other'");
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::scene);
  EXPECT_THAT(log, HasSubstr("a.toml was read again: only its names have changed; changes by hapton set end, and effects begin anew"));
  EXPECT_THAT(log, ::testing::Not(HasSubstr("fade")));
  auto built = builder->take();
  ASSERT_NE(built, nullptr);
  EXPECT_EQ(built->step->share_method(), method);
  builder->retire(std::move(built));
}

TEST_F(SceneWatcherTest, EffectsComeWithTheSameMethodAndAnotherShapeWithANewOne) {
  write("stiffness_n_per_m = 600\nviscosity_ns_per_m = 2");
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::scene);
  EXPECT_THAT(log, HasSubstr("a.toml was read again: its effects fade in"));
  auto built = builder->take();
  ASSERT_NE(built, nullptr);
  EXPECT_EQ(built->step->share_method(), method);
  EXPECT_TRUE(built->step->has_effects());
  ASSERT_NE(built->scene, nullptr);
  EXPECT_EQ(built->scene->revision, 1U);
  EXPECT_EQ(built->scene->materials.at(0).stiffness_n_per_m, 600.0);
  EXPECT_TRUE(felt_scene.has_effects());
  builder->retire(std::move(built));

  write("stiffness_n_per_m = 600", "[[object]]\nmesh = 'a.obj'\nposition_m = [0, 0, 0.02]");
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::scene);
  EXPECT_THAT(log, HasSubstr("a.toml was read again: its objects fade in"));
  ASSERT_TRUE(wait_until([&] { return (built = builder->take()) != nullptr; }));
  EXPECT_NE(built->step->share_method(), method);
  EXPECT_EQ(built->scene->revision, 2U);
  EXPECT_EQ(built->scene->touch.objects.size(), 2U);
  EXPECT_NE(built->scene->facts.given_hash, 0U);

  // From here on the names in requests by tools are those of the new scene.
  MaterialRequest request{.request = 4, .object = {"a"}, .change = {.fields = MaterialChange::kStiffness, .stiffness_n_per_m = 800}};
  material_task->request(request);
  const auto result = wait_for_materials();
  ASSERT_NE(result, nullptr);
  EXPECT_EQ(result->materials.size(), 2U);
  EXPECT_EQ(result->scene_revision, 2U);
}

TEST_F(SceneWatcherTest, APlugInThatAppearsIsNotLoaded) {
  write("stiffness_n_per_m = 700\n[[effect]]\ntype = 'plugin'\nlibrary = 'x.so'");
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::rejected);
  EXPECT_THAT(log, HasSubstr("its plug-ins have changed: start haptics_node again to use it; the present scene stays in use"));
  EXPECT_EQ(material_task->take(), nullptr);
  EXPECT_EQ(builder->take(), nullptr);
}

// What was carved stays carved, so the objects that can be carved must stay the same.
TEST_F(SceneWatcherTest, WhatCanBeCarvedStaysTheSameObject) {
  const TriangleMesh box = make_box(Vec3::Constant(0.04));
  std::string obj;
  for (const Vec3& v : box.vertices) obj += fmt::format("v {} {} {}\n", v.x(), v.y(), v.z());
  for (const Triangle& t : box.triangles) obj += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  folder.write("box.obj", obj);
  const auto with_clay = [](const std::string& keys) {
    return "[[object]]\nmesh = 'box.obj'\nname = 'clay'\nmaterial = 'm'\nsculpt = true\n" + keys;
  };
  write("stiffness_n_per_m = 500", with_clay("voxel_mm = 4"));
  const auto loaded = load_scene(file);
  ASSERT_TRUE(loaded) << loaded.error().what;
  MethodBuilder clay_builder(MethodSettings(), loaded->touch_scene(),
                             std::shared_ptr<ForceMethod>(*make_method({}, loaded->touch_scene())));
  watcher.emplace(SceneWatcher::Options{.path = file, .loading = {}}, *loaded, *material_task, clay_builder);
  for (const std::string& changed : {with_clay("voxel_mm = 5"), with_clay("voxel_mm = 4\ntool_radius_mm = 21"),
                                     with_clay("voxel_mm = 4\nposition_m = [0, 0, 0.02]"), std::string()}) {
    write("stiffness_n_per_m = 500", changed);
    EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::rejected) << changed;
    EXPECT_THAT(log, HasSubstr("objects of this scene can be carved, and the shapes of its objects have changed"));
  }
  write("stiffness_n_per_m = 650", with_clay("voxel_mm = 4"));
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::materials);
}

TEST_F(SceneWatcherTest, WhatProgramsMoveStaysTheSameObject) {
  const std::string lid = "name = 'lid'\nmoved_by = 'program'\npivot_m = [0.01, 0, 0]";
  const std::string block = "\n[[object]]\nname = 'block'\nmesh = 'a.obj'\n";
  write("stiffness_n_per_m = 500", lid + block);
  const auto loaded = load_scene(file);
  ASSERT_TRUE(loaded) << loaded.error().what;
  MethodBuilder lid_builder(MethodSettings(), loaded->touch_scene(), std::shared_ptr<ForceMethod>(*make_method({}, loaded->touch_scene())));
  watcher.emplace(SceneWatcher::Options{.path = file, .loading = {}}, *loaded, *material_task, lid_builder);

  write("stiffness_n_per_m = 500", lid + block + "position_m = [0, 0, 0.03]\n");
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::scene) << "another object has another place";
  for (const std::string& changed :
       {lid + "\nposition_m = [0, 0, 0.02]" + block, lid + "\nscale = 0.5" + block, lid + "\nrotation_deg = [0, 0, 5]" + block,
        "name = 'lid'\nmoved_by = 'program'\npivot_m = [0, 0, 0]" + block, "name = 'lid'" + block,
        "name = 'cover'\nmoved_by = 'program'\n"
        "pivot_m = [0.01, 0, 0]" +
            block,
        lid, lid + block + "moved_by = 'program'\n"}) {
    write("stiffness_n_per_m = 500", changed);
    EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::rejected) << changed;
    EXPECT_THAT(log, HasSubstr("programs move objects of this scene, and their shapes"));
  }
  write("stiffness_n_per_m = 650", lid + block + "position_m = [0, 0, 0.03]\n");
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::materials);
}

TEST_F(SceneWatcherTest, WhatProgramsDeformStaysTheSameObject) {
  const std::string by_program = "deformed_by = 'program'\nreach_m = 0.02\n";
  write("stiffness_n_per_m = 500", by_program);
  const auto loaded = load_scene(file);
  ASSERT_TRUE(loaded) << loaded.error().what;
  MethodBuilder sheet_builder(MethodSettings(), loaded->touch_scene(),
                              std::shared_ptr<ForceMethod>(*make_method({}, loaded->touch_scene())));
  watcher.emplace(SceneWatcher::Options{.path = file, .loading = {}}, *loaded, *material_task, sheet_builder);
  for (const std::string& changed : {std::string("deformed_by = 'program'\nreach_m = 0.03\n"), by_program + "position_m = [0, 0, 0.02]\n",
                                     by_program + "name = 'b'\n", by_program + "[[object]]\nname = 'b'\nmesh = 'a.obj'\n", std::string()}) {
    write("stiffness_n_per_m = 500", changed);
    EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::rejected) << changed;
    EXPECT_THAT(log, HasSubstr("programs deform objects of this scene, and the shapes or the names of its objects have changed"));
  }
  write("stiffness_n_per_m = 650", by_program);
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::materials);
}

// A recording has the differences between the materials in use and those of the scene that the recording names.
TEST_F(SceneWatcherTest, AfterAnotherSceneMaterialsAreDescribedAsDifferencesFromThatOne) {
  const std::string effect = "\nviscosity_ns_per_m = 2";
  write("stiffness_n_per_m = 600" + effect);
  ASSERT_EQ(poll_twice(), SceneWatcher::Outcome::scene);
  for (const double stiffness_n_per_m : {700.0, 600.0}) {
    write(fmt::format("stiffness_n_per_m = {}", stiffness_n_per_m) + effect);
    ASSERT_EQ(poll_twice(), SceneWatcher::Outcome::materials);
    auto result = wait_for_materials();
    ASSERT_NE(result, nullptr);
    EXPECT_EQ(result->materials.at(0).stiffness_n_per_m, stiffness_n_per_m);
    EXPECT_EQ(result->state.object_count, stiffness_n_per_m == 600.0 ? 0U : 1U);
    EXPECT_EQ(result->scene_revision, 1U);
    material_task->retire(std::move(result));
  }
}

// There are more materials than a message can describe, so the scene is replaced as a whole.
TEST_F(SceneWatcherTest, ManyMaterialsComeAsAnotherScene) {
  const auto write_many = [&](int stiffness_n_per_m) {
    std::string objects;
    std::string materials = fmt::format("stiffness_n_per_m = {}", stiffness_n_per_m);
    for (std::size_t n = 1; n <= MaterialState::kMaxObjects; ++n) {
      objects += fmt::format("\n[[object]]\nname = 'o{0}'\nmesh = 'a.obj'\nmaterial = 'm{0}'", n);
      materials += fmt::format("\n[material.m{}]\nstiffness_n_per_m = {}", n, stiffness_n_per_m);
    }
    write(materials, objects);
  };
  write_many(500);
  const auto loaded = load_scene(file);
  ASSERT_TRUE(loaded) << loaded.error().what;
  MethodBuilder large_builder(MethodSettings(), loaded->touch_scene());
  watcher.emplace(SceneWatcher::Options{.path = file, .loading = {}}, *loaded, *material_task, large_builder);
  write_many(600);
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::scene);
  EXPECT_THAT(log, HasSubstr("a.toml was read again: its materials fade in; changes by hapton set end, and effects begin anew"));
  const auto built = large_builder.take();
  ASSERT_NE(built, nullptr);
  EXPECT_EQ(built->scene->materials.at(MaterialState::kMaxObjects).stiffness_n_per_m, 600.0);
}

TEST_F(SceneWatcherTest, AFileWithAnErrorChangesNothingUntilItIsGood) {
  write("stifness_n_per_m = 700");
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::rejected);
  EXPECT_THAT(log, HasSubstr("; the present scene stays in use"));
  EXPECT_THAT(log, HasSubstr("stifness_n_per_m"));
  EXPECT_EQ(watcher->poll(), SceneWatcher::Outcome::unchanged) << "one line, not one a second";
  EXPECT_EQ(material_task->take(), nullptr);
  EXPECT_EQ(builder->take(), nullptr);
  write("stiffness_n_per_m = 700");
  EXPECT_EQ(poll_twice(), SceneWatcher::Outcome::materials);
}

// The log says so once, and not during the moment in which an editor replaces the file.
TEST_F(SceneWatcherTest, AFileThatIsGoneIsOneLine) {
  const auto aside = folder.path() / "aside.toml";
  const auto log_of_polls = [&](int polls) {
    return log_of([&] {
      for (int i = 0; i < polls; ++i) EXPECT_EQ(watcher->poll(), SceneWatcher::Outcome::unchanged);
    });
  };
  std::filesystem::rename(file, aside);
  EXPECT_EQ(log_of_polls(1), "");
  EXPECT_THAT(log_of_polls(1), HasSubstr("a.toml is gone; the present scene stays in use"));
  EXPECT_EQ(log_of_polls(3), "");
  std::filesystem::rename(aside, file);
  EXPECT_EQ(log_of_polls(1), "") << "the file is the same as before";
  std::filesystem::rename(file, aside);
  EXPECT_THAT(log_of_polls(2), HasSubstr("is gone"));
}

TEST_F(SceneWatcherTest, PollsInItsOwnThread) {
  watcher->start();
  write("stiffness_n_per_m = 900");
  const auto result = wait_for_materials();
  ASSERT_NE(result, nullptr);
  EXPECT_EQ(result->materials[0].stiffness_n_per_m, 900.0);
}

}  // namespace
}  // namespace hapton
