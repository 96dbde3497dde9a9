#include "tools/session/csv_names.h"

#include <gtest/gtest.h>

#include <vector>

namespace hapton {
namespace {

// The object and its material.
TEST(CsvNames, AlwaysGiveTwoFields) {
  const std::vector<ObjectName> names = {{"hood", "sheet metal"}, {"a, \"b\"", ""}};
  EXPECT_EQ(csv_names(names, 0), "hood,sheet metal");
  EXPECT_EQ(csv_names(names, 1), "\"a, \"\"b\"\"\",");
  EXPECT_EQ(csv_names(names, 2), ",");
  EXPECT_EQ(csv_names(names, -1), ",");
  EXPECT_EQ(csv_names({}, 0), ",");
}

// A line end becomes a question mark.
TEST(CsvNames, LongNamesAreNotTruncated) {
  const std::string name(100, 'n');
  const std::vector<ObjectName> names = {{name, name + "\n"}};
  EXPECT_EQ(csv_names(names, 0), name + "," + name + "?");
}

TEST(CsvNames, ACellHoldsAnyText) {
  EXPECT_EQ(csv_cell("trial 1"), "trial 1");
  EXPECT_EQ(csv_cell("a, \"b\""), "\"a, \"\"b\"\"\"");
  EXPECT_EQ(csv_cell(""), "");
}

}  // namespace
}  // namespace hapton
