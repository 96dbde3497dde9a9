#include "link/key_role.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(KeyRoleTest, EveryRoleOfANodeIsFoundByItsByteAndItsName) {
  for (std::uint8_t byte = kFirstKeyRole; byte <= kLastKeyRole; ++byte) {
    const auto role = find_node_key_role(byte);
    ASSERT_TRUE(role);
    EXPECT_EQ(static_cast<std::uint8_t>(*role), byte);
    EXPECT_EQ(find_node_key_role(to_string(*role)), role);
  }
}

TEST(KeyRoleTest, NoNodeIsTheMasterOrUnsealed) {
  for (const int byte : {0, 1, 6, 255}) EXPECT_FALSE(find_node_key_role(static_cast<std::uint8_t>(byte))) << byte;
  for (const char* name : {"", "master", "unsealed", "io", "Vision", "vision "}) {
    EXPECT_FALSE(find_node_key_role(std::string_view(name))) << name;
  }
}

}  // namespace
}  // namespace hapton
