#include "scene/scene_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/scene_layout.h"
#include "tests/scene/sample_files.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

constexpr double kSceneTolerance = 1e-12;

class SceneFile : public ::testing::Test {
 protected:
  SceneFile() { folder_.write("a.obj", sample::obj(sample::tetrahedron())); }

  Result<Scene> load(const std::string& text) { return load_scene(folder_.write("a.toml", text)); }

  std::string error_of(const std::string& text) {
    const auto scene = load(text);
    if (scene) return "it was read";
    EXPECT_THAT(scene.error().what, StartsWith((folder_.path() / "a.toml").string() + ": "));
    EXPECT_EQ(scene.error().what.find('\n'), std::string::npos) << scene.error().what;
    return scene.error().what;
  }

  std::string material_error(const std::string& line) {
    return error_of("[[object]]\nmesh = 'a.obj'\nmaterial = 'm'\n[material.m]\n" + line + "\n");
  }

  std::string object_error(const std::string& line) { return error_of("[[object]]\nmesh = 'a.obj'\n" + line + "\n"); }

  ScratchFolder folder_;
};

Eigen::AlignedBox3d box_of(const Scene& scene) {
  Eigen::AlignedBox3d box;
  for (const SceneObject& object : scene.objects) {
    for (const Vec3& v : object.mesh->vertices) box.extend(v);
  }
  return box;
}

TEST_F(SceneFile, ReadsEveryKey) {
  const auto scene = load(R"(
[[object]]
mesh = "a.obj"
name = "first"
unit = "cm"
scale = 2
rotation_deg = [0, 0, 90]
position_m = [1, 2.5, 3]
material = "soft"
color = [1, 0.5, 0]
[[object]]
mesh = "a.obj"
[material.soft]
stiffness_n_per_m = 300
damping_ns_per_m = 1.5
friction_static = 0.5
friction_dynamic = 0.4
two_sided = false
)");
  ASSERT_TRUE(scene) << scene.error().what;
  ASSERT_THAT(scene->objects, SizeIs(2));
  const SceneObject& first = scene->objects[0];
  EXPECT_EQ(first.name, "first");
  EXPECT_EQ(first.colour, (std::array<double, 3>{1, 0.5, 0}));
  EXPECT_EQ(first.material.stiffness_n_per_m, 300);
  EXPECT_EQ(first.material.damping_ns_per_m, 1.5);
  EXPECT_EQ(first.material.friction_static, 0.5);
  EXPECT_EQ(first.material.friction_dynamic, 0.4);
  EXPECT_FALSE(first.material.two_sided);
  EXPECT_LT((first.mesh->corner(0, 1) - Vec3(1, 2.5 + 0.03, 3)).norm(), kSceneTolerance);
  EXPECT_EQ(scene->objects[1].name, "a");
  EXPECT_EQ(scene->objects[1].material.stiffness_n_per_m, Material().stiffness_n_per_m);
  EXPECT_EQ(scene->objects[1].mesh->corner(0, 1), Vec3(1.5, 0, 0));
}

TEST_F(SceneFile, TouchSceneSharesTheMeshes) {
  const auto scene = load("[[object]]\nmesh = 'a.obj'\nmaterial = 'm'\n[material.m]\nstiffness_n_per_m = 42\n");
  ASSERT_TRUE(scene) << scene.error().what;
  const TouchScene touch = scene->touch_scene();
  ASSERT_THAT(touch.objects, SizeIs(1));
  EXPECT_EQ(touch.objects[0].mesh, scene->objects[0].mesh);
  EXPECT_EQ(touch.objects[0].material.stiffness_n_per_m, 42);
}

TEST_F(SceneFile, TurnsAboutFixedAxesXThenYThenZ) {
  // x by 90 takes (1.5, 0, 0) to itself, (0, 2.25, 0) to (0, 0, 2.25); then z by 90 takes those to (0, 1.5, 0) and (0, 0, 2.25).
  const auto scene = load("[[object]]\nmesh = 'a.obj'\nrotation_deg = [90, 0, 90]\n");
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_LT((scene->objects[0].mesh->corner(0, 1) - Vec3(0, 1.5, 0)).norm(), kSceneTolerance);
  EXPECT_LT((scene->objects[0].mesh->corner(0, 2) - Vec3(0, 0, 2.25)).norm(), kSceneTolerance);
}

TEST_F(SceneFile, QuaternionIsWxyz) {
  const auto by_degrees = load("[[object]]\nmesh = 'a.obj'\nrotation_deg = [0, 90, 0]\n");
  const auto by_quaternion = load("[[object]]\nmesh = 'a.obj'\nrotation = [0.7071067811865476, 0, 0.7071067811865476, 0]\n");
  ASSERT_TRUE(by_degrees && by_quaternion);
  for (int k = 0; k < 3; ++k) {
    EXPECT_LT((by_degrees->objects[0].mesh->corner(1, k) - by_quaternion->objects[0].mesh->corner(1, k)).norm(), kSceneTolerance);
  }
}

TEST_F(SceneFile, FitsAllObjectsTogetherAroundTheOrigin) {
  const auto scene = load("fit_m = [0.3, 0.3, 0.3]\n[[object]]\nmesh = 'a.obj'\n[[object]]\nmesh = 'a.obj'\nposition_m = [4.5, 0, 0]\n");
  ASSERT_TRUE(scene) << scene.error().what;
  const auto box = box_of(*scene);
  EXPECT_LT(box.center().norm(), kSceneTolerance);
  EXPECT_NEAR(box.sizes().x(), 0.3, kSceneTolerance);
  EXPECT_NEAR(box.sizes().y(), 0.3 * 2.25 / 6.0, kSceneTolerance);
}

TEST_F(SceneFile, RejectsToFitAPoint) {
  folder_.write("point.obj", "v 1 1 1\nf 1 1 1\n");
  EXPECT_THAT(error_of("fit_m = [1, 1, 1]\n[[object]]\nmesh = 'point.obj'\n"), HasSubstr("one point"));
  folder_.write("line.obj", "v 1 1 1\nv 3 1 1\nf 1 2 2\n");
  const auto line = load("fit_m = [1, 1, 1]\n[[object]]\nmesh = 'line.obj'\n");
  ASSERT_TRUE(line) << line.error().what;
  EXPECT_DOUBLE_EQ(box_of(*line).sizes().x(), 1.0);
}

TEST_F(SceneFile, TakesOnePartOfAFile) {
  folder_.write("two.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 5\no one\nf 1 2 3\no two\nf 2 4 3\nf 2 3 4\n");
  const auto scene = load("[[object]]\nmesh = 'two.obj'\npart = 'two'\n");
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_EQ(scene->objects[0].name, "two");
  EXPECT_THAT(scene->objects[0].mesh->triangles, SizeIs(2));
  EXPECT_THAT(scene->objects[0].mesh->vertices, SizeIs(3));
  EXPECT_THAT(error_of("[[object]]\nmesh = 'two.obj'\npart = 'three'\n"), AllOf(HasSubstr("line 3"), HasSubstr("no part 'three'")));
}

TEST_F(SceneFile, TakesAPlainMeshFile) {
  const auto scene = load_scene(folder_.path() / "a.obj", {.unit = Unit::mm});
  ASSERT_TRUE(scene) << scene.error().what;
  ASSERT_THAT(scene->objects, SizeIs(1));
  EXPECT_EQ(scene->objects[0].name, "a");
  EXPECT_DOUBLE_EQ(scene->objects[0].mesh->corner(0, 1).x(), 0.0015);
}

// In TOML, a key belongs to the last table header above it, so keys of the whole scene must stand above all tables.
TEST_F(SceneFile, SaysWhereAKeyOfTheWholeSceneBelongs) {
  const auto names_its_place = [](const char* line) {
    return AllOf(HasSubstr(line), HasSubstr("'fit_m' is a key of the whole scene"), HasSubstr("above the first line that begins with ["));
  };
  const std::string object = "[[object]]\nmesh = 'a.obj'\n";
  EXPECT_THAT(error_of(object + "fit_m = [1, 1, 1]\n"), names_its_place("line 3: "));
  EXPECT_THAT(error_of(object + "[material.steel]\nstiffness_n_per_m = 500\nfit_m = [1, 1, 1]\n"), names_its_place("line 5: "));
  EXPECT_THAT(error_of(object + "[camera]\nposition_m = [0, 0, 1]\nfit_m = [1, 1, 1]\n"), names_its_place("line 5: "));
  EXPECT_TRUE(load("fit_m = [1, 1, 1]\n" + object));
  EXPECT_TRUE(load(object + "material = 'fit_m'\n[material.fit_m]\nstiffness_n_per_m = 500\n")) << "a material of that name";
  EXPECT_TRUE(load(object + "[[effect]]\ntype = 'plugin'\nlibrary = 'x.so'\nparameters = { fit_m = 3 }\n")) << "a parameter of that name";
}

TEST_F(SceneFile, HintsAtTheKeyThatWasMeant) {
  EXPECT_THAT(material_error("stifness_n_per_m = 1"), AllOf(HasSubstr("line 5"), HasSubstr("did you mean 'stiffness_n_per_m'?")));
  EXPECT_THAT(material_error("stiffness = 1"), HasSubstr("did you mean 'stiffness_n_per_m'?"));
  EXPECT_THAT(object_error("colour = [1, 1, 1]"), AllOf(HasSubstr("line 3"), HasSubstr("did you mean 'color'?")));
  EXPECT_THAT(object_error("wobble_m = 1"), HasSubstr("known are name, mesh"));
  EXPECT_THAT(error_of("[[objects]]\nmesh = 'a.obj'\n"), AllOf(HasSubstr("line 1"), HasSubstr("did you mean 'object'?")));
  EXPECT_THAT(error_of("[[object]]\nmesh = 'a.obj'\nmaterial = 'steal'\n[material.steel]\n"), HasSubstr("did you mean 'steel'?"));
}

TEST_F(SceneFile, RejectsAbsurdMaterials) {
  EXPECT_THAT(material_error("stiffness_n_per_m = -1"), AllOf(HasSubstr("line 5"), HasSubstr("'stiffness_n_per_m'"), HasSubstr("-1")));
  EXPECT_THAT(material_error("stiffness_n_per_m = 0"), HasSubstr("must be above 0"));
  EXPECT_THAT(material_error("stiffness_n_per_m = inf"), HasSubstr("inf"));
  EXPECT_THAT(material_error("stiffness_n_per_m = nan"), HasSubstr("nan"));
  EXPECT_THAT(material_error("stiffness_n_per_m = '1'"), HasSubstr("must be a number"));
  EXPECT_THAT(material_error("stiffness_n_per_m = true"), HasSubstr("must be a number"));
  EXPECT_THAT(material_error("damping_ns_per_m = -0.1"), HasSubstr("at least 0"));
  EXPECT_THAT(material_error("friction_static = 0.2\nfriction_dynamic = 0.3"), AllOf(HasSubstr("line 6"), HasSubstr("more than")));
  EXPECT_THAT(material_error("two_sided = 1"), HasSubstr("true or false"));
}

TEST_F(SceneFile, RejectsAbsurdObjects) {
  EXPECT_THAT(object_error("scale = 0"), AllOf(HasSubstr("line 3"), HasSubstr("above 0")));
  EXPECT_THAT(object_error("scale = -1"), HasSubstr("above 0"));
  EXPECT_THAT(object_error("unit = 'ft'"), HasSubstr("'unit': unknown unit 'ft'"));
  EXPECT_THAT(object_error("position_m = [0, 0]"), HasSubstr("3 numbers"));
  EXPECT_THAT(object_error("position_m = [0, 0, nan]"), HasSubstr("number 3"));
  EXPECT_THAT(object_error("rotation = [0, 0, 0, 0]"), HasSubstr("length 0"));
  EXPECT_THAT(object_error("rotation = [1, 0, 0, 0]\nrotation_deg = [0, 0, 0]"), HasSubstr("keep one"));
  EXPECT_THAT(object_error("color = [0, 0, 2]"), HasSubstr("at most 1"));
  EXPECT_THAT(object_error("material = 'none'"), HasSubstr("no [material.none]"));
  EXPECT_THAT(error_of("[[object]]\nname = 'a'\n"), HasSubstr("has no 'mesh'"));
  EXPECT_THAT(error_of("[[object]]\nmesh = 'none.obj'\n"), AllOf(HasSubstr("line 2"), HasSubstr("no such file")));
  EXPECT_THAT(error_of("[[object]]\nmesh = 3\n"), HasSubstr("text in quotes"));
}

TEST_F(SceneFile, RejectsWhatIsNoScene) {
  EXPECT_THAT(error_of("# nothing\n"), HasSubstr("no [[object]]"));
  EXPECT_THAT(error_of("object = []\n"), HasSubstr("no [[object]]"));
  EXPECT_THAT(error_of("object = 1\n"), HasSubstr("line 1: 'object' must be tables that begin with [[object]]"));
  EXPECT_THAT(error_of("object = [1, {mesh = 'a.obj'}]\n"), HasSubstr("line 1: 'object' must be tables that begin with [[object]]"));
  EXPECT_THAT(error_of("material = 1\n"), HasSubstr("[material.steel]"));
  EXPECT_THAT(error_of("[[object]\n"), HasSubstr("line 1"));
  EXPECT_THAT(error_of("fit_m = [0, 1, 1]\n[[object]]\nmesh = 'a.obj'\n"), HasSubstr("number 1 of 'fit_m'"));
  EXPECT_THAT(error_of(std::string(100000, '[')), HasSubstr("line 1"));
  EXPECT_THAT(load_scene(folder_.path() / "none.toml").error().what, HasSubstr("no such file"));
  EXPECT_THAT(load_scene(folder_.path()).error().what, HasSubstr("is a folder"));
  EXPECT_THAT(load_scene(folder_.write("a.txt", "x")).error().what, HasSubstr("neither a scene"));
  EXPECT_THAT(load_scene(folder_.write("b.toml", "[[object]]\nmesh = 'a.obj'\n"), {.unit = Unit::mm}).error().what,
              HasSubstr("leave the unit out"));
}

TEST_F(SceneFile, SurvivesBeingCutAnywhere) {
  const std::string text =
      "fit_m = [1, 1, 1]\n[[object]]\nmesh = 'a.obj'\nrotation_deg = [0, 90, 0]\nmaterial = 'm'\n[material.m]\nfriction_static = 0.5\n";
  for (std::size_t size = 0; size < text.size(); ++size) {
    const auto scene = load(text.substr(0, size));
    if (scene)
      EXPECT_THAT(scene->objects, SizeIs(1));
    else
      EXPECT_FALSE(scene.error().what.empty());
  }
}

TEST(ShippedScenes, AllFitTheWorkspaceOfTheDevice) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(HAPTON_SOURCE_DIR "/scenes")) {
    if (entry.path().extension() != ".toml") continue;
    const auto scene = load_scene(entry.path());
    ASSERT_TRUE(scene) << scene.error().what;
    const auto box = box_of(*scene);
    // The workspace measures 10.5 x 7.5 x 15 inches (docs/frames.md).
    EXPECT_LT(box.sizes().x(), 0.2671) << entry.path();
    EXPECT_LT(box.sizes().y(), 0.1906) << entry.path();
    EXPECT_LT(box.sizes().z(), 0.3811) << entry.path();
    ++count;
    // A scene with [workspace] need not be centred, because its moving objects need room; it must still lie in the workspace.
    const auto layout = read_layout(entry.path());
    ASSERT_TRUE(layout) << layout.error().what;
    if (layout->workspace) {
      EXPECT_TRUE((box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()) - Vec3(0.1336, 0.0953, 0.1906)).maxCoeff() < 0.0) << entry.path();
    } else {
      EXPECT_LT(box.center().norm(), 1e-9) << entry.path();
    }
  }
  EXPECT_GE(count, 8);
}

TEST(ShippedScenes, TheCarFrontFacesTheHand) {
  const auto scene = load_scene(HAPTON_SOURCE_DIR "/scenes/car_front.toml");
  ASSERT_TRUE(scene) << scene.error().what;
  ASSERT_THAT(scene->objects, SizeIs(1));
  const TriangleMesh& mesh = *scene->objects[0].mesh;
  EXPECT_THAT(mesh.triangles, SizeIs(3300));
  EXPECT_NEAR(box_of(*scene).sizes().x(), 0.267, 1e-9);
  // The mesh was cut off at the back, so its open boundaries are at the lowest z, and the bonnet rises towards the back.
  double top_front = -1;
  double top_back = -1;
  for (const Vec3& v : mesh.vertices) (v.z() > 0 ? top_front : top_back) = std::max(v.z() > 0 ? top_front : top_back, v.y());
  EXPECT_GT(top_back, top_front);
}

TEST(ShippedScenes, TheAssemblyHasSixObjects) {
  const auto scene = load_scene(HAPTON_SOURCE_DIR "/scenes/nist_assembly.toml");
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_THAT(scene->objects, SizeIs(6));
  EXPECT_NE(scene->objects[0].material.stiffness_n_per_m, scene->objects[2].material.stiffness_n_per_m);
}

TEST(ShippedScenes, TheWorkbenchHasPegsToPickUp) {
  const auto scene = load_scene(HAPTON_SOURCE_DIR "/scenes/workbench.toml");
  ASSERT_TRUE(scene) << scene.error().what;
  ASSERT_THAT(scene->objects, SizeIs(6));
  for (std::size_t o = 0; o < 6; ++o) EXPECT_EQ(scene->objects[o].is_movable, o >= 3) << o;
  const ScratchFolder folder;
  folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_THAT(load_scene(folder.write("a.toml", "[[object]]\nmesh = 'a.obj'\nmovable = 1\n")).error().what,
              HasSubstr("'movable' in [[object]] 1 must be true or false"));
  EXPECT_THAT(load_scene(folder.write("b.toml", "[[object]]\nmesh = 'a.obj'\n[tool]\nmesh = 'a.obj'\nmovable = true\n")).error().what,
              HasSubstr("unknown key 'movable'"));
}

// Sealing cracks does not change the hash, so the drawn and the haptic scene of a file agree. Another unit, pose or mesh does.
TEST(SceneAsGiven, HasAHashOfWhatTheFilesGive) {
  const ScratchFolder folder;
  folder.write("a.stl", sample::binary_stl(sample::tetrahedron()));
  folder.write("b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto hash_of = [&](const std::string& text, CrackSealing sealing = CrackSealing::on) {
    const auto scene = load_scene(folder.write("s.toml", text), {.sealing = sealing});
    return scene ? scene->given_hash : 0;
  };
  const std::string plain = "[[object]]\nmesh = 'a.stl'\n";
  EXPECT_NE(hash_of(plain), 0U);
  EXPECT_EQ(hash_of(plain), hash_of(plain, CrackSealing::off));
  EXPECT_EQ(hash_of(plain), hash_of(plain + "material = 'm'\n[material.m]\nstiffness_n_per_m = 5\n"));
  for (const char* other :
       {"unit = 'mm'\n", "scale = 2.0\n", "position_m = [0, 0, 1]\n", "rotation_deg = [0, 0, 1]\n", "[[object]]\nmesh = 'b.obj'\n"}) {
    EXPECT_NE(hash_of(plain), hash_of(plain + other)) << other;
  }
  EXPECT_NE(hash_of(plain), hash_of("fit_m = [1, 1, 1]\n" + plain));
  const auto path = folder.path() / "a.stl";
  const auto touched_scene = load_scene(path, {.fit = MeshFit::workspace});
  const auto drawn_scene = load_scene(path, {.sealing = CrackSealing::off, .fit = MeshFit::workspace});
  const auto unfitted_scene = load_scene(path, {});
  ASSERT_TRUE(touched_scene && drawn_scene && unfitted_scene);
  EXPECT_EQ(touched_scene->given_hash, drawn_scene->given_hash);
  EXPECT_NE(touched_scene->given_hash, unfitted_scene->given_hash);
}

TEST(SceneAsGiven, NamesTheLineAtFault) {
  const ScratchFolder folder;
  folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto error_of = [&](const std::string& text) {
    const auto scene = load_scene(folder.write("s.toml", text));
    return scene ? "it was read" : scene.error().what;
  };
  EXPECT_THAT(error_of("[[object]]\nname = 'x'\n\nmesh = 'none.obj'\n"), HasSubstr("line 4: "));
  EXPECT_THAT(error_of("[[object]]\nmesh = 'a.obj'\nscale = 2\nmaterial = 'stel'\n[material.steel]\n"),
              HasSubstr("line 4: there is no [material.stel]"));
  EXPECT_THAT(error_of("[[object]]\nmesh = 'a.obj'\n\npart = 'wheel'\n"), HasSubstr("line 4: "));
  EXPECT_THAT(error_of("# one\n\n[object]\nmesh = 'a.obj'\n"), HasSubstr("line 3: 'object' must be"));
}

}  // namespace
}  // namespace hapton
