// Runs inside the guest of deploy/hid-test, on a kernel with uhid: virtual devices below a real HID stack, the unmodified io_node above it.
// No timing is checked: software emulation is slow. Waits end with a condition.
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <cmath>
#include <functional>
#include <memory>
#include <sstream>
#include <tuple>

#include "devices/wooden_kinematics.h"
#include "hid/hidapi_transport.h"
#include "tests/hid_guest/virtual_devices.h"
#include "tests/hid_guest/wall_haptics.h"
#include "tests/process/program.h"
#include "tests/support/patience.h"
#include "tests/support/scratch_folder.h"

namespace hapton::guest {
namespace {

constexpr const char* kHub = "127.0.0.1:4950";

class Guest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(make_key_file(key_file()));
    key_ = std::make_unique<LinkKey>(*read_key_file(key_file()));
  }
  void TearDown() override {
    if (!HasFailure() || !io_node_) return;
    if (io_node_->is_running()) io_node_->kill();
    io_node_->wait(process::Seconds(10));
    ADD_FAILURE() << io_node_->out() << io_node_->err();
  }

  std::string key_file() const { return (folder_.path() / "key").string(); }
  void start(const std::string& device) {
    io_node_ = std::make_unique<process::Program>(
        "io_node", std::vector<std::string>{"--device", device, "--bind", kHub, "--key", key_file(), "--flight", "off", "--spin", "0"},
        folder_.path());
  }
  void start_wall(double z_m) { haptics_ = std::make_unique<WallHaptics>(kHub, *key_, z_m); }
  void end() {
    io_node_->send_signal(SIGTERM);
    const auto ended = io_node_->wait(process::Seconds(30));
    ASSERT_TRUE(ended);
    EXPECT_EQ(ended->exit_code, 0) << ended->err;
    std::istringstream lines(ended->out);
    for (std::string line; std::getline(lines, line);) {
      if (line.find(" samples (") != std::string::npos) std::printf("io_node: %s\n", line.c_str());
    }
  }
  Vec3 p() const { return haptics_->newest().p_WD; }
  // Whether the system has a device node for the device with this serial number.
  bool has_node(const std::string& serial) const {
    for (const HidDescription& device : list_hid_devices()) {
      if (device.serial == serial) return true;
    }
    return false;
  }
  // Waits for this many more samples, whatever the device does.
  bool receives_more(std::uint64_t samples) const {
    const std::uint64_t from = haptics_->states();
    return wait_until([&] { return haptics_->states() >= from + samples; });
  }

  ScratchFolder folder_;
  std::unique_ptr<LinkKey> key_;
  std::unique_ptr<process::Program> io_node_;
  std::unique_ptr<WallHaptics> haptics_;
};

// The force ramps up from zero to the earlier force in steps, without a jump.
void expect_ramp(const std::vector<Vec3>& received, const Vec3& full) {
  ASSERT_FALSE(received.empty());
  EXPECT_LT(received.front().norm(), 0.05 * full.norm());
  std::size_t values_on_ramp = 0;
  for (const Vec3& value : received) values_on_ramp += value.norm() > 0.05 * full.norm() && value.norm() < 0.9 * full.norm() ? 1 : 0;
  EXPECT_GE(values_on_ramp, 3U);
}

void print_report_counts(const UhidDevice& device) {
  std::printf("device: %llu reports in, %llu out\n", static_cast<unsigned long long>(device.inputs()),
              static_cast<unsigned long long>(device.outputs()));
}

class GuestWithWooden : public Guest {
 protected:
  // Motor currents for the force of the wall and the arm's own weight, at the arm's present encoder counts.
  static Vec3 expected_ma(const VirtualWooden& device, double force_z_n) {
    const WoodenKinematics arm{WoodenArm{}};
    const Vec3 angles = arm.angles_rad(device.counts());
    return 1e3 * arm.motor_current_a(arm.gravity_torque_nm(angles) + arm.joint_torque_nm(angles, Vec3(force_z_n, 0, 0)));
  }
  // The z axis of W is the x axis of the arm's base.
  static double z_of(const VirtualWooden& device) {
    const WoodenKinematics arm{WoodenArm{}};
    return arm.position_m(arm.angles_rad(device.counts())).x();
  }
};

TEST_F(GuestWithWooden, IsFoundTouchedUnpluggedInContactAndTouchedAgain) {
  VirtualWooden device(false);
  device.plug_in();
  ASSERT_TRUE(wait_until([&] { return has_node("W8"); }));
  start("wooden-haptics");
  const double wall_z_m = z_of(device) - 0.002;
  start_wall(wall_z_m);
  ASSERT_TRUE(receives_more(100));
  EXPECT_NEAR(p().z(), z_of(device), 1e-9);
  // Moves slowly towards and into the wall, by about 6 mm.
  const double outside_deg = 35.0;
  for (double in_deg = 0.0; in_deg <= 2.0; in_deg += 0.02) {
    device.lean(outside_deg - in_deg);
    ASSERT_TRUE(receives_more(2));
  }
  const double depth_m = wall_z_m - z_of(device);
  ASSERT_GT(depth_m, 0.003);
  const Vec3 expected = expected_ma(device, WallHaptics::kStiffnessNPerM * depth_m);
  const auto is_reached = [&] { return (device.received().last() - expected).norm() < 0.02 * expected.norm(); };
  EXPECT_TRUE(wait_until(is_reached)) << device.received().last().transpose() << " mA, not " << expected.transpose();
  ASSERT_TRUE(receives_more(100));
  EXPECT_TRUE(wait_until([&] { return device.outputs() > 300; }));
  EXPECT_TRUE(wait_until(is_reached));

  device.unplug();
  EXPECT_TRUE(wait_until([&] { return !has_node("W8"); }));
  ASSERT_TRUE(receives_more(100)) << "the servo goes on";
  EXPECT_TRUE(io_node_->is_running());
  device.clear_received();
  device.plug_in();
  EXPECT_TRUE(wait_until(is_reached)) << device.received().last().transpose() << " mA, not " << expected.transpose();
  expect_ramp(device.received().all(), expected);

  end();
  EXPECT_EQ(device.received().last(), Vec3::Zero());
  print_report_counts(device);
}

TEST_F(GuestWithWooden, OfTheLaterKindWithSixEncodersIsTouched) {
  VirtualWooden device(true);
  device.plug_in();
  ASSERT_TRUE(wait_until([&] { return has_node("W14"); }));
  start("wooden-haptics");
  start_wall(z_of(device) + 0.005);
  const Vec3 expected = expected_ma(device, WallHaptics::kStiffnessNPerM * 0.005);
  EXPECT_TRUE(wait_until([&] { return (device.received().last() - expected).norm() < 0.02 * expected.norm(); }));
  end();
}

TEST_F(Guest, HaptonHidIsFoundTouchedFrozenUnpluggedInContactAndTouchedAgain) {
  VirtualHaptonHid device;
  device.plug_in();
  ASSERT_TRUE(wait_until([&] { return has_node("V1"); }));
  start("hapton-hid");
  start_wall(0.0);
  ASSERT_TRUE(receives_more(100));
  EXPECT_NEAR(p().z(), 0.05, 1e-6);
  for (double z_m = 0.05; z_m >= -0.0051; z_m -= 0.0005) {
    device.move_to(z_m);
    ASSERT_TRUE(receives_more(2));
  }
  const Vec3 expected(0, 0, 1.5);
  device.move_to(-0.005);
  const auto is_reached = [&] { return device.is_on() && (device.received().last() - expected).norm() < 0.01; };
  EXPECT_TRUE(wait_until(is_reached)) << device.received().last().transpose() << " N";
  ASSERT_TRUE(receives_more(100));
  EXPECT_TRUE(wait_until([&] { return device.outputs() > 300; }));
  EXPECT_TRUE(wait_until(is_reached));

  io_node_->send_signal(SIGSTOP);
  EXPECT_TRUE(wait_until([&] { return !device.is_on(); })) << "the device's own watchdog";
  io_node_->send_signal(SIGCONT);
  EXPECT_TRUE(wait_until(is_reached)) << "armed again";

  device.unplug();
  ASSERT_TRUE(receives_more(100));
  EXPECT_TRUE(io_node_->is_running());
  device.clear_received();
  device.plug_in();
  EXPECT_TRUE(wait_until(is_reached)) << device.received().last().transpose() << " N";
  expect_ramp(device.received().all(), expected);

  end();
  EXPECT_FALSE(device.is_on());
  print_report_counts(device);
}

TEST_F(Guest, SpaceMouseMovesTheHandUntilItIsUnpluggedAndAgainAfterwards) {
  VirtualSpaceMouse device;
  device.plug_in();
  ASSERT_TRUE(wait_until([&] { return has_node("S1"); }));
  start("spacemouse");
  start_wall(-1.0);
  ASSERT_TRUE(receives_more(100));
  const Vec3 start_m = p();
  device.push(350, 2);
  EXPECT_TRUE(wait_until([&] { return p().x() > start_m.x() + 0.01; }));
  EXPECT_EQ(haptics_->newest().buttons, 2U);
  device.unplug();
  EXPECT_TRUE(wait_until([&] {
    const Vec3 before = p();
    return receives_more(100) && p() == before;
  }));
  device.push(-350, 0);
  const double there_m = p().x();
  device.plug_in();
  EXPECT_TRUE(wait_until([&] { return p().x() < there_m - 0.01; }));
  end();
}

// Runs as nobody, in the group plugdev; the device's node belongs to root until udev has run our rules.
class AsNobody {
 public:
  AsNobody() { EXPECT_TRUE(::setegid(kPlugdev) == 0 && ::seteuid(kNobody) == 0); }
  ~AsNobody() { EXPECT_TRUE(::seteuid(0) == 0 && ::setegid(0) == 0); }

 private:
  static constexpr gid_t kPlugdev = 46;
  static constexpr uid_t kNobody = 65534;
};

TEST_F(Guest, UdevGivesEachDeviceToPlugdevAndOpeningWaitsForThat) {
  VirtualWooden wooden(false);
  VirtualHaptonHid hapton_hid;
  VirtualSpaceMouse space_mouse;
  const std::vector<std::tuple<UhidDevice*, std::string, HidKind>> devices = {
      {&wooden, "W8", HidKind::wooden_haptics}, {&hapton_hid, "V1", HidKind::hapton_hid}, {&space_mouse, "S1", HidKind::space_mouse}};
  for (const auto& [device, serial, kind] : devices) {
    device->plug_in();
    ASSERT_TRUE(wait_until([&] { return has_node(serial); }));
    const AsNobody as_nobody;
    const auto opened = make_hid_opener(kind, "")();
    EXPECT_TRUE(opened) << opened.error().what;
  }
}

TEST_F(Guest, ADeviceWithoutARuleIsRejectedWithTheRemedy) {
  VirtualUnknownDevice unknown;
  unknown.plug_in();
  ASSERT_TRUE(wait_until([&] { return has_node("X1"); }));
  const AsNobody as_nobody;
  const auto opened = open_hid_device(list_hid_devices().front());
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().what.find("permission denied; install the udev rules"), std::string::npos) << opened.error().what;
}

TEST_F(Guest, ADeviceThatIsNotPluggedInIsReportedInOneLine) {
  start("hapton-hid");
  const auto ended = io_node_->wait(process::Seconds(30));
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 1);
  EXPECT_NE(ended->err.find("no Hapton HID is plugged in"), std::string::npos) << ended->err;
}

}  // namespace
}  // namespace hapton::guest
