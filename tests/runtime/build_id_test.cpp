#include "runtime/build_id.h"

#include <gtest/gtest.h>

#include <cctype>

namespace hapton {
namespace {

TEST(BuildId, NamesVersionAndBuildInOneLine) {
  const std::string id = build_id();
  EXPECT_TRUE(std::isdigit(static_cast<unsigned char>(id.front()))) << id;
  EXPECT_EQ(id.find('\n'), std::string::npos);
  EXPECT_NE(id.find('+'), std::string::npos) << id;
}

}  // namespace
}  // namespace hapton
