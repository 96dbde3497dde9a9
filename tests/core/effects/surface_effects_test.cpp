#include "core/effects/surface_effects.h"

#include <gtest/gtest.h>

#include "tests/core/effects/made_textures.h"

namespace hapton {
namespace {

TEST(SurfaceEffects, AreOffByDefault) {
  EXPECT_FALSE(SurfaceEffects().any());
  SurfaceEffects effects;
  effects.layers.add({});
  EXPECT_TRUE(effects.any());
  EXPECT_TRUE(SurfaceEffects{.progressive = {.n_per_m2 = 1}}.any());
  EXPECT_TRUE(SurfaceEffects{.bumps = {.height_m = 1e-3}}.any());
  EXPECT_TRUE(SurfaceEffects{.viscosity = {.damping_ns_per_m = 1}}.any());
  EXPECT_TRUE(SurfaceEffects{.snap = {.range_m = 1e-3}}.any());
  EXPECT_TRUE(SurfaceEffects{.tap = {.ns_per_m = 1}}.any());
  EXPECT_TRUE(SurfaceEffects{.texture = {.models = made::texture(1000.0, 8, 0)}}.any());
}

}  // namespace
}  // namespace hapton
