#include "scene/unit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(Unit, IsReadByItsNameOnly) {
  for (const Unit unit : {Unit::m, Unit::cm, Unit::mm, Unit::in}) EXPECT_EQ(parse_unit(name_of(unit)).value(), unit);
  EXPECT_EQ(metres_per(Unit::in), 0.0254);
  for (const char* wrong : {"", "M", "inch", "ft", "mm "}) {
    const auto unit = parse_unit(wrong);
    ASSERT_FALSE(unit) << wrong;
    EXPECT_THAT(unit.error().what, ::testing::HasSubstr("give m, cm, mm or in"));
  }
}

TEST(Unit, ALengthIsANumberAndItsUnit) {
  EXPECT_DOUBLE_EQ(parse_length("0.1mm").value(), 1e-4);
  EXPECT_DOUBLE_EQ(parse_length("5 cm").value(), 0.05);
  EXPECT_DOUBLE_EQ(parse_length("2in").value(), 0.0508);
  EXPECT_EQ(parse_length("1e-4").value(), 1e-4);
  EXPECT_EQ(parse_length("0").value(), 0.0);
  for (const char* wrong : {"", "mm", "1 ", "1  mm", "1ft", "-1mm", "nan", "inf", "1e999", "1mm2", " 1mm"}) {
    const auto length = parse_length(wrong);
    ASSERT_FALSE(length) << wrong;
    EXPECT_THAT(length.error().what, ::testing::HasSubstr("is not a length"));
  }
}

}  // namespace
}  // namespace hapton
