#include "devices/device_maker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "devices/hapton_hid_device.h"
#include "devices/wooden_haptics.h"
#include "link/messages.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

std::string rejection_of(const DeviceSettings& settings) {
  const auto made = make_device(settings);
  return made ? "it was made" : made.error().what;
}

TEST(DeviceMaker, MakesTheNamedDevice) {
  EXPECT_EQ((*make_device({}))->name(), "simulated");
  const ScratchFolder scratch;
  DeviceSettings settings;
  settings.name = "replay";
  settings.trajectory = (scratch.path() / "t.csv").string();
  std::ofstream(settings.trajectory) << "t_s,x_m,y_m,z_m\n0,1,2,3\n";
  EXPECT_EQ((*make_device(settings))->name(), "replay");
}

TEST(DeviceMaker, GivesTheSimulatedHandItsPath) {
  const ScratchFolder scratch;
  DeviceSettings settings;
  settings.trajectory = (scratch.path() / "t.csv").string();
  std::ofstream(settings.trajectory) << "t_s,x_m,y_m,z_m\n0,0.05,-0.04,0.03\n1,0.05,-0.04,0.03\n";
  const auto device = std::move(*make_device(settings));
  for (std::int64_t t = 0; t < 4000; ++t) device->read(t * 1'000'000);
  EXPECT_LT((device->read(4'000'000'000).p_WD - Vec3(0.05, -0.04, 0.03)).norm(), 0.002);
}

TEST(DeviceMaker, RepeatsThePathOfTheSimulatedHandOnlyInALoop) {
  const ScratchFolder scratch;
  DeviceSettings settings;
  settings.trajectory = (scratch.path() / "t.csv").string();
  std::ofstream(settings.trajectory) << "t_s,x_m,y_m,z_m\n0,0.05,0,0.1\n1,-0.05,0,0.1\n";
  for (const bool loop : {false, true}) {
    settings.loop = loop;
    const auto device = std::move(*make_device(settings));
    double largest_x_m = -1.0;
    for (std::int64_t t = 0; t < 8000; ++t) {
      const double x_m = device->read(t * 1'000'000).p_WD.x();
      if (t > 4000) largest_x_m = std::max(largest_x_m, x_m);
    }
    EXPECT_EQ(largest_x_m > 0.0, loop) << largest_x_m;
  }
}

TEST(DeviceMaker, GivesTheSimulatedHandItsSeed) {
  const auto place_after_2_s = [](std::uint64_t seed) {
    DeviceSettings settings;
    settings.seed = seed;
    const auto device = std::move(*make_device(settings));
    for (std::int64_t t = 0; t < 2000; ++t) device->read(t * 1'000'000);
    return device->read(2'000'000'000).p_WD;
  };
  EXPECT_EQ(place_after_2_s(3), place_after_2_s(3));
  EXPECT_NE(place_after_2_s(3), place_after_2_s(4));
}

TEST(DeviceMaker, PutsTheDeviceAtItsPose) {
  DeviceSettings settings;
  const Vec3 here = (*make_device(settings))->read(0).p_WD;
  settings.X_WB.translation() = Vec3(0.2, 0.0, 0.0);
  EXPECT_LT(((*make_device(settings))->read(0).p_WD - here - Vec3(0.2, 0.0, 0.0)).norm(), 1e-12);
}

TEST(DeviceMaker, SaysWhatIsMissing) {
  DeviceSettings settings;
  settings.trajectory = "t.csv";
  settings.name = "spacemouse";
  EXPECT_THAT(rejection_of(settings), HasSubstr("--trajectory applies to --device simulated or simulated-6dof or replay"));
  settings.name = "simulated";
  EXPECT_THAT(rejection_of(settings), HasSubstr("t.csv"));
  settings.name = "replay";
  EXPECT_THAT(rejection_of(settings), HasSubstr("t.csv"));
  settings.trajectory = "";
  EXPECT_THAT(rejection_of(settings), HasSubstr("--trajectory"));
  settings.name = "sofa";
  EXPECT_THAT(rejection_of(settings), HasSubstr("sofa"));
  for (const std::string& name : device_names()) EXPECT_THAT(rejection_of(settings), HasSubstr(name));
}

TEST(DeviceMaker, IgnoresNoSetting) {
  DeviceSettings settings;
  settings.id = "7";
  EXPECT_THAT(rejection_of(settings), HasSubstr("--device-id"));
  settings = {};
  settings.file = "mine.toml";
  EXPECT_THAT(rejection_of(settings), HasSubstr("--device-file"));
  settings = {};
  settings.loop = true;
  EXPECT_THAT(rejection_of(settings), HasSubstr("--loop"));
}

// The haptics node finds by a device's name how stiff a wall the device can render; a name that is too long arrives truncated. Vendors'
// devices and the SpaceMouse check their names in their own tests; the names of plug-ins are not known here.
TEST(DeviceMaker, GivesNamesThatTheHapticsNodeGetsWhole) {
  std::vector<std::string> names = {std::string(HaptonHidBackend().name()), std::string(WoodenHapticsBackend(WoodenSettings()).name())};
  const ScratchFolder scratch;
  DeviceSettings settings;
  settings.trajectory = (scratch.path() / "t.csv").string();
  std::ofstream(settings.trajectory) << "t_s,x_m,y_m,z_m\n0,1,2,3\n";
  for (const DeviceMaker& maker : device_makers()) {
    settings.name = maker.name;
    if (maker.takes_trajectory) names.emplace_back((*make_device(settings))->name());
  }
  EXPECT_EQ(names.size(), 5U);
  for (const std::string& name : names) EXPECT_LT(name.size(), LoopFacts().device.size()) << name;
}

TEST(DeviceMaker, KnowsEveryKindOnceAndSaysWhatItIs) {
  std::set<std::string_view> names;
  for (const DeviceMaker& maker : device_makers()) {
    EXPECT_TRUE(names.insert(maker.name).second) << maker.name;
    EXPECT_FALSE(maker.about.empty()) << maker.name;
    EXPECT_NE(maker.make, nullptr) << maker.name;
    EXPECT_THAT(describe_devices(), HasSubstr(maker.name));
  }
}

}  // namespace
}  // namespace hapton
