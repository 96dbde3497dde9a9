#include "vision_node/annotator_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

std::string error_text(const Result<void>& checked) { return checked ? "" : checked.error().what; }

TEST(AnnotatorOptions, BothFilesMustBeWritableAndNeitherIsNeeded) {
  const ScratchFolder folder;
  const std::string one = folder.write("one", "no folder").string();
  const std::string two = folder.write("two", "no folder").string();
  const auto check = [](const std::string& notes, const std::string& strokes) {
    AnnotatorOptions options;
    options.file = notes;
    options.strokes = strokes;
    return error_text(check_writable_files(options));
  };
  const std::string good = (folder.path() / "good").string();
  EXPECT_EQ(check("", ""), "");
  EXPECT_EQ(check(good, ""), "");
  EXPECT_EQ(check("", good), "");
  EXPECT_EQ(check(good, good), "");
  EXPECT_THAT(check(one + "/a.toml", ""), HasSubstr("one cannot be a folder"));
  EXPECT_THAT(check(one + "/a.toml", good), HasSubstr("one cannot be a folder"));
  EXPECT_THAT(check("", two + "/b.obj"), HasSubstr("two cannot be a folder"));
  EXPECT_THAT(check(good, two + "/b.obj"), HasSubstr("two cannot be a folder"));
}

TEST(AnnotatorOptions, NamesSayTheKindOfFile) {
  const auto check = [](const std::string& notes, const std::string& strokes) {
    AnnotatorOptions options;
    options.file = notes;
    options.strokes = strokes;
    return error_text(check_annotator_options(options));
  };
  EXPECT_EQ(check("", ""), "");
  EXPECT_EQ(check("a.toml", "b.obj"), "");
  EXPECT_EQ(check("a.toml", "b.vtp"), "");
  EXPECT_THAT(check("a.txt", ""), HasSubstr("--annotations a.txt"));
  EXPECT_THAT(check("", "b.stl"), HasSubstr("--strokes b.stl"));
  EXPECT_THAT(check("a.toml", "b.toml"), HasSubstr("--strokes b.toml"));
}

TEST(AnnotatorOptions, EachTwoButtonsDifferUnlessBothAreNone) {
  const auto check = [](int draw, int measure, int menu) {
    AnnotatorOptions options;
    options.draw_button = draw;
    options.measure_button = measure;
    options.menu_button = menu;
    return error_text(check_annotator_options(options));
  };
  EXPECT_EQ(check(1, 2, 3), "");
  EXPECT_EQ(check(0, 0, 0), "");
  EXPECT_EQ(check(0, 0, 1), "");
  EXPECT_THAT(check(1, 1, 2), HasSubstr("--draw-button and --measure-button are both 1"));
  EXPECT_THAT(check(2, 1, 2), HasSubstr("--draw-button and --menu-button are both 2"));
  EXPECT_THAT(check(1, 3, 3), HasSubstr("--measure-button and --menu-button are both 3"));
}

}  // namespace
}  // namespace hapton
