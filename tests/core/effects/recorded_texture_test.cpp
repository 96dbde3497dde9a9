#include "core/effects/recorded_texture.h"

#include <gtest/gtest.h>

#include "tests/core/effects/made_textures.h"

namespace hapton {
namespace {

TEST(RecordedTexture, IsOnWithModelsAndBoundedByItsForce) {
  EXPECT_FALSE(RecordedTexture().is_on());
  const RecordedTexture texture = {.models = made::texture(1000.0, 8, 0), .max_force_n = 1.5};
  EXPECT_TRUE(texture.is_on());
  EXPECT_EQ(texture.bound_n(), 1.5);
  EXPECT_EQ(RecordedTexture::kPassivity, Passivity::active);
}

}  // namespace
}  // namespace hapton
