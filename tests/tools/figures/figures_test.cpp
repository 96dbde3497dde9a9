#include "tools/figures/figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

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

// Each step of the probe after the first is a line, which begins one offset above the collision point of the step before.
TEST_F(FiguresTest, TheSweepIsDrawnStepByStep) {
  const std::string script = script_of(figures_, "sweep");
  const auto rows_of = [&](const std::string& name) {
    const std::string head = "$" + name + " << EOD\n";
    std::vector<std::vector<double>> rows;
    const std::size_t begin = script.find(head);
    EXPECT_NE(begin, std::string::npos) << name;
    if (begin == std::string::npos) return rows;
    std::istringstream block(script.substr(begin + head.size(), script.find("\nEOD", begin) - begin - head.size()));
    for (std::string line; std::getline(block, line);) {
      std::istringstream words(line);
      rows.emplace_back(std::istream_iterator<double>(words), std::istream_iterator<double>());
    }
    return rows;
  };
  const auto devices = rows_of("devices"), lines = rows_of("lines"), collisions = rows_of("collisions"), forces = rows_of("forces");
  EXPECT_EQ(devices, (std::vector<std::vector<double>>{{-2.5, -1.6}, {0.0, -1.6}, {2.5, -1.6}, {5.0, -1.6}, {7.5, -1.6}}));
  ASSERT_EQ(lines.size(), devices.size());
  ASSERT_EQ(collisions.size(), devices.size());
  ASSERT_EQ(forces.size(), devices.size());
  for (std::size_t n = 0; n < devices.size(); ++n) {
    EXPECT_NEAR(lines[n][0] + lines[n][2], devices[n][0], 1e-4) << n;
    EXPECT_NEAR(lines[n][1] + lines[n][3], devices[n][1], 1e-4) << n;
    EXPECT_NEAR(collisions[n][1], 0.0, 1e-4) << n << ": on the surface";
    if (n > 0) {
      EXPECT_NEAR(lines[n][0], collisions[n - 1][0], 1e-4) << n;
      EXPECT_NEAR(lines[n][1], 0.8, 1e-4) << n;
    }
    EXPECT_NEAR(forces[n][2], 0.0, 1e-4) << n;
    EXPECT_GT(forces[n][3], 1.0) << n << ": out of the surface";
  }
}

// A ring of 30 mm with a tube of 9 mm, cut through the middle: lines of two points along an inner and an outer circle.
TEST_F(FiguresTest, TheCutOfTheRingIsTwoCircles) {
  const std::string script = script_of(figures_, "hulls");
  const std::size_t begin = script.find("$cut << EOD\n");
  ASSERT_NE(begin, std::string::npos);
  std::istringstream block(script.substr(begin, script.find("\nEOD", begin) - begin));
  std::string line;
  std::getline(block, line);
  int inner = 0;
  int outer = 0;
  while (std::getline(block, line)) {
    std::istringstream words(line);
    double x = 0.0;
    double y = 0.0;
    if (!(words >> x >> y)) continue;
    const double radius_mm = std::hypot(x, y);
    EXPECT_NEAR(std::min(std::abs(radius_mm - 21.0), std::abs(radius_mm - 39.0)), 0.0, 0.1) << line;
    (radius_mm < 30.0 ? inner : outer) += 1;
  }
  EXPECT_GE(inner, 2 * 96);
  EXPECT_EQ(inner, outer);
}

// The picture says what the sweep did: it passed a step lower than half a contact offset, and stopped at a higher one.
TEST_F(FiguresTest, ContactOffsetPassesLowStepsOnly) {
  const std::string script = script_of(figures_, "contact_offset");
  EXPECT_THAT(script, HasSubstr("step of 0.4:\\npassed within the slop"));
  EXPECT_THAT(script, HasSubstr("step of 0.7:\\nstops, then climbs"));
}

}  // namespace
}  // namespace hapton
