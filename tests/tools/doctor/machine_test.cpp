#include "tools/doctor/machine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/doctor/fake_machine.h"

namespace hapton::doctor {
namespace {

using ::testing::ElementsAre;

TEST(Machine, ReadsFilesBelowItsRoot) {
  const FakeMachine fake;
  fake.write("/sys/thing", "  7.5 \n\n");
  fake.write("/sys/bytes", std::string("a\0b", 3));
  const Machine machine = fake.make();
  EXPECT_EQ(machine.read("/sys/thing"), "  7.5");
  EXPECT_EQ(machine.read_number("/sys/thing"), 7.5);
  EXPECT_EQ(machine.read_bytes("/sys/bytes"), std::string("a\0b", 3));
  EXPECT_EQ(machine.read("/sys/nothing"), std::nullopt);
  EXPECT_EQ(machine.read("/sys"), std::nullopt);
  EXPECT_EQ(machine.read_number("/proc/version"), std::nullopt);
  EXPECT_THAT(machine.list("/sys/class/hidraw"), ElementsAre("hidraw0", "hidraw1"));
  EXPECT_TRUE(machine.list("/nowhere").empty());
  EXPECT_FALSE(machine.list("/").empty());
}

TEST(Machine, FollowsLinksWithoutLeavingItsRoot) {
  const FakeMachine fake;
  const Machine machine = fake.make();
  EXPECT_EQ(machine.real_path("/sys/class/hidraw/hidraw0"), "/sys/devices/usb1/1-1/1-1:1.0/hidraw0/hidraw/hidraw0");
  EXPECT_EQ(machine.link_name("/sys/class/hidraw/hidraw0/device/driver"), "hid-generic");
  EXPECT_EQ(machine.real_path("/sys/nothing"), "");
  EXPECT_EQ(machine.link_name("/proc/version"), "");
}

TEST(Machine, KnowsTheUserAndItsGroups) {
  const FakeMachine fake;
  fake.set_user(4321, "7001 7002", "0000000000800000");
  fake.write("/etc/group", "hapton:x:7001:\nplugdev:x:46:ada,bob\naudio:x:63:bob\nbroken\n");
  const Machine machine = fake.make();
  EXPECT_EQ(machine.user().uid, 4321U);
  EXPECT_EQ(machine.user().name, "ada");
  EXPECT_TRUE(machine.user().is_in(7777));
  EXPECT_TRUE(machine.user().is_in(7002));
  EXPECT_FALSE(machine.user().is_in(46));
  EXPECT_TRUE(machine.user().has_capability(User::kSysNice));
  EXPECT_FALSE(machine.user().has_capability(User::kIpcLock));
  EXPECT_TRUE(machine.find_group("hapton")->has_user);   // in the groups of this session
  EXPECT_TRUE(machine.find_group("plugdev")->has_user);  // in /etc/group
  EXPECT_FALSE(machine.find_group("audio")->has_user);
  EXPECT_FALSE(machine.find_group("wheel"));
}

TEST(Machine, ChecksRightsByOwnerGroupAndOthers) {
  const FakeMachine fake;
  const auto may_use = [&](mode_t mode) {
    fake.write("/dev/thing", "", mode);
    return fake.make().may_use("/dev/thing");
  };
  EXPECT_TRUE(may_use(0660));
  EXPECT_FALSE(may_use(0640));
  EXPECT_FALSE(may_use(0606));  // a member of the group is not among the others
  fake.set_user(fake.another_uid(), "7001");
  EXPECT_FALSE(may_use(0660));
  EXPECT_TRUE(may_use(0606));
  EXPECT_FALSE(fake.make().may_use("/dev/nothing"));
}

TEST(Machine, SeesProcessesAndTheEnvironment) {
  const FakeMachine fake;
  fake.set_environment(std::string("A=1\0HOME=/home/ada\0EMPTY=\0", 26));
  const Machine machine = fake.make();
  EXPECT_EQ(machine.find_process("io_node"), 77);
  EXPECT_FALSE(machine.find_process("sofa"));
  EXPECT_EQ(machine.environment("HOME"), "/home/ada");
  EXPECT_EQ(machine.environment("A"), "1");
  EXPECT_EQ(machine.environment("EMPTY"), "");
  EXPECT_EQ(machine.environment("OM"), "");
}

TEST(Words, AreCutFromLines) {
  EXPECT_THAT(split_words("  a\tb  c "), ElementsAre("a", "b", "c"));
  EXPECT_THAT(split_lines("a\n\nb"), ElementsAre("a", "", "b"));
  EXPECT_EQ(find_field("Uid:\t1 2\nGid:\t3\n", "Gid:"), "3");
  EXPECT_EQ(find_field("Uid:\t1\n", "Gid:"), "");
}

}  // namespace
}  // namespace hapton::doctor
