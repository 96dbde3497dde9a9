#include "vision_node/scene_reload.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

#include "tests/support/log_of.h"
#include "tests/support/patience.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using testing::HasSubstr;

struct SceneReloadTest : testing::Test {
  SceneReloadTest() {
    folder.write("a.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n");
    write("color = [1, 0, 0]");
  }
  void write(const std::string& keys) {
    folder.write("a.toml", "[[object]]\nmesh = 'a.obj'\n" + keys + "\n");
    // Two writes within the clock's step of a file system would look like one.
    std::filesystem::last_write_time(file, std::filesystem::file_time_type::clock::now() + std::chrono::seconds(++writes));
  }
  static std::string log_of_two_looks(SceneReload& reload) {
    return log_of([&] {
      reload.look();
      reload.look();
    });
  }

  ScratchFolder folder;
  std::filesystem::path file = folder.path() / "a.toml";
  int writes = 0;
};

TEST_F(SceneReloadTest, ASavedFileIsReadOnce) {
  SceneReload reload(file, {});
  EXPECT_EQ(log_of_two_looks(reload), "");
  EXPECT_FALSE(reload.take());
  write("color = [0, 1, 0]");
  EXPECT_EQ(log_of_two_looks(reload), "");
  const auto scene = reload.take();
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->objects.at(0).colour, (std::array<double, 3>{0, 1, 0}));
  EXPECT_FALSE(reload.take());
}

// The picture warns of another scene only after that.
TEST_F(SceneReloadTest, IsReadingFromTheFirstLookThatSeesTheChangeOn) {
  SceneReload reload(file, {});
  reload.look();
  EXPECT_FALSE(reload.is_reading());
  for (const char* keys : {"color = [0, 1, 0]", "colr = [0, 1, 0]"}) {
    write(keys);
    (void)log_of([&] { reload.look(); });
    EXPECT_TRUE(reload.is_reading()) << keys;
    (void)log_of([&] { reload.look(); });
    EXPECT_FALSE(reload.is_reading()) << keys;
  }
  write("color = [0, 0, 1]");
  reload.look();
  std::filesystem::remove(file);
  (void)log_of_two_looks(reload);
  EXPECT_FALSE(reload.is_reading()) << "it is gone";
}

TEST_F(SceneReloadTest, AnErrorIsOneLineAndNoScene) {
  SceneReload reload(file, {});
  write("colr = [0, 1, 0]");
  const std::string log = log_of_two_looks(reload);
  EXPECT_THAT(log, HasSubstr("unknown key 'colr'"));
  EXPECT_THAT(log, HasSubstr("; the present picture stays"));
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 1) << log;
  EXPECT_FALSE(reload.take());
  EXPECT_EQ(log_of_two_looks(reload), "") << "one line, not one a look";
  std::filesystem::remove(file);
  EXPECT_THAT(log_of_two_looks(reload), HasSubstr("a.toml is gone; the present picture stays"));
}

TEST_F(SceneReloadTest, LooksByItself) {
  SceneReload reload(file, {});
  reload.start();
  write("color = [0, 0, 1]");
  std::optional<Scene> scene;
  ASSERT_TRUE(wait_until([&] { return (scene = reload.take()).has_value(); }));
  EXPECT_EQ(scene->objects.at(0).colour, (std::array<double, 3>{0, 0, 1}));
}

}  // namespace
}  // namespace hapton
