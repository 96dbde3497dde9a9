#include "core/sculpt/sculpture.h"

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

constexpr SculptSettings kSculpted{.voxel_m = 0.002, .tool_radius_m = 0.005, .button = 1};

TEST(Sculpture, NumbersTheCarvesOfAllBodiesAndHasTheOneOfTheStep) {
  Sculpture sculpture;
  ASSERT_TRUE(sculpture.add(3, kSculpted, make_icosphere(0.02, 3)));
  ASSERT_TRUE(sculpture.add(7, kSculpted, make_box(Vec3::Constant(0.02))));
  EXPECT_FALSE(sculpture.made());
  const Carve carve{{0.02, 0.0, 0.0}, {0.021, 0.0001, 0.0}, 0.005};
  sculpture.carve(0, carve);
  ASSERT_TRUE(sculpture.made());
  EXPECT_EQ(sculpture.made()->object, 3);
  EXPECT_EQ(sculpture.made()->serial, 1U);
  EXPECT_EQ(sculpture.made()->carve, rounded(carve));
  sculpture.begin_step();
  EXPECT_FALSE(sculpture.made());
  // What is no more there is not carved.
  sculpture.carve(0, carve);
  sculpture.carve(1, {{0.1, 0.0, 0.0}, {0.1, 0.0, 0.0}, 0.005});
  EXPECT_FALSE(sculpture.made());
  sculpture.carve(1, {{0.01, 0.0, 0.0}, {0.01, 0.0, 0.0}, 0.005});
  ASSERT_TRUE(sculpture.made());
  EXPECT_EQ(sculpture.made()->object, 7);
  EXPECT_EQ(sculpture.newest(), 2U);
}

TEST(Sculpture, IsAlikeWhatWasTheSameBeforeAnyCarve) {
  Sculpture one, same, other_mesh, other_settings, other_object;
  const TriangleMesh ball = make_icosphere(0.02, 3);
  ASSERT_TRUE(one.add(0, kSculpted, ball) && same.add(0, kSculpted, ball) && other_object.add(1, kSculpted, ball));
  ASSERT_TRUE(other_mesh.add(0, kSculpted, make_icosphere(0.02, 2)));
  ASSERT_TRUE(other_settings.add(0, {.voxel_m = 0.002, .tool_radius_m = 0.006, .button = 1}, ball));
  one.carve(0, {{0.02, 0.0, 0.0}, {0.02, 0.0, 0.0}, 0.005});
  EXPECT_TRUE(one.is_alike(same));
  EXPECT_FALSE(one.is_alike(other_mesh));
  EXPECT_FALSE(one.is_alike(other_settings));
  EXPECT_FALSE(one.is_alike(other_object));
  EXPECT_FALSE(one.is_alike(Sculpture()));
  Sculpture other_place, other_button, more;
  ASSERT_TRUE(other_place.add(0, kSculpted, scaled_and_moved(ball, 1.0, Vec3(0.002, 0.0, 0.0))));  // by one voxel: the same values
  ASSERT_TRUE(other_button.add(0, {.voxel_m = 0.002, .tool_radius_m = 0.005, .button = 2}, ball));
  ASSERT_TRUE(more.add(0, kSculpted, ball) && more.add(1, kSculpted, ball));
  for (const Sculpture* other : {&other_place, &other_button, &more}) {
    EXPECT_FALSE(one.is_alike(*other));
    EXPECT_FALSE(other->is_alike(one));
  }
  EXPECT_FALSE(one.add(1, kSculpted, make_plane_grid(0.1, 2)));
}

}  // namespace
}  // namespace hapton
