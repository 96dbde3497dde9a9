#include "vision_node/renderer_limits.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(RendererLimits, AreThoseOfTheRenderer) {
  const RendererLimits card{.renderer = "NVIDIA GeForce", .largest = {16384, 8192}};
  EXPECT_TRUE(card.check({16384, 8192}));
  const auto high = card.check({64, 8193});
  ASSERT_FALSE(high);
  EXPECT_EQ(high.error().what, "--size 64x8193: NVIDIA GeForce draws pictures of at most 16384x8192 pixels");
  EXPECT_FALSE(card.check({16385, 64}));
}

TEST(RendererLimits, AreTighterWhereTheProcessorDraws) {
  const RendererLimits limits{.renderer = "llvmpipe (LLVM 15.0.6, 256 bits)", .largest = {16384, 16384}};
  EXPECT_TRUE(limits.check({7680, 4320}));
  EXPECT_TRUE(limits.check({16384, 2025}));
  const auto large = limits.check({16384, 16384});
  ASSERT_FALSE(large);
  EXPECT_EQ(
      large.error().what,
      "--size 16384x16384: llvmpipe (LLVM 15.0.6, 256 bits) draws with the processor, at most 33 million pixels, such as 7680x4320 or "
      "5760x5760; this is 268");
}

TEST(RendererLimits, KnowRenderersThatUseTheProcessor) {
  EXPECT_TRUE(is_software_renderer("llvmpipe (LLVM 15.0.6, 256 bits)"));
  EXPECT_TRUE(is_software_renderer("softpipe"));
  EXPECT_FALSE(is_software_renderer("NVIDIA GeForce"));
}

}  // namespace
}  // namespace hapton
