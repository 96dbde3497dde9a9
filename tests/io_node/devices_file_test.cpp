#include "io_node/devices_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

const std::string kLeft = "[[device]]\nname = \"left\"\ndevice = \"simulated\"\nbind = \"127.0.0.1:4950\"\n";
const std::string kRight = "[[device]]\nname = \"right\"\ndevice = \"simulated\"\nbind = \"127.0.0.1:4951\"\n";

struct DevicesFiles : testing::Test {
  Result<std::vector<IoOptions>> read(const std::string& text, const IoOptions& common = {}) {
    std::ofstream(path) << text;
    return read_devices_file(path, common);
  }
  std::string rejection(const std::string& text) {
    const auto devices = read(text);
    return devices ? "it was read" : devices.error().what;
  }

  ScratchFolder scratch;
  std::filesystem::path path = scratch.path() / "devices.toml";
};

TEST_F(DevicesFiles, MayGiveEachDeviceAVrpnServerOfItsOwn) {
  const auto devices = read(kLeft + "vrpn = \"127.0.0.1:3883\"\nvrpn_name = \"left\"\n" + kRight);
  ASSERT_TRUE(devices) << devices.error().what;
  EXPECT_EQ((*devices)[0].vrpn, "127.0.0.1:3883");
  EXPECT_EQ((*devices)[0].vrpn_name, "left");
  EXPECT_EQ((*devices)[1].vrpn, "");
}

TEST_F(DevicesFiles, GiveEachDeviceItsOptionsAndTheRestInCommon) {
  IoOptions common;
  common.out = "out";
  common.rate_hz = 500.0;
  common.seconds = 3.0;
  const auto devices = read(kLeft + "position_m = [-0.1, 0, 0.2]\nrotation_deg = [0, 90, 0]\nseed = 7\nmax_force_n = 2.5\ncpu = 1\n" +
                                kRight + "rate_hz = 2000\nrecord = \"right.hapton\"\nmetrics = \"127.0.0.1:9464\"\n",
                            common);
  ASSERT_TRUE(devices) << devices.error().what;
  ASSERT_EQ(devices->size(), 2U);
  const IoOptions& left = devices->front();
  EXPECT_EQ(left.name, "left");
  EXPECT_EQ(left.bind, "127.0.0.1:4950");
  EXPECT_EQ(left.out, "out/left");
  EXPECT_EQ(left.rate_hz, 500.0);
  EXPECT_EQ(left.seconds, 3.0);
  EXPECT_EQ(left.device.seed, 7U);
  EXPECT_EQ(left.device.max_force_n, 2.5);
  EXPECT_EQ(left.realtime.cpu, 1);
  EXPECT_LT((left.device.X_WB * Vec3::UnitX() - Vec3(-0.1, 0.0, -0.8)).norm(), 1e-12);
  const IoOptions& right = devices->back();
  EXPECT_EQ(right.rate_hz, 2000.0);
  EXPECT_EQ(right.metrics, "127.0.0.1:9464");
  EXPECT_EQ(right.record, (scratch.path() / "right.hapton").string());
  EXPECT_EQ(right.device.X_WB.matrix(), Pose::Identity().matrix());
}

TEST_F(DevicesFiles, GiveThePassivityControllerTheDevicesMechanics) {
  const auto devices = read(kLeft + "passive_mass_kg = 0.075\npassive_damping_ns_per_m = 0.2\npassive_friction_n = 0.04\n" +
                            "passive_position_step_m = 3e-5\n" + kRight);
  ASSERT_TRUE(devices) << devices.error().what;
  const DeviceSettings& left = devices->front().device;
  EXPECT_EQ(left.passive_mass_kg, 0.075);
  EXPECT_EQ(left.passive_damping_ns_per_m, 0.2);
  EXPECT_EQ(left.passive_friction_n, 0.04);
  EXPECT_EQ(left.passive_position_step_m, 3e-5);
  EXPECT_EQ(devices->back().device.passive_mass_kg, 0.0);
}

TEST_F(DevicesFiles, GiveEachDeviceItsButtons) {
  const auto devices = read(kLeft + "dead_mans_switch = 1\nclutch_button = 2\n" + kRight);
  ASSERT_TRUE(devices) << devices.error().what;
  EXPECT_EQ(devices->front().device.dead_mans_switch, 1);
  EXPECT_EQ(devices->front().device.clutch_button, 2);
  EXPECT_EQ(devices->back().device.dead_mans_switch, 0);
  EXPECT_EQ(devices->back().device.clutch_button, 0);
}

TEST_F(DevicesFiles, TheOldNameOfTheDeadMansSwitchCountsFromZero) {
  const auto devices = read(kLeft + "hold_button = 0\n" + kRight + "hold_button = -1\n");
  ASSERT_TRUE(devices) << devices.error().what;
  EXPECT_EQ(devices->front().device.dead_mans_switch, 1);
  EXPECT_EQ(devices->back().device.dead_mans_switch, 0);
  EXPECT_THAT(rejection(kLeft + "hold_button = 0\ndead_mans_switch = 1\n"), HasSubstr("'hold_button' is the old name"));
}

TEST_F(DevicesFiles, TurnAboutXThenYThenZOfTheWorld) {
  const auto devices = read(kLeft + "rotation_deg = [90, 90, 0]\n");
  ASSERT_TRUE(devices) << devices.error().what;
  // The first turn, about x, takes y to z; the second turn, about y, takes z to x.
  EXPECT_LT((devices->front().device.X_WB * Vec3::UnitY() - Vec3::UnitX()).norm(), 1e-12);
}

TEST_F(DevicesFiles, NameOtherFilesFromTheirOwnFolder) {
  const auto devices =
      read("[[device]]\nname = \"a\"\ndevice = \"replay\"\nbind = \"127.0.0.1:0\"\ntrajectory = \"sub/t.csv\"\nloop = true\n");
  ASSERT_TRUE(devices) << devices.error().what;
  EXPECT_EQ(devices->front().device.trajectory, (scratch.path() / "sub/t.csv").string());
  EXPECT_TRUE(devices->front().device.loop);
}

TEST_F(DevicesFiles, SayWhatIsWrongWhereAndHowToFixIt) {
  EXPECT_THAT(rejection(""), HasSubstr("add one for each device"));
  EXPECT_THAT(rejection("[device]\nname = \"left\"\n"), HasSubstr("[[device]]"));
  EXPECT_THAT(rejection("rate = 1000\n" + kLeft), HasSubstr("devices.toml:1: unknown key 'rate'"));
  EXPECT_THAT(rejection("[[device]]\ndevice = \"simulated\"\nbind = \"127.0.0.1:0\"\n"), HasSubstr("'name' is missing in [[device]] 1"));
  EXPECT_THAT(rejection("[[device]]\nname = \"a\"\nbind = \"127.0.0.1:0\"\n"), HasSubstr("'device' is missing"));
  EXPECT_THAT(rejection("[[device]]\nname = \"a\"\ndevice = \"simulated\"\n"), HasSubstr("'bind' is missing"));
  EXPECT_THAT(rejection("[[device]]\nname = \"../a\"\ndevice = \"simulated\"\nbind = \"127.0.0.1:0\"\n"),
              HasSubstr(":2: 'name' is '../a'"));
  EXPECT_THAT(rejection("[[device]]\nname = \"a\"\ndevice = \"sofa\"\nbind = \"127.0.0.1:0\"\n"),
              HasSubstr("unknown device 'sofa'; choose one of simulated"));
  EXPECT_THAT(rejection(kLeft + "max_force_n = -1\n"), HasSubstr("'max_force_n' in [[device]] 1 is -1"));
  EXPECT_THAT(rejection(kLeft + "position_m = [0, 0, 1e9]\n"), HasSubstr("number 3 of 'position_m'"));
  EXPECT_THAT(rejection(kLeft + "posiiton_m = [0, 0, 0]\n"), HasSubstr(":5: unknown key 'posiiton_m' in [[device]] 1"));
  EXPECT_THAT(rejection(kLeft + "clutch_button = 33\n"), HasSubstr("'clutch_button' in [[device]] 1 is 33"));
  EXPECT_THAT(rejection(kLeft + "dead_mans_switch = 1\nclutch_button = 1\n"),
              HasSubstr("'clutch_button' = 1 is also the button of 'dead_mans_switch'"));
  EXPECT_THAT(rejection(kLeft + kLeft), HasSubstr("two devices 'left'"));
  EXPECT_THAT(rejection(kLeft + "[[device]]\nname = \"right\"\ndevice = \"simulated\"\nbind = \"127.0.0.1:4950\"\n"),
              HasSubstr(":8: 'left' and 'right' both listen at 127.0.0.1:4950"));
  EXPECT_THAT(rejection(kLeft + "record = \"a\"\n" + kRight + "record = \"a\"\n"), HasSubstr("name two files"));
  EXPECT_THAT(rejection(kLeft + "record = \"a\"\n" + kRight + "record = \"./b/../a\"\n"), HasSubstr("name two files"));
  EXPECT_THAT(rejection(kLeft + "record = \"/dev/stdout\"\n" + kRight + "record = \"/dev/stdout\"\n"), HasSubstr("name two files"));
  EXPECT_THAT(read_devices_file(scratch.path() / "none.toml", {}).error().what, HasSubstr("none.toml"));
}

// Otherwise two hubs might open the same arm, and their forces would alternate on it.
TEST_F(DevicesFiles, TwoOfOneKindNeedIdsThatDiffer) {
  const auto two_devices = [](const std::string& left, const std::string& right) {
    return "[[device]]\nname = \"left\"\ndevice = \"hapton-hid\"\nbind = \"127.0.0.1:0\"\n" + left +
           "[[device]]\nname = \"right\"\ndevice = \"hapton-hid\"\nbind = \"127.0.0.1:0\"\n" + right;
  };
  const auto is_rejected = HasSubstr("'left' and 'right' are both hapton-hid: give each an id (hapton doctor lists them)");
  EXPECT_THAT(rejection(two_devices("", "")), is_rejected);
  EXPECT_THAT(rejection(two_devices("id = \"A\"\n", "")), is_rejected);
  EXPECT_THAT(rejection(two_devices("", "id = \"A\"\n")), is_rejected);
  EXPECT_THAT(rejection(two_devices("id = \"A\"\n", "id = \"A\"\n")), is_rejected);
  EXPECT_EQ(rejection(two_devices("id = \"A\"\n", "id = \"B\"\n")), "it was read");
  EXPECT_EQ(rejection(kLeft + "[[device]]\nname = \"right\"\ndevice = \"hapton-hid\"\nbind = \"127.0.0.1:0\"\n"), "it was read");
}

// Each number is read at its limits. Just beyond them it is rejected, and the error has its name.
TEST_F(DevicesFiles, NumbersAreReadUpToTheirLimits) {
  struct Limits {
    const char* key;
    std::string below, least, most, above;  // an empty text: not tried
  };
  const Limits all[] = {{"cpu", "-2", "-1", "4095", "4096"},
                        {"clutch_button", "-1", "0", "32", "33"},
                        {"passive_mass_kg", "-0.001", "0", "100", "100.001"},
                        {"passive_damping_ns_per_m", "-0.001", "0", "1000", "1000.001"},
                        {"passive_friction_n", "-0.001", "0", "100", "100.001"},
                        {"passive_position_step_m", "-0.001", "0", "0.01", "0.0100001"},
                        {"seed", "-1", "0", "", ""}};
  for (const Limits& limits : all) {
    for (const std::string& inside : {limits.least, limits.most}) {
      if (inside.empty()) continue;
      EXPECT_EQ(rejection(kLeft + limits.key + " = " + inside + "\n"), "it was read") << limits.key << " = " << inside;
    }
    for (const std::string& outside : {limits.below, limits.above}) {
      if (outside.empty()) continue;
      EXPECT_THAT(rejection(kLeft + limits.key + " = " + outside + "\n"), HasSubstr(std::string("'") + limits.key + "'")) << outside;
    }
  }
}

TEST_F(DevicesFiles, OfThePackageAreRight) {
  const auto devices = read_devices_file(HAPTON_SOURCE_DIR "/deploy/etc/devices.toml", {});
  ASSERT_TRUE(devices) << devices.error().what;
  EXPECT_EQ(devices->size(), 2U);
}

}  // namespace
}  // namespace hapton
