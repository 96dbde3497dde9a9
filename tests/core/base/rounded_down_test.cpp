#include "core/base/rounded_down.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

namespace hapton {
namespace {

TEST(RoundedDown, HasTwoDigitsAndIsNotMore) {
  const std::pair<double, const char*> rows[] = {{2.857, "2.8"}, {0.000875, "0.00087"}, {0.25, "0.25"},    {0.1, "0.1"},
                                                 {9.99, "9.9"},  {0.00095, "0.00095"},  {123.0, "1.2e+02"}};
  for (const auto& [number, text] : rows) {
    EXPECT_EQ(fmt::format("{:.2g}", rounded_down(number)), text);
    EXPECT_LE(std::stod(text), number);
  }
}

}  // namespace
}  // namespace hapton
