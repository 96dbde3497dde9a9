#include "vision_node/scene_reload.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <future>

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
    // Two writes within one clock step of the file system would look like one.
    std::filesystem::last_write_time(file, std::filesystem::file_time_type::clock::now() + std::chrono::seconds(++writes));
  }
  static std::string log_of_two_polls(SceneReload& reload) {
    return log_of([&] {
      reload.poll();
      reload.poll();
    });
  }

  ScratchFolder folder;
  std::filesystem::path file = folder.path() / "a.toml";
  int writes = 0;
};

TEST_F(SceneReloadTest, ASavedFileIsReadOnce) {
  SceneReload reload(file, {});
  EXPECT_EQ(log_of_two_polls(reload), "");
  EXPECT_FALSE(reload.take());
  write("color = [0, 1, 0]");
  EXPECT_EQ(log_of_two_polls(reload), "");
  const auto scene = reload.take();
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->objects.at(0).colour, (std::array<double, 3>{0, 1, 0}));
  EXPECT_FALSE(reload.take());
}

// Only after the reading does the picture warn that the haptics node has another scene.
TEST_F(SceneReloadTest, IsReadingFromTheFirstPollThatFindsTheChange) {
  SceneReload reload(file, {});
  reload.poll();
  EXPECT_FALSE(reload.is_reading());
  for (const char* keys : {"color = [0, 1, 0]", "colr = [0, 1, 0]"}) {
    write(keys);
    (void)log_of([&] { reload.poll(); });
    EXPECT_TRUE(reload.is_reading()) << keys;
    (void)log_of([&] { reload.poll(); });
    EXPECT_FALSE(reload.is_reading()) << keys;
  }
  write("color = [0, 0, 1]");
  reload.poll();
  std::filesystem::remove(file);
  (void)log_of_two_polls(reload);
  EXPECT_FALSE(reload.is_reading()) << "it is gone";
}

TEST_F(SceneReloadTest, AnErrorIsOneLineAndNoScene) {
  SceneReload reload(file, {});
  write("colr = [0, 1, 0]");
  const std::string log = log_of_two_polls(reload);
  EXPECT_THAT(log, HasSubstr("unknown key 'colr'"));
  EXPECT_THAT(log, HasSubstr("; the present picture stays"));
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 1) << log;
  EXPECT_FALSE(reload.take());
  EXPECT_EQ(log_of_two_polls(reload), "") << "one line, not one for each poll";
  std::filesystem::remove(file);
  EXPECT_THAT(log_of_two_polls(reload), HasSubstr("a.toml is gone; the present picture stays"));
}

TEST_F(SceneReloadTest, TheProblemIsKnownUntilTheFileIsRight) {
  SceneReload reload(file, {});
  EXPECT_EQ(reload.problem(), "");
  write("colr = [0, 1, 0]");
  (void)log_of_two_polls(reload);
  EXPECT_THAT(reload.problem(), testing::StartsWith("a.toml:"));
  EXPECT_THAT(reload.problem(), HasSubstr("unknown key 'colr'"));
  (void)log_of_two_polls(reload);
  EXPECT_THAT(reload.problem(), HasSubstr("unknown key 'colr'"));
  std::filesystem::rename(file, folder.path() / "b.toml");
  (void)log_of_two_polls(reload);
  EXPECT_EQ(reload.problem(), "a.toml is gone");
  (void)log_of_two_polls(reload);
  EXPECT_EQ(reload.problem(), "a.toml is gone");
  std::filesystem::rename(folder.path() / "b.toml", file);
  (void)log_of_two_polls(reload);
  EXPECT_THAT(reload.problem(), HasSubstr("unknown key 'colr'")) << "the same file is back";
  write("zzz = 1");
  EXPECT_THAT(log_of_two_polls(reload), HasSubstr("known are"));
  EXPECT_THAT(reload.problem(), testing::EndsWith("unknown key 'zzz' in [[object]] 1")) << "the log has the rest";
  write("color = [0, 1, 0]");
  (void)log_of_two_polls(reload);
  EXPECT_EQ(reload.problem(), "");
}

// A mesh of ten million triangles takes many seconds: a person who quits does not wait for it.
TEST_F(SceneReloadTest, ItsEndDoesNotWaitForAFileThatIsBeingRead) {
  std::promise<void> release;
  std::promise<void> begun;
  std::promise<void> dropped;
  const std::future<void> is_dropped = dropped.get_future();
  {
    SceneReload reload(file, {}, [&, may_end = release.get_future().share()](const auto& path, const auto& loading) {
      begun.set_value();
      may_end.wait();
      auto scene = load_scene(path, loading);
      dropped.set_value();
      return scene;
    });
    reload.start();
    write("color = [0, 1, 0]");
    ASSERT_EQ(begun.get_future().wait_for(std::chrono::seconds(30)), std::future_status::ready);
  }
  EXPECT_EQ(is_dropped.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
  release.set_value();
  EXPECT_EQ(is_dropped.wait_for(std::chrono::seconds(30)), std::future_status::ready);
}

// The destructor does not wait for the next poll either. It polls every half second, so 200 such waits would take 100 s.
TEST_F(SceneReloadTest, ItsEndDoesNotWaitForTheNextPoll) {
  std::future<void> all_ended = std::async(std::launch::async, [&] {
    for (int n = 0; n < 200; ++n) {
      SceneReload reload(file, {});
      reload.start();
    }
  });
  EXPECT_EQ(all_ended.wait_for(std::chrono::seconds(60)), std::future_status::ready);
}

TEST_F(SceneReloadTest, PollsByItself) {
  SceneReload reload(file, {});
  reload.start();
  write("color = [0, 0, 1]");
  std::optional<Scene> scene;
  ASSERT_TRUE(wait_until([&] { return (scene = reload.take()).has_value(); }));
  EXPECT_EQ(scene->objects.at(0).colour, (std::array<double, 3>{0, 0, 1}));
}

}  // namespace
}  // namespace hapton
