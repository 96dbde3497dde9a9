#include "tools/doctor/udev_rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/doctor/fake_machine.h"

namespace hapton::doctor {
namespace {

using ::testing::HasSubstr;

struct UdevRules : testing::Test {
  UdevRules() {
    device.vid = 0x256f;
    device.pid = 0xc63a;
    machine.remove("/usr/lib/udev/rules.d");
  }
  std::optional<UdevRule> find() { return find_udev_rule(machine.look(), device, DevicePath::hidraw); }

  FakeMachine machine;
  PluggedDevice device;
};

TEST_F(UdevRules, AreFoundByIdsPatternsAndBluetoothNames) {
  for (const char* line : {
           "SUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"256f\", TAG+=\"uaccess\"",
           "KERNEL==\"hidraw*\", ATTRS{idVendor}==\"046d|256f\", ATTRS{idProduct}==\"c63[0-9a]\", MODE=\"0666\"",
           "KERNEL==\"hidraw*\", KERNELS==\"0005:256F:C63A.*\", GROUP=\"plugdev\"",
           "KERNEL==\"hidraw*\", \\\n  ATTRS{idVendor}==\"256f\", \\\n  TAG+=\"uaccess\"",
       }) {
    machine.write("/etc/udev/rules.d/70-a.rules", line);
    ASSERT_TRUE(find()) << line;
    EXPECT_EQ(find()->name(), "70-a.rules");
    EXPECT_FALSE(find()->has_capital_digits) << line;
  }
}

TEST_F(UdevRules, OfOthersOrWithoutRightsAreNoneForIt) {
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

TEST_F(UdevRules, HideThoseOfTheSameNameInLaterFolders) {
  machine.write("/usr/lib/udev/rules.d/70-a.rules", "SUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"256f\", TAG+=\"uaccess\"");
  machine.write("/etc/udev/rules.d/70-a.rules", "");
  EXPECT_FALSE(find());
}

TEST_F(UdevRules, WithCapitalDigitsOrTooLateAreToldFromGoodOnes) {
  machine.write("/etc/udev/rules.d/99-a.rules", "SUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"256F\", TAG+=\"uaccess\"");
  EXPECT_TRUE(find()->has_capital_digits);
  machine.write("/etc/udev/rules.d/99-a.rules", "SUBSYSTEM==\"hidraw\", ATTRS{idVendor}==\"256f\", TAG+=\"uaccess\"");
  EXPECT_FALSE(find()->has_capital_digits);
  EXPECT_TRUE(find()->is_too_late());
}

TEST_F(UdevRules, AreAddedByALineThatIsFoundAgain) {
  const std::string line = line_that_adds_rule(device, DevicePath::hidraw);
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
