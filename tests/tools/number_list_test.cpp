#include "tools/number_list.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(NumberList, NumbersAndCommasAlone) {
  EXPECT_EQ(read_number_list("0.1,0,-5e-2"), (std::vector<double>{0.1, 0.0, -0.05}));
  EXPECT_EQ(read_number_list("7"), (std::vector<double>{7.0}));
  for (const char* none : {"", ",", "1,", ",1", "1 ,2", "1, 2", "1;2", "one", "1,,2"}) EXPECT_FALSE(read_number_list(none)) << none;
}

}  // namespace
}  // namespace hapton
