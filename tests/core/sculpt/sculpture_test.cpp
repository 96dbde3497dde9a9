#include "core/sculpt/sculpture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

constexpr SculptSettings kSculptSettings{.voxel_m = 0.002, .tool_radius_m = 0.005, .button = 1};

TEST(Sculpture, NumbersTheCarvesOfAllBodiesAndHasTheOneOfTheStep) {
  Sculpture sculpture;
  ASSERT_TRUE(sculpture.add(3, kSculptSettings, make_icosphere(0.02, 3)));
  ASSERT_TRUE(sculpture.add(7, kSculptSettings, make_box(Vec3::Constant(0.02))));
  EXPECT_FALSE(sculpture.made());
  const Carve carve{{0.02, 0.0, 0.0}, {0.021, 0.0001, 0.0}, 0.005};
  sculpture.carve(0, carve);
  ASSERT_TRUE(sculpture.made());
  EXPECT_EQ(sculpture.made()->object, 3);
  EXPECT_EQ(sculpture.made()->serial, 1U);
  EXPECT_EQ(sculpture.made()->carve, rounded(carve));
  sculpture.begin_step();
  EXPECT_FALSE(sculpture.made());
  // Where no material is left, nothing is carved.
  sculpture.carve(0, carve);
  sculpture.carve(1, {{0.1, 0.0, 0.0}, {0.1, 0.0, 0.0}, 0.005});
  EXPECT_FALSE(sculpture.made());
  sculpture.carve(1, {{0.01, 0.0, 0.0}, {0.01, 0.0, 0.0}, 0.005});
  ASSERT_TRUE(sculpture.made());
  EXPECT_EQ(sculpture.made()->object, 7);
  EXPECT_EQ(sculpture.newest(), 2U);
}

TEST(Sculpture, IsAlikeWhatWasTheSameBeforeAnyCarve) {
  Sculpture sculpture, same, other_mesh, other_settings, other_object;
  const TriangleMesh ball = make_icosphere(0.02, 3);
  ASSERT_TRUE(sculpture.add(0, kSculptSettings, ball) && same.add(0, kSculptSettings, ball) && other_object.add(1, kSculptSettings, ball));
  ASSERT_TRUE(other_mesh.add(0, kSculptSettings, make_icosphere(0.02, 2)));
  ASSERT_TRUE(other_settings.add(0, {.voxel_m = 0.002, .tool_radius_m = 0.006, .button = 1}, ball));
  sculpture.carve(0, {{0.02, 0.0, 0.0}, {0.02, 0.0, 0.0}, 0.005});
  EXPECT_TRUE(sculpture.is_alike(same));
  EXPECT_FALSE(sculpture.is_alike(other_mesh));
  EXPECT_FALSE(sculpture.is_alike(other_settings));
  EXPECT_FALSE(sculpture.is_alike(other_object));
  EXPECT_FALSE(sculpture.is_alike(Sculpture()));
  Sculpture other_place, other_button, two_bodies;
  ASSERT_TRUE(other_place.add(0, kSculptSettings, scaled_and_moved(ball, 1.0, Vec3(0.002, 0.0, 0.0))));  // by one voxel: same field values
  ASSERT_TRUE(other_button.add(0, {.voxel_m = 0.002, .tool_radius_m = 0.005, .button = 2}, ball));
  ASSERT_TRUE(two_bodies.add(0, kSculptSettings, ball) && two_bodies.add(1, kSculptSettings, ball));
  for (const Sculpture* other : {&other_place, &other_button, &two_bodies}) {
    EXPECT_FALSE(sculpture.is_alike(*other));
    EXPECT_FALSE(other->is_alike(sculpture));
  }
  EXPECT_FALSE(sculpture.add(1, kSculptSettings, make_plane_grid(0.1, 2)));
}

// The other shapes come from an undo; the next carve has the number after that of the undo, and the step has no carve of its own.
TEST(Sculpture, GoesOnWithTheShapesOfAnother) {
  const TriangleMesh ball = make_icosphere(0.02, 3);
  const Carve carve{{0.02, 0.0, 0.0}, {0.02, 0.0, 0.0}, 0.005};
  Sculpture sculpture, undone_sculpture;
  ASSERT_TRUE(sculpture.add(0, kSculptSettings, ball) && undone_sculpture.add(0, kSculptSettings, ball));
  sculpture.carve(0, carve);
  ASSERT_TRUE(sculpture.made());
  undone_sculpture.field(0).carve({{-0.02, 0.0, 0.0}, {-0.02, 0.0, 0.0}, 0.005});
  sculpture.exchange_shapes(undone_sculpture, 2);
  EXPECT_EQ(sculpture.newest(), 2U);
  EXPECT_FALSE(sculpture.made());
  EXPECT_FALSE(undone_sculpture.bodies()[0].field.would_change(carve)) << "it has the shape that the other had before";
  EXPECT_FALSE(sculpture.bodies()[0].field.would_change({{-0.02, 0.0, 0.0}, {-0.02, 0.0, 0.0}, 0.005}));
  sculpture.carve(0, carve);
  ASSERT_TRUE(sculpture.made()) << "the material is there again";
  EXPECT_EQ(sculpture.made()->serial, 3U);
  sculpture.exchange_shapes(undone_sculpture, Sculpture::kMaxCarves - 1);
  EXPECT_FALSE(sculpture.is_full());
  sculpture.exchange_shapes(undone_sculpture, Sculpture::kMaxCarves);
  EXPECT_TRUE(sculpture.is_full());
}

// The first carve, and the first one after a carving button went down, begin a press; carves while it is held and other buttons do not.
TEST(Sculpture, APressBeginsWithTheButton) {
  Sculpture sculpture;
  ASSERT_TRUE(sculpture.add(0, kSculptSettings, make_icosphere(0.02, 3)));
  double angle = 0.0;
  const auto begins = [&](std::uint32_t buttons) {
    sculpture.begin_step();
    sculpture.note_buttons(buttons, 0b101);
    const Vec3 at(0.02 * std::cos(angle), 0.02 * std::sin(angle), 0.0);
    angle += 0.3;
    sculpture.carve(0, {at, at, 0.005});
    return sculpture.made() && sculpture.made()->begins;
  };
  EXPECT_TRUE(begins(0b001));
  EXPECT_FALSE(begins(0b001));
  EXPECT_FALSE(begins(0b011)) << "the other button does not carve";
  EXPECT_FALSE(begins(0b000));
  EXPECT_TRUE(begins(0b001));
  EXPECT_TRUE(begins(0b101)) << "a second one";
  sculpture.begin_step();
  sculpture.note_buttons(0b000, 0b101);
  sculpture.note_buttons(0b100, 0b101);
  EXPECT_TRUE(begins(0b100)) << "pressed in a step that carved nothing";
}

}  // namespace
}  // namespace hapton
