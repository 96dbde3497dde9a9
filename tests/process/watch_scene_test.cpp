// A scene file that is saved while all nodes run: felt and seen.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/process/system.h"

#ifdef HAPTON_WITH_VISION

namespace hapton::process {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// Counts the pixels in which one channel is more than twice each of the others: for red, green and blue.
std::array<std::size_t, 3> count_colours(const std::filesystem::path& file) {
  std::array<std::size_t, 3> counts = {};
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&image, file.c_str()) == 0) return counts;
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> rgb(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, rgb.data(), 0, nullptr) == 0) return counts;
  for (std::size_t i = 0; i + 2 < rgb.size(); i += 3) {
    for (std::size_t c = 0; c < 3; ++c) {
      const int own = rgb[i + c];
      const int one = rgb[i + (c + 1) % 3];
      const int other = rgb[i + (c + 2) % 3];
      counts[c] += own > 40 && own > 2 * one && own > 2 * other ? 1U : 0U;
    }
  }
  return counts;
}

struct WatchedScene : testing::Test {
  WatchedScene() { system.start("io_node"); }
  void save(const std::string& keys) {
    std::ofstream(file) << "[[object]]\nmesh = '" HAPTON_SOURCE_DIR "/meshes/wingnut.obj'\nunit = 'mm'\nname = 'nut'\n" << keys;
  }
  std::vector<std::string> arguments(std::vector<std::string> more) const {
    more.insert(more.end(), {"--hub", system.hub(), "--scene", file.string()});
    return more;
  }
  static bool waits_for(Program& program, const std::string& line, std::size_t times = 1) {
    return System::wait_until([&] {
      std::size_t count = 0;
      for (auto at = program.err().find(line); at != std::string::npos; at = program.err().find(line, at + 1)) ++count;
      return count >= times;
    });
  }
  // Ends vision_node, and counts the colours of its last picture.
  std::array<std::size_t, 3> end_and_count_colours(Program& vision) const {
    vision.send_signal(SIGTERM);
    const auto ended = vision.wait(kPatience);
    EXPECT_TRUE(ended && ended->exit_code == 0) << vision.err();
    return count_colours(picture);
  }

  System system;
  VirtualDisplay display;
  std::filesystem::path file = system.folder() / "live.toml";
  std::filesystem::path picture = system.folder() / "seen.png";
  std::vector<std::string> vision_arguments = {
      "--watch-scene",     "--size", "320x240", "--no-depth-cues", "--no-keys-help", "--screenshot", picture.string(),
      "--screenshot-when", "exit"};
};

TEST_F(WatchedScene, IsSeenAsItIsFelt) {
  save("color = [1, 0, 0]\n");
  Program haptics("haptics_node", arguments({"--watch-scene"}), system.folder());
  Program vision("vision_node", arguments(vision_arguments), system.folder(), display.name());
  EXPECT_TRUE(waits_for(vision, "joined the hub")) << vision.err();
  (void)system.wait_for_report([](const Json& now) { return !now["notes"].value("scene_hash", std::string()).empty(); });
  // Neither node accepts this file.
  save("colr = [0, 1, 0]\n");
  EXPECT_TRUE(waits_for(vision, "line 5: unknown key 'colr'")) << vision.err();
  EXPECT_TRUE(waits_for(vision, "the present picture stays"));
  EXPECT_TRUE(waits_for(haptics, "the present scene stays in use"));
  // Another colour and another place: both nodes accept this file.
  save("color = [0, 1, 0]\nposition_m = [0.01, 0, 0]\n");
  EXPECT_TRUE(waits_for(haptics, "its objects fade in")) << haptics.err();
  EXPECT_TRUE(waits_for(vision, "was read again, and is shown")) << vision.err();
  // Only another colour, which affects no force.
  save("color = [0, 0, 1]\nposition_m = [0.01, 0, 0]\n");
  EXPECT_TRUE(waits_for(haptics, "nothing that affects the forces has changed")) << haptics.err();
  EXPECT_TRUE(waits_for(vision, "was read again, and is shown", 2)) << vision.err();
  const auto [red, green, blue] = end_and_count_colours(vision);
  EXPECT_GT(blue, 200U);
  EXPECT_LT(red, blue / 20);
  EXPECT_LT(green, blue / 20);
  EXPECT_THAT(vision.err(), Not(HasSubstr("another scene")));
}

// This haptics node does not watch the file: what is felt stays, and so does the picture.
TEST_F(WatchedScene, IsShownOnlyOnceAHapticsNodeUsesIt) {
  save("color = [1, 0, 0]\n");
  Program haptics("haptics_node", arguments({}), system.folder());
  Program vision("vision_node", arguments(vision_arguments), system.folder(), display.name());
  EXPECT_TRUE(waits_for(vision, "joined the hub")) << vision.err();
  (void)system.wait_for_report([](const Json& now) { return !now["notes"].value("scene_hash", std::string()).empty(); });
  // haptics_node announces what is felt once a second; before its first announcement the picture has nothing to wait for.
  std::this_thread::sleep_for(std::chrono::milliseconds(2500));
  save("color = [0, 1, 0]\nposition_m = [0.01, 0, 0]\n");
  EXPECT_TRUE(waits_for(vision, "the picture waits until haptics_node uses it")) << vision.err();
  // A haptics node that starts later reads the file as it is now.
  haptics.send_signal(SIGTERM);
  EXPECT_TRUE(haptics.wait(kPatience));
  Program later("haptics_node", arguments({}), system.folder());
  EXPECT_TRUE(waits_for(vision, "was read again, and is shown")) << vision.err();
  const auto [red, green, blue] = end_and_count_colours(vision);
  EXPECT_GT(green, 200U);
  EXPECT_LT(red, green / 20);
}

}  // namespace
}  // namespace hapton::process

#endif
