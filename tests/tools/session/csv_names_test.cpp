#include "tools/session/csv_names.h"

#include <gtest/gtest.h>

#include <vector>

namespace hapton {
namespace {

TEST(CsvNames, AreTwoFieldsWhateverIsInThem) {
  const std::vector<ObjectName> names = {{"hood", "sheet metal"}, {"a, \"b\"", ""}};
  EXPECT_EQ(csv_names(names, 0), "hood,sheet metal");
  EXPECT_EQ(csv_names(names, 1), "\"a, \"\"b\"\"\",");
  EXPECT_EQ(csv_names(names, 2), ",");
  EXPECT_EQ(csv_names(names, -1), ",");
  EXPECT_EQ(csv_names({}, 0), ",");
}

}  // namespace
}  // namespace hapton
