#include "tools/figures/figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

namespace hapton {
namespace {

using ::testing::HasSubstr;

std::string script_of(const std::vector<Figure>& figures, const std::string& name) {
  for (const Figure& figure : figures) {
    if (figure.name == name) return figure.script;
  }
  return {};
}

class FiguresTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    auto made = make_figures();
    ASSERT_TRUE(made.has_value()) << made.error().what;
    figures_ = std::move(*made);
  }
  static std::vector<Figure> figures_;
};
std::vector<Figure> FiguresTest::figures_;

TEST_F(FiguresTest, EachDrawsAPictureOfItsName) {
  EXPECT_EQ(figures_.size(), 6U);
  for (const Figure& figure : figures_) {
    EXPECT_THAT(figure.script, HasSubstr("set output '" + figure.name + ".png.part'"));
    EXPECT_THAT(figure.script, HasSubstr("<< EOD"));
  }
}

TEST_F(FiguresTest, AreTheSameEveryTime) {
  const auto again = make_figures();
  ASSERT_TRUE(again.has_value());
  for (std::size_t i = 0; i < figures_.size(); ++i) EXPECT_EQ((*again)[i].script, figures_[i].script) << figures_[i].name;
}

TEST_F(FiguresTest, HullsWithMoreDirectionsCoverLess) {
  const std::string script = script_of(figures_, "hulls");
  std::smatch box, hull;
  ASSERT_TRUE(std::regex_search(script, box, std::regex("6 directions, ([0-9]+) mm")));
  ASSERT_TRUE(std::regex_search(script, hull, std::regex("14 directions, ([0-9]+) mm")));
  EXPECT_LT(std::stod(hull[1]), 0.9 * std::stod(box[1]));
}

// The picture says what the sweep did: under half a contact offset passed, above it not.
TEST_F(FiguresTest, ContactOffsetPassesLowStepsOnly) {
  const std::string script = script_of(figures_, "contact_offset");
  EXPECT_THAT(script, HasSubstr("step of 0.4:\\npassed within the slop"));
  EXPECT_THAT(script, HasSubstr("step of 0.7:\\nstops, then climbs"));
}

}  // namespace
}  // namespace hapton
