#include "tools/demo/demo_step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "scene/find_scene.h"
#include "tools/demo/demo_run.h"

namespace hapton {
namespace {

TEST(DemoStep, SaysInALineOrTwoWhatToLookAt) {
  std::set<std::string> names;
  ASSERT_EQ(demo_steps().size(), 6U);
  for (std::size_t number = 1; number <= demo_steps().size(); ++number) {
    const DemoStep& step = demo_steps()[number - 1];
    EXPECT_FALSE(step.watch_for.empty());
    EXPECT_LE(std::count(step.watch_for.begin(), step.watch_for.end(), '\n'), 1) << step.name;
    EXPECT_TRUE(names.insert(demo_file_name(number)).second);
    EXPECT_EQ(demo_file_name(number).find(' '), std::string::npos);
    EXPECT_NE(step.make_path, nullptr);
    EXPECT_NE(step.evaluate, nullptr);
    // A mesh made for the step has no file.
    EXPECT_TRUE(step.scene.empty() || std::filesystem::exists(std::filesystem::path(HAPTON_SOURCE_DIR) / step.scene)) << step.scene;
  }
}

TEST(DemoStep, KeysAreNumbersNextAndQuit) {
  EXPECT_EQ(find_demo_request('q')->choice, DemoChoice::quit);
  for (const char next : {'n', ' ', '\n'}) EXPECT_EQ(find_demo_request(next)->choice, DemoChoice::next);
  for (char key = '1'; key <= '6'; ++key) {
    ASSERT_TRUE(find_demo_request(key)) << key;
    EXPECT_EQ(find_demo_request(key)->choice, DemoChoice::go_to);
    EXPECT_EQ(find_demo_request(key)->number, static_cast<std::size_t>(key - '0'));
  }
  for (const char other : {'0', '7', '9', 'x', '\t', '\xff'}) EXPECT_FALSE(find_demo_request(other)) << other;
}

}  // namespace
}  // namespace hapton
