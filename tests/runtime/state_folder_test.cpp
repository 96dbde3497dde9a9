#include "runtime/state_folder.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <optional>
#include <string>

namespace hapton {
namespace {

// Unsets the five variables for each test, and restores them afterwards.
struct StateFolders : testing::Test {
  StateFolders() {
    for (const char* name : {"STATE_DIRECTORY", "XDG_STATE_HOME", "HOME", "RUNTIME_DIRECTORY", "XDG_RUNTIME_DIR"}) {
      const char* value = std::getenv(name);
      environment_before[name] = value != nullptr ? std::optional<std::string>(value) : std::nullopt;
      unsetenv(name);
    }
  }
  ~StateFolders() override {
    for (const auto& [name, value] : environment_before) value ? setenv(name.c_str(), value->c_str(), 1) : unsetenv(name.c_str());
  }
  std::map<std::string, std::optional<std::string>> environment_before;
};

TEST_F(StateFolders, FollowTheVariablesInTheirOrder) {
  EXPECT_EQ(find_state_folder(), "");
  setenv("HOME", "/home/ada", 1);
  EXPECT_EQ(find_state_folder(), "/home/ada/.local/state/hapton");
  setenv("XDG_STATE_HOME", "/x", 1);
  EXPECT_EQ(find_state_folder(), "/x/hapton");
  setenv("STATE_DIRECTORY", "/var/lib/hapton", 1);
  EXPECT_EQ(find_state_folder(), "/var/lib/hapton");
}

TEST_F(StateFolders, RuntimeFilesHaveAFolderOfTheirOwn) {
  EXPECT_EQ(find_runtime_folder(), "");
  setenv("XDG_RUNTIME_DIR", "/run/user/7", 1);
  EXPECT_EQ(find_runtime_folder(), "/run/user/7/hapton");
  setenv("RUNTIME_DIRECTORY", "/run/hapton", 1);
  EXPECT_EQ(find_runtime_folder(), "/run/hapton");
  setenv("RUNTIME_DIRECTORY", "run", 1);
  EXPECT_EQ(find_runtime_folder(), "/run/user/7/hapton");
}

TEST_F(StateFolders, RelativePathsArePassedOver) {
  setenv("XDG_STATE_HOME", "state", 1);
  EXPECT_EQ(find_state_folder(), "");
}

}  // namespace
}  // namespace hapton
