#include "tools/doctor/udev_rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tests/tools/doctor/fake_machine.h"

namespace hapton::doctor {
namespace {

using ::testing::HasSubstr;

struct UdevRules : testing::Test {
  UdevRules() {
    device.vid = 0x256f;
    device.pid = 0xc63a;
    device.sysfs_folder = "/sys/devices/usb1/1-2";
    machine.remove("/usr/lib/udev/rules.d");
  }
  std::optional<UdevRule> find() { return find_udev_rule(machine.make(), device, node); }

  FakeMachine machine;
  PluggedDevice device;
  DeviceNode node = {"/dev/hidraw1", "hid-generic", DevicePath::hidraw};
};

TEST_F(UdevRules, AreFoundByIdsPatternsAndBluetoothNames) {
  for (const char* line : {
           "SUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"256f\", TAG+=\"uaccess\"",
           "KERNEL==\"hidraw*\", ATTRS{idVendor}==\"046d|256f\", ATTRS{idProduct}==\"c63[0-9a]\", MODE=\"0666\"",
           "KERNEL==\"hidraw*\", KERNELS==\"0003:256F:C63A.*\", GROUP=\"plugdev\"",
           "KERNEL==\"hidraw*\", \\\n  ATTRS{idVendor}==\"256f\", \\\n  TAG+=\"uaccess\"",
       }) {
    machine.write("/etc/udev/rules.d/70-a.rules", line);
    ASSERT_TRUE(find()) << line;
    EXPECT_EQ(find()->name(), "70-a.rules");
    EXPECT_FALSE(find()->has_capital_digits) << line;
  }
}

TEST_F(UdevRules, ForOtherDevicesOrWithoutRightsAreIgnored) {
  for (const char* line : {
           "SUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"1234\", TAG+=\"uaccess\"",
           "SUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"256f\", ATTRS{idProduct}==\"c631\", TAG+=\"uaccess\"",
           "SUBSYSTEM==\"tty\", ATTRS{idVendor}==\"256f\", TAG+=\"uaccess\"",
           "# SUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"256f\", TAG+=\"uaccess\"",
           "SUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"256f\", ENV{ID_X}=\"1\"",
       }) {
    machine.write("/etc/udev/rules.d/70-a.rules", line);
    EXPECT_FALSE(find()) << line;
  }
}

TEST_F(UdevRules, AreEvaluatedWithTheirPropertiesAndJumps) {
  machine.write("/etc/udev/rules.d/70-a.rules",
                "ACTION==\"remove\", GOTO=\"end\"\nSUBSYSTEM!=\"hidraw\", GOTO=\"other\"\nATTRS{idVendor}==\"256f\", ENV{OURS}=\"1\"\n"
                "LABEL=\"other\"\nENV{OURS}==\"1\", GROUP=\"plugdev\", TAG+=\"uaccess\"\nLABEL=\"end\"\n");
  ASSERT_TRUE(find());
  EXPECT_EQ(find()->group, "plugdev");
  EXPECT_TRUE(find()->has_uaccess);
  device.vid = 0x1234;
  EXPECT_FALSE(find());
  device.vid = 0x256f;
  node.kind = DevicePath::serial;
  EXPECT_FALSE(find());
}

// The rules of the package, for every way in which a supported device can be connected.
TEST_F(UdevRules, OfThePackageGrantAccessToEachSupportedDevice) {
  const std::string rules = [] {
    std::ifstream file(HAPTON_SOURCE_DIR "/deploy/udev/70-hapton.rules");
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  }();
  machine.write("/usr/lib/udev/rules.d/70-hapton.rules", rules);
  const auto is_granted = [&](std::uint16_t vid, std::uint16_t pid, DevicePath kind, bool by_usb = true, const char* name = "") {
    device.vid = vid;
    device.pid = pid;
    device.sysfs_folder = by_usb ? "/sys/devices/usb1/1-2" : "";
    device.device_option = name;
    node.kind = kind;
    const auto rule = find();
    return rule && rule->has_uaccess && rule->group == "plugdev" && !rule->is_too_late() && !rule->has_capital_digits;
  };
  EXPECT_TRUE(is_granted(0x1234, 0x0006, DevicePath::hidraw));
  EXPECT_TRUE(is_granted(0x256f, 0xc635, DevicePath::hidraw));
  EXPECT_TRUE(is_granted(0x046d, 0xc626, DevicePath::hidraw));
  EXPECT_TRUE(is_granted(0x256f, 0xc63a, DevicePath::hidraw, false));
  EXPECT_TRUE(is_granted(0xcafe, 0x4001, DevicePath::hidraw, true, "hapton-hid"));
  EXPECT_TRUE(is_granted(0x2988, 0x0302, DevicePath::serial));
  EXPECT_TRUE(keeps_modem_manager_off(machine.make(), device, node));
  EXPECT_TRUE(is_granted(0x1451, 0x0402, DevicePath::usb));
  EXPECT_TRUE(is_granted(0x0403, 0xcb48, DevicePath::usb));
  EXPECT_FALSE(is_granted(0x046d, 0xc077, DevicePath::hidraw)) << "a Logitech mouse is no supported device";
  EXPECT_FALSE(is_granted(0xcafe, 0x4001, DevicePath::hidraw));
}

TEST_F(UdevRules, HideThoseOfTheSameNameInLaterFolders) {
  machine.write("/usr/lib/udev/rules.d/70-a.rules", "SUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"256f\", TAG+=\"uaccess\"");
  machine.write("/etc/udev/rules.d/70-a.rules", "");
  EXPECT_FALSE(find());
}

TEST_F(UdevRules, WithCapitalDigitsOrTooLateAreRejected) {
  machine.write("/etc/udev/rules.d/99-a.rules", "SUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"256F\", TAG+=\"uaccess\"");
  EXPECT_TRUE(find()->has_capital_digits);
  machine.write("/etc/udev/rules.d/99-a.rules", "SUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"256f\", TAG+=\"uaccess\"");
  EXPECT_FALSE(find()->has_capital_digits);
  EXPECT_TRUE(find()->is_too_late());
}

TEST_F(UdevRules, AreAddedByALineThatIsFoundAgain) {
  const std::string line = line_that_adds_rule(device, node.kind);
  EXPECT_THAT(line, HasSubstr("sudo tee -a /etc/udev/rules.d/70-hapton-local.rules"));
  const std::size_t begin = line.find('\'') + 1;
  machine.write("/etc/udev/rules.d/70-hapton-local.rules", line.substr(begin, line.find('\'', begin) - begin));
  ASSERT_TRUE(find());
  EXPECT_EQ(find()->group, "plugdev");
  EXPECT_TRUE(find()->has_uaccess);
  EXPECT_FALSE(find()->is_too_late());
}

}  // namespace
}  // namespace hapton::doctor
