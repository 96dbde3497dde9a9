#include "tools/local_node.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <string>

#include "runtime/clock.h"

#include "tests/support/patience.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

LocalNode start_shell(const ScratchFolder& scratch, const std::string& script) {
  auto node = LocalNode::start(scratch.path(), "sh", "sh", {"-c", script});
  EXPECT_TRUE(node) << node.error().what;
  return std::move(*node);
}

TEST(LocalNode, WaitsForANumberAmidOtherOutput) {
  const ScratchFolder scratch;
  LocalNode node = start_shell(scratch, "echo 3 servers are running; printf 4; sleep 0.2; echo 7; echo warning: none; sleep 5");
  const auto number = node.wait_for_number();
  ASSERT_TRUE(number) << number.error().what;
  EXPECT_EQ(*number, "47") << "the whole line is read";
}

TEST(LocalNode, ThatEndsWithoutTheNumberSaysSo) {
  const ScratchFolder scratch;
  LocalNode node = start_shell(scratch, "echo no display; exit 3");
  const auto number = node.wait_for_number();
  ASSERT_FALSE(number);
  EXPECT_THAT(number.error().what, HasSubstr("sh ended with 3: no display"));
}

TEST(LocalNode, IsKilledAsByACrash) {
  const ScratchFolder scratch;
  LocalNode node = start_shell(scratch, "trap '' TERM; echo ready; sleep 60");
  ASSERT_TRUE(node.wait_for("ready"));
  EXPECT_TRUE(node.check_running());
  node.kill();
  EXPECT_THAT(node.check_running().error().what, HasSubstr("137"));
}

// Gone, or ended and not yet collected by its parent.
bool has_ended(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string number;
  std::string name;
  char state = 'Z';
  file >> number >> name >> state;
  return state == 'Z' || state == 'X';
}

TEST(LocalNode, EndsWithAProgramThatIsKilled) {
  const ScratchFolder scratch;
  const pid_t program = ::fork();
  ASSERT_GE(program, 0);
  if (program == 0) {
    auto node = LocalNode::start(scratch.path(), "node", "/bin/sh", {"-c", "echo $$; exec sleep 60"});
    if (node && node->wait_for_number()) ::kill(::getpid(), SIGKILL);
    ::_exit(1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(program, &status, 0), program);
  ASSERT_TRUE(WIFSIGNALED(status)) << "the node was not started";
  const pid_t node = std::stoi(read_text(scratch.path() / "node.log"));
  EXPECT_TRUE(wait_until([&] { return has_ended(node); }));
}

}  // namespace
}  // namespace hapton
