#include "link/shape_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace hapton {
namespace {

using Displacements = std::vector<ShapePart::Displacement>;

Displacements made_displacements(std::uint32_t total) {
  Displacements made(total);
  for (std::uint32_t v = 0; v < total; ++v) made[v] = {static_cast<float>(v), -1.0F, 0.5F};
  return made;
}

TEST(ShapeParts, AreWholeOnceAllHaveComeInAnyOrder) {
  for (const std::uint32_t total : {1U, 63U, 64U, 65U, 1000U, ShapePart::kMaxVertices}) {
    SCOPED_TRACE(testing::Message() << total << " vertices, seed 3");
    const Displacements sent = made_displacements(total);
    std::vector<std::uint32_t> firsts;
    for (std::uint32_t first = 0; first < total; first += ShapePart::kVerticesPerPart) firsts.push_back(first);
    std::shuffle(firsts.begin(), firsts.end(), std::mt19937_64(3));
    ShapeParts parts(total);
    EXPECT_TRUE(parts.is_empty());
    EXPECT_EQ(parts.first_missing(), 0U);
    for (const std::uint32_t first : firsts) {
      EXPECT_FALSE(parts.is_whole());
      EXPECT_TRUE(parts.add(make_shape_part(sent, first)));
      EXPECT_TRUE(parts.add(make_shape_part(sent, first))) << "twice changes nothing";
    }
    EXPECT_TRUE(parts.is_whole());
    EXPECT_EQ(parts.first_missing(), total);
    EXPECT_TRUE(std::equal(sent.begin(), sent.end(), parts.displacements_m().begin(), parts.displacements_m().end()));
    parts.clear();
    EXPECT_FALSE(parts.is_whole());
    EXPECT_TRUE(parts.is_empty());
  }
}

TEST(ShapeParts, NameTheFirstThatIsMissing) {
  const Displacements sent = made_displacements(300);
  ShapeParts parts(300);
  for (const std::uint32_t first : {0U, 64U, 192U, 256U}) parts.add(make_shape_part(sent, first));
  EXPECT_EQ(parts.first_missing(), 128U);
}

TEST(ShapeParts, OfAnotherMeshAreLeftOut) {
  ShapeParts parts(64);
  EXPECT_FALSE(parts.add(make_shape_part(made_displacements(65), 0)));
  EXPECT_FALSE(parts.add({.total = 64, .first = 64}));
  EXPECT_TRUE(parts.is_empty());
}

}  // namespace
}  // namespace hapton
