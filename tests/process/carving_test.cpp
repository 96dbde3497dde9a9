// Material that the stylus carves, in the real programs: what is felt is seen, also by a vision node that starts later.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "tests/process/program.h"
#include "tests/process/system.h"
#include "tests/support/scratch_folder.h"

#ifdef HAPTON_WITH_VISION

namespace hapton::process {
namespace {

// A red slab, 100 x 100 x 20 mm. Again and again the hand pushes the ball through it, 24 mm to the right of its middle, and withdraws far
// from it: a haptics node that starts while the ball is inside carves nothing until the ball has left.
constexpr const char* kClaySlab =
    "v -0.05 -0.05 -0.01\nv 0.05 -0.05 -0.01\nv 0.05 0.05 -0.01\nv -0.05 0.05 -0.01\nv -0.05 -0.05 0.01\nv 0.05 -0.05 0.01\n"
    "v 0.05 0.05 0.01\nv -0.05 0.05 0.01\nf 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\n"
    "f 4 1 5\nf 4 5 8\n";
constexpr const char* kClayScene =
    "[[object]]\nmesh = \"slab.obj\"\nname = \"clay\"\ncolor = [1, 0, 0]\nsculpt = true\nvoxel_mm = 2\ntool_radius_mm = 14\n";
constexpr const char* kThroughSlab =
    "t_s,x_m,y_m,z_m,buttons\n0,-0.09,0.06,0.04,0\n0.4,0.024,0,0.04,1\n1.4,0.024,0,-0.04,1\n2.4,0.024,0,0.04,0\n2.8,-0.09,0.06,0.04,0\n"
    "6,-0.09,0.06,0.04,0\n";

struct RedPixels {
  std::size_t count = 0;
  double min_x = 1e9, max_x = -1e9;
  double hole_mean_x = 0.0;  // mean x of the pixels that are not red, between the first and the last red one of each row
  std::size_t hole_pixels = 0;
};

RedPixels measure_red(const std::string& file) {
  RedPixels red;
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&image, file.c_str()) == 0) return red;
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> rgb(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, rgb.data(), 0, nullptr) == 0) return red;
  for (std::size_t y = 0; y < image.height; ++y) {
    std::vector<std::size_t> row;
    for (std::size_t x = 0; x < image.width; ++x) {
      const std::uint8_t* pixel = &rgb[3 * (y * image.width + x)];
      if (pixel[0] > 60 && pixel[0] > 3 * pixel[1] && pixel[0] > 3 * pixel[2]) row.push_back(x);
    }
    if (row.empty()) continue;
    red.count += row.size();
    red.min_x = std::min(red.min_x, static_cast<double>(row.front()));
    red.max_x = std::max(red.max_x, static_cast<double>(row.back()));
    for (std::size_t i = 1; i < row.size(); ++i) {
      for (std::size_t x = row[i - 1] + 1; x < row[i]; ++x) {
        ++red.hole_pixels;
        red.hole_mean_x += static_cast<double>(x);
      }
    }
  }
  if (red.hole_pixels > 0) red.hole_mean_x /= static_cast<double>(red.hole_pixels);
  return red;
}

// Takes a picture, seen from the front, of what a vision node shows after some seconds.
struct PictureTaker {
  ScratchFolder& scratch;
  std::string display;

  RedPixels take(const std::string& hub, const std::string& scene) {
    const std::string picture = (scratch.path() / "seen.png").string();
    Program vision("vision_node",
                   {"--hub", hub, "--scene", scene, "--size", "480x360", "--view-yaw-deg", "0", "--view-pitch-deg", "0", "--no-depth-cues",
                    "--seconds", "3", "--screenshot", picture, "--screenshot-when", "exit"},
                   scratch.path(), display);
    const auto ended = vision.wait(kPatience);
    EXPECT_TRUE(ended && ended->exit_code == 0) << vision.err();
    return measure_red(picture);
  }
};

TEST(CarvedMaterial, AHoleIsSeenByAVisionNodeThatStartsLater) {
  ScratchFolder scratch;
  scratch.write("slab.obj", kClaySlab);
  const std::string way = scratch.write("way.csv", kThroughSlab).string();
  const std::string scene = scratch.write("clay.toml", kClayScene).string();
  const std::string hub = "127.0.0.1:" + find_free_port();
  const VirtualDisplay display;
  PictureTaker camera{scratch, display.name()};
  const RedPixels whole = camera.take(hub, scene);
  ASSERT_GT(whole.count, 2000U);
  EXPECT_LT(whole.hole_pixels, whole.count / 200) << "no hub: nothing is carved";
  const std::string file = (scratch.path() / "session.hapton").string();
  Program io("io_node", {"--bind", hub, "--device", "replay", "--loop", "--trajectory", way, "--record", file}, scratch.path());
  Program haptics("haptics_node", {"--hub", hub, "--scene", scene}, scratch.path());
  RedPixels carved;
  // The programs may still be starting, or the machine may stand still for seconds.
  EXPECT_TRUE(System::wait_until(
      [&] {
        carved = camera.take(hub, scene);
        return carved.hole_pixels > whole.count / 25;
      },
      4 * kPatience))
      << haptics.err() << io.err();
  // A hole of 28 mm in 100 by 100 mm: 6 % of its area, a little less because the wall of the hole is red too.
  EXPECT_NEAR(static_cast<double>(carved.hole_pixels), 0.06 * static_cast<double>(whole.count), 0.025 * static_cast<double>(whole.count));
  EXPECT_NEAR(carved.hole_mean_x, whole.min_x + 0.74 * (whole.max_x - whole.min_x), 0.04 * (whole.max_x - whole.min_x))
      << "where it was carved";
  for (Program* program : {&haptics, &io}) {
    program->send_signal(SIGTERM);
    const auto ended = program->wait(kPatience);
    EXPECT_TRUE(ended && ended->exit_code == 0);
  }
  const Ended info = run("hapton", {"session", "info", file}, scratch.path()).value_or(Ended{});
  EXPECT_THAT(info.out, testing::HasSubstr("Carves"));
}

}  // namespace
}  // namespace hapton::process

#endif
