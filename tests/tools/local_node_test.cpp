#include "tools/local_node.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

LocalNode shell(const ScratchFolder& scratch, const std::string& script) {
  auto node = LocalNode::start(scratch.path(), "sh", "sh", {"-c", script});
  EXPECT_TRUE(node) << node.error().what;
  return std::move(*node);
}

TEST(LocalNode, WaitsForANumberAmidWhatElseIsSaid) {
  const ScratchFolder scratch;
  LocalNode node = shell(scratch, "echo 3 servers are running; printf 4; sleep 0.2; echo 7; echo warning: none; sleep 5");
  const auto number = node.wait_for_number();
  ASSERT_TRUE(number) << number.error().what;
  EXPECT_EQ(*number, "47") << "of the whole line";
}

TEST(LocalNode, ThatEndsWithoutTheNumberSaysSo) {
  const ScratchFolder scratch;
  LocalNode node = shell(scratch, "echo no display; exit 3");
  const auto number = node.wait_for_number();
  ASSERT_FALSE(number);
  EXPECT_THAT(number.error().what, HasSubstr("sh ended with 3: no display"));
}

TEST(LocalNode, IsKilledAsByACrash) {
  const ScratchFolder scratch;
  LocalNode node = shell(scratch, "trap '' TERM; echo ready; sleep 60");
  ASSERT_TRUE(node.wait_for("ready"));
  EXPECT_TRUE(node.check_running());
  node.kill();
  EXPECT_THAT(node.check_running().error().what, HasSubstr("137"));
}

}  // namespace
}  // namespace hapton
