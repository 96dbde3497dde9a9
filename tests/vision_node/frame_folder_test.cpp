#include "vision_node/frame_folder.h"

#include <gtest/gtest.h>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

TEST(FrameFolder, NumbersItsPicturesAndSaysHowTheyBecomeAVideo) {
  const ScratchFolder scratch;
  const auto path = scratch.path() / "a" / "b";
  auto folder = FrameFolder::open(path);
  ASSERT_TRUE(folder) << folder.error().what;
  EXPECT_TRUE(std::filesystem::is_directory(path));
  EXPECT_EQ(folder->next(), path / "frame_000001.png");
  EXPECT_EQ(folder->next(), path / "frame_000002.png");
  EXPECT_EQ(folder->describe(25.0), "2 pictures in " + path.string() + "; for a video: ffmpeg -framerate 25 -i " + path.string() +
                                        "/frame_%06d.png -pix_fmt yuv420p video.mp4");
  EXPECT_TRUE(FrameFolder::open(path)) << "it is empty";
}

TEST(FrameFolder, PicturesOfAnEarlierRunAreNotMixedWithThoseOfThisOne) {
  const ScratchFolder scratch;
  scratch.write("notes.txt", "text");
  ASSERT_TRUE(FrameFolder::open(scratch.path()));
  scratch.write("frame_000007.png", "text");
  const auto folder = FrameFolder::open(scratch.path());
  ASSERT_FALSE(folder);
  EXPECT_EQ(folder.error().what,
            "--frames " + scratch.path().string() + ": has frame_000007.png of an earlier run; name a new or empty folder");
  const auto below = FrameFolder::open(scratch.path() / "notes.txt" / "frames");
  ASSERT_FALSE(below);
  EXPECT_NE(below.error().what.find("the folder cannot be made"), std::string::npos) << below.error().what;
}

}  // namespace
}  // namespace hapton
