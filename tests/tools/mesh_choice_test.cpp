#include "tools/mesh_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/geometry/mesh_measures.h"

namespace hapton {
namespace {

TEST(MeshChoice, ScalesAShapeByItsLongestSide) {
  const auto mesh = make_mesh({.file = {}, .unit = {}, .shape = "torus", .scale_to_m = 2.0});
  ASSERT_TRUE(mesh.has_value());
  EXPECT_NEAR(compute_bounds(*mesh).extent(), 2.0, 1e-12);
}

TEST(MeshChoice, NamesTheShapesThereAre) {
  const auto mesh = make_mesh({.file = {}, .unit = {}, .shape = "teapot"});
  ASSERT_FALSE(mesh.has_value());
  EXPECT_THAT(mesh.error().what, ::testing::HasSubstr("gutter"));
}

TEST(MeshChoice, IsNamedAfterTheFile) {
  EXPECT_EQ(name_of({.file = "a/b/bunny.ply", .unit = {}, .shape = {}}), "bunny");
  EXPECT_EQ(name_of({.file = {}, .unit = {}, .shape = "pit"}), "pit");
}

}  // namespace
}  // namespace hapton
