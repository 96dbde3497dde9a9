#include "plugin/plugin_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hapton {
namespace {

using ::testing::HasSubstr;
using ::testing::Pair;

TEST(PluginChoice, AFileAloneOrWithParameters) {
  EXPECT_EQ(parse_plugin_choice("a/b.so")->file, "a/b.so");
  EXPECT_TRUE(parse_plugin_choice("b.so")->parameters.empty());
  const auto two = parse_plugin_choice("b.so:range_m=0.02,name=x=y");
  ASSERT_TRUE(two);
  EXPECT_EQ(two->file, "b.so");
  EXPECT_THAT(two->parameters, testing::ElementsAre(Pair("range_m", "0.02"), Pair("name", "x=y")));
  EXPECT_EQ(two->to_text(), "b.so:range_m=0.02,name=x=y");
}

TEST(PluginChoice, APathMayHoldColonsAndAValueToo) {
  const auto odd = parse_plugin_choice("/x:y/b.so:port=host:80,empty=");
  ASSERT_TRUE(odd);
  EXPECT_EQ(odd->file, "/x:y/b.so");
  EXPECT_THAT(odd->parameters, testing::ElementsAre(Pair("port", "host:80"), Pair("empty", "")));
  EXPECT_EQ(parse_plugin_choice("/x:y/b")->file, "/x:y/b");
}

TEST(PluginChoice, WhatIsWrongIsNamed) {
  EXPECT_THAT(parse_plugin_choice("").error().what, HasSubstr("names no file"));
  EXPECT_THAT(parse_plugin_choice(":a=b").error().what, HasSubstr("names no file"));
  EXPECT_THAT(parse_plugin_choice("b.so:strong").error().what, HasSubstr("'strong' has no value"));
  EXPECT_THAT(parse_plugin_choice("b.so:a=1,strong").error().what, HasSubstr("'strong' is not a parameter"));
  EXPECT_THAT(parse_plugin_choice("b.so:a=1,").error().what, HasSubstr("is not a parameter"));
  EXPECT_THAT(parse_plugin_choice("b.so:a=1,a=2").error().what, HasSubstr("'a' is given twice"));
}

}  // namespace
}  // namespace hapton
