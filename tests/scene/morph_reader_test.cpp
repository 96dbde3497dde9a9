#include "scene/morph_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace hapton {
namespace {

using ::testing::HasSubstr;

Result<std::vector<MorphSpec>> read_morph_text(const std::string& text) {
  const toml::parse_result parsed = toml::parse(text);
  EXPECT_TRUE(parsed);
  return read_morphs(parsed.table(), "[[object]] 1");
}

std::string morph_error_of(const std::string& text) {
  const auto morphs = read_morph_text(text);
  return morphs ? "it was read" : morphs.error().what;
}

TEST(MorphReader, ReadsEveryKey) {
  const auto morphs = read_morph_text(R"(
[[morph]]
push_m = [0.001, 0, -0.002]
center_m = [1, 2, 3]
radius_m = 0.05
keys = [[0, 0.0], [0.5, 1], [2.0, -0.25]]
[[morph]]
stretch = [1.1, 0.9, 1]
keys = [[0.0, 0.0], [1.0, 1.0]]
)");
  ASSERT_TRUE(morphs) << morphs.error().what;
  ASSERT_EQ(morphs->size(), 2U);
  const MorphSpec& push = (*morphs)[0];
  EXPECT_EQ(push.push_m, Vec3(0.001, 0, -0.002));
  EXPECT_FALSE(push.stretch);
  EXPECT_EQ(push.centre_m, Vec3(1, 2, 3));
  EXPECT_EQ(push.radius_m, 0.05);
  EXPECT_EQ(push.line, 2U);
  ASSERT_EQ(push.keys.size(), 3U);
  EXPECT_EQ(push.keys[2].time_s, 2.0);
  EXPECT_EQ(push.keys[2].weight, -0.25);
  EXPECT_EQ((*morphs)[1].stretch, Vec3(1.1, 0.9, 1.0));
  EXPECT_FALSE((*morphs)[1].radius_m);
}

TEST(MorphReader, WithoutMorphsThereAreNone) {
  const auto morphs = read_morph_text("name = 'a'");
  ASSERT_TRUE(morphs);
  EXPECT_TRUE(morphs->empty());
}

TEST(MorphReader, SaysWhereAndWhatIsWrong) {
  const std::string push = "[[morph]]\npush_m = [0, 0, 1]\n";
  const std::string keys = "keys = [[0, 0], [1, 1]]\n";
  EXPECT_THAT(morph_error_of("[[morph]]\n" + keys), HasSubstr("neither 'push_m' nor 'stretch'"));
  EXPECT_THAT(morph_error_of(push + "stretch = [1, 1, 1]\n" + keys),
              HasSubstr("line 3: morph 1 of [[object]] 1 has 'push_m' and 'stretch'"));
  EXPECT_THAT(morph_error_of(push), HasSubstr("has no 'keys'"));
  EXPECT_THAT(morph_error_of(push + "radius_m = 0\n" + keys), HasSubstr("line 3: 'radius_m'"));
  EXPECT_THAT(morph_error_of(push + "centre_m = [0, 0, 0]\n" + keys), HasSubstr("did you mean 'center_m'"));
  for (const char* pairs :
       {"keys = 1", "keys = [[0, 0]]", "keys = [[0, 0], [1]]", "keys = [[0, 0], ['a', 1]]", "keys = [[0, 0], [1, true]]"}) {
    EXPECT_THAT(morph_error_of(push + pairs), HasSubstr("line 3: 'keys' in morph 1 of [[object]] 1 must be pairs")) << pairs;
  }
  EXPECT_THAT(morph_error_of(push + "keys = [[1, 0], [1, 1]]"), HasSubstr("must increase: 1 s comes after 1 s"));
  EXPECT_THAT(morph_error_of(push + "keys = [[0, 0], [1, 1], [0.5, 1]]"), HasSubstr("must increase: 0.5 s comes after 1 s"));
  EXPECT_THAT(morph_error_of(push + "keys = [[-1, 0], [1, 1]]"), HasSubstr("is -1 s: give 0 to 86400"));
  EXPECT_THAT(morph_error_of(push + "keys = [[0, 0], [1, nan]]"), HasSubstr("a weight in 'keys'"));
  EXPECT_THAT(morph_error_of("morph = 3"), HasSubstr("must be tables that begin with [[object.morph]]"));
  std::string many;
  for (int i = 0; i < 17; ++i) many += push + keys;
  EXPECT_THAT(morph_error_of(many), HasSubstr("has 17 morphs: at most 16"));
}

}  // namespace
}  // namespace hapton
