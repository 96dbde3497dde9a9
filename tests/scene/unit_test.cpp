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
    EXPECT_THAT(unit.error().what, ::testing::HasSubstr("say m, cm, mm or in"));
  }
}

}  // namespace
}  // namespace hapton
