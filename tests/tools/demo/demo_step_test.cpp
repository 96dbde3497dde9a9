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

// A person can then compare these steps, and the hand does not leave while the node that died is started again.
TEST(DemoStep, TheStepsOnTheCarPressTheSamePlaceAndTheLastOneStaysThere) {
  const auto scene = load_scene(std::filesystem::path(HAPTON_SOURCE_DIR) / "scenes/car_front.toml");
  ASSERT_TRUE(scene) << scene.error().what;
  std::vector<DemoPath> paths;
  for (const std::size_t number : {1U, 5U, 6U}) {
    ASSERT_EQ(demo_steps()[number - 1].scene, "scenes/car_front.toml");
    const auto path = demo_steps()[number - 1].make_path(*scene);
    ASSERT_TRUE(path) << path.error().what;
    paths.push_back(*path);
    EXPECT_EQ(path->front().p_WD, paths.front().front().p_WD) << number;
  }
  EXPECT_LT(paths[0].back().t_s, 15.0) << "it is repeated";
  EXPECT_LT(paths[1].back().t_s, 15.0);
  EXPECT_GT(paths[2].back().t_s, 60.0);
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
