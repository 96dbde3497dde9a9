#include "haptics_node/inside_body_warning.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "core/geometry/mesh_shapes.h"
#include "runtime/log.h"
#include "tests/support/made_meshes.h"
#include "tests/support/made_scene.h"
#include "tests/support/patience.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

TriangleMesh turned_inside_out(TriangleMesh mesh) {
  for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  return mesh;
}

TEST(FindEnclosure, IsWithinFacesThatPointOutwards) {
  const TouchScene scene = scene_of(made::sphere(0.05, 30));
  EXPECT_TRUE(find_enclosure(scene, Vec3::Zero()).is_inside);
  EXPECT_TRUE(find_enclosure(scene, Vec3(0, 0, 0.049)).is_inside);
  EXPECT_FALSE(find_enclosure(scene, Vec3(0, 0, 0.051)).is_inside);
  EXPECT_FALSE(find_enclosure(scene, Vec3(0.045, 0.045, 0.045)).is_inside) << "within its bounding box, but outside of it";
  EXPECT_FALSE(find_enclosure({}, Vec3::Zero()).is_inside);
  TouchScene commanded = scene;
  commanded.objects[0].command_pivot = Vec3::Zero();
  EXPECT_FALSE(find_enclosure(commanded, Vec3::Zero()).is_inside) << "it may be elsewhere";
}

TEST(FindEnclosure, IgnoresRoomsAndOpenShells) {
  EXPECT_FALSE(find_enclosure(scene_of(turned_inside_out(made::sphere(0.05, 30))), Vec3::Zero()).is_inside);
  TriangleMesh shell = made::sphere(0.05, 30);
  shell.triangles.resize(shell.triangles.size() * 3 / 4);
  EXPECT_FALSE(find_enclosure(scene_of(std::move(shell)), Vec3::Zero()).is_inside);
  TriangleMesh scanned = made::sphere(0.05, 30);
  scanned.triangles.pop_back();
  EXPECT_TRUE(find_enclosure(scene_of(std::move(scanned)), Vec3::Zero()).is_inside) << "a small hole";
}

TEST(FindEnclosure, LooksAtEachBodyByItself) {
  TouchScene scene = scene_of(made::box(Vec3::Constant(0.1), Vec3::Constant(0.2)));
  scene.objects.push_back({made::shared(made::sphere(0.05, 30)), {.two_sided = false}});
  const Enclosure first = find_enclosure(scene, Vec3::Constant(0.15));
  EXPECT_TRUE(first.is_inside && first.two_sided);
  const Enclosure second = find_enclosure(scene, Vec3(0.01, 0, 0));
  EXPECT_TRUE(second.is_inside && !second.two_sided);
}

TEST(FindEnclosure, OfBodiesInOneAnotherOneThatIsFeltFromWithinDecides) {
  TouchScene scene = scene_of(made::sphere(0.05, 30), {.two_sided = false});
  scene.objects.push_back({made::shared(made::sphere(0.03, 30)), {.two_sided = true}});
  EXPECT_TRUE(find_enclosure(scene, Vec3::Zero()).two_sided);
  EXPECT_FALSE(find_enclosure(scene, Vec3(0.04, 0, 0)).two_sided);
}

struct InsideBodyWarningTest : testing::Test {
  static void SetUpTestSuite() { start_log("haptics_node"); }
  // Long enough for several checks.
  static void pause() { std::this_thread::sleep_for(std::chrono::milliseconds(600)); }

  TouchScene ball(bool two_sided) { return scene_of(made::sphere(0.05, 30), {.two_sided = two_sided}); }
};

TEST_F(InsideBodyWarningTest, WarnsOnceOfAHandInsideAndSaysWhenItIsOut) {
  testing::internal::CaptureStderr();
  {
    InsideBodyWarning warning(ball(false));
    EXPECT_FALSE(warning.is_watching());
    warning.note_start(Vec3(0.01, 0, 0));
    EXPECT_TRUE(warning.is_watching());
    ASSERT_TRUE(wait_until([&] { return warning.is_inside(); }));
    warning.note_hand(Vec3(0.02, 0, 0), false);
    pause();
    EXPECT_TRUE(warning.is_inside() && warning.is_watching());
    warning.note_hand(Vec3(0.06, 0, 0), false);
    ASSERT_TRUE(wait_until([&] { return !warning.is_inside(); }));
    EXPECT_FALSE(warning.is_watching());
  }
  const std::string log = testing::internal::GetCapturedStderr();
  const std::string warning = "that body gives no force until the stylus has left it";
  EXPECT_THAT(log, HasSubstr(warning));
  EXPECT_EQ(log.find(warning), log.rfind(warning)) << "once";
  EXPECT_THAT(log, HasSubstr("the stylus is outside now"));
}

TEST_F(InsideBodyWarningTest, AHandThatIsHeldFromWithinIsStillInside) {
  testing::internal::CaptureStderr();
  {
    InsideBodyWarning warning(ball(true));
    warning.note_start(Vec3::Zero());
    ASSERT_TRUE(wait_until([&] { return warning.is_inside(); }));
    warning.note_hand(Vec3(0.055, 0, 0), true);
    pause();
    EXPECT_TRUE(warning.is_inside());
    warning.note_start(Vec3(0.055, 0, 0));
    EXPECT_TRUE(wait_until([&] { return !warning.is_inside(); })) << "contact began anew, outside";
  }
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("end haptics_node, lead the stylus out, and start it again"));
}

TEST_F(InsideBodyWarningTest, NoWarningAfterAStartOutside) {
  testing::internal::CaptureStderr();
  {
    InsideBodyWarning warning(ball(true));
    warning.note_start(Vec3(0.051, 0, 0));
    warning.note_hand(Vec3(0.049, 0, 0), true);  // before the first check
    ASSERT_TRUE(wait_until([&] { return !warning.is_watching(); }));
    EXPECT_FALSE(warning.is_inside());
    warning.note_hand(Vec3(0.03, 0, 0), true);
    pause();
    EXPECT_FALSE(warning.is_inside());
    warning.set_scene({});
    warning.note_start(Vec3::Zero());
    ASSERT_TRUE(wait_until([&] { return !warning.is_watching(); }));
    EXPECT_FALSE(warning.is_inside()) << "another scene";
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace hapton
