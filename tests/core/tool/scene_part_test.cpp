#include "core/tool/scene_part.h"

#include <gtest/gtest.h>

#include <random>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

class ScenePartTest : public testing::Test {
 protected:
  std::mt19937_64 random{3};
  std::normal_distribution<double> normal;
  const TriangleMesh ball = make_icosphere(0.3, 1);
  const TouchGeometry scene{std::vector<const TriangleMesh*>{&ball}};
  const ObjectGeometry tool{make_box({0.1, 0.2, 0.15}), {Vec3::Zero(), scene.unit_m()}};
  ScenePart static_part{
      tool, std::make_shared<const ToolSurface>(tool), scene, std::make_shared<const SceneSurface>(scene), {}, calling_thread()};
  ScenePart part{static_part, scene, std::make_shared<const SceneSurface>(scene), {{0.5, 0.25}}, calling_thread()};

  Vec3 draw() {
    const double x = normal(random);
    const double y = normal(random);
    return {x, y, normal(random)};
  }
  Placement draw_placement() { return {draw(), turn_by(draw())}; }
  static void expect_same(const Placement& a, const Placement& b) {
    EXPECT_LT((a.position - b.position).norm(), 1e-13);
    EXPECT_LT(turn_between(a.orientation, b.orientation).norm(), 1e-13);
  }
};

TEST_F(ScenePartTest, TheStaticPartHasTheFrameOfTheScene) {
  const RigidMotion motion{draw_placement(), draw(), draw()};
  EXPECT_EQ(static_part.in_part_frame(motion.from), motion.from);
  EXPECT_EQ(static_part.in_part_frame(motion).shift, motion.shift);
  EXPECT_TRUE(static_part.is_arrived());
  EXPECT_FALSE(static_part.moves());
}

TEST_F(ScenePartTest, APartThatRestsElsewhereSeesTheMotionTurned) {
  part.set_target(draw_placement());
  EXPECT_FALSE(part.is_arrived());
  part.put_at_target();
  EXPECT_TRUE(part.is_arrived());
  const RigidMotion motion{draw_placement(), draw(), 0.3 * draw()};
  const RigidMotion motion_in_part = part.in_part_frame(motion);
  for (const double time : {0.0, 0.3, 1.0}) expect_same(part.at() * motion_in_part.at(time), motion.at(time));
  const Vec3 p = draw();
  EXPECT_LT((part.point(part.at().inverse().at(p)) - p).norm(), 1e-14);
  EXPECT_LT((part.direction(motion_in_part.shift) - motion.shift).norm(), 1e-14);
}

TEST_F(ScenePartTest, WhereBothMoveItsFrameSeesAStraightMotionBetweenBothEnds) {
  part.set_target({0.1 * draw(), turn_by(0.1 * draw())});
  const Placement before = part.at();
  const Placement target = part.target();
  part.aim(1.0);
  ASSERT_TRUE(part.is_moving());
  const RigidMotion motion{draw_placement(), 0.1 * draw(), 0.1 * draw()};
  const RigidMotion motion_in_part = part.in_part_frame(motion);
  expect_same(before * motion_in_part.at(0.0), motion.from);
  expect_same(target * motion_in_part.at(1.0), motion.at(1.0));
  expect_same(part.end_in_part_frame(motion), motion_in_part.at(1.0));
  // After a share of the motion, the tool's placement in the frame of the part is that after the same share of the motion in that frame.
  part.advance(motion, 0.4, motion.at(0.4));
  EXPECT_FALSE(part.is_moving());
  EXPECT_FALSE(part.is_arrived());
  expect_same(part.in_part_frame(motion.at(0.4)), motion_in_part.at(0.4));
  part.aim(1.0);
  part.advance(RigidMotion{motion.at(0.4)}, 1.0, motion.at(0.4));
  EXPECT_EQ(part.at(), target) << "equal to the bit";
  EXPECT_TRUE(part.is_arrived());
}

TEST_F(ScenePartTest, AimsAtAShareOfItsWay) {
  part.set_target({{0.2, 0.0, 0.0}, turn_by({0.0, 0.0, 0.4})});
  part.aim(0.25);
  const RigidMotion still_tool{Placement{}};
  part.advance(still_tool, 1.0, still_tool.from);
  expect_same(part.at(), {{0.05, 0.0, 0.0}, turn_by({0.0, 0.0, 0.1})});
}

TEST_F(ScenePartTest, ACurvatureTurnsWithThePart) {
  part.set_target({draw(), turn_by(draw())});
  part.put_at_target();
  Mat6 curvature_in_part = Mat6::Random();
  curvature_in_part = (curvature_in_part + curvature_in_part.transpose()).eval();
  const Mat6 curvature_in_scene = part.curvature(curvature_in_part);
  const RigidMotion motion{draw_placement(), draw(), draw()};
  const auto quadratic_form = [](const Mat6& curvature, const RigidMotion& of) {
    Vec6 y;
    y << of.shift, of.turn;
    return y.dot(curvature * y);
  };
  EXPECT_NEAR(quadratic_form(curvature_in_scene, motion), quadratic_form(curvature_in_part, part.in_part_frame(motion)), 1e-11);
}

TEST_F(ScenePartTest, HasTheFrictionOfItsObjects) {
  EXPECT_EQ(part.friction_of(0).friction_static, 0.5);
  EXPECT_EQ(static_part.friction_of(0).friction_static, 0.0);
}

}  // namespace
}  // namespace hapton
