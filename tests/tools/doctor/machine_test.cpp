#include "tools/doctor/machine.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

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

TEST(Machine, ResolvesLinksBelowItsRoot) {
  const FakeMachine fake;
  const Machine machine = fake.make();
  EXPECT_EQ(machine.real_path("/sys/class/hidraw/hidraw0"), "/sys/devices/usb1/1-1/1-1:1.0/hidraw0/hidraw/hidraw0");
  EXPECT_EQ(machine.link_name("/sys/class/hidraw/hidraw0/device/driver"), "hid-generic");
  EXPECT_EQ(machine.real_path("/sys/nothing"), "");
  EXPECT_EQ(machine.link_name("/proc/version"), "");
}

TEST(Machine, KnowsTheUserAndItsGroups) {
  constexpr uid_t kUid = 4321;
  constexpr gid_t kPrimaryGid = 7777;  // FakeMachine::set_user
  constexpr gid_t kHaptonGid = 7001;
  constexpr gid_t kUnnamedGid = 7002;  // not in /etc/group
  constexpr gid_t kPlugdevGid = 46;
  const FakeMachine fake;
  fake.set_user(kUid, fmt::format("{} {}", kHaptonGid, kUnnamedGid), fmt::format("{:016x}", 1U << User::kSysNice));
  fake.write("/etc/group", fmt::format("hapton:x:{}:\nplugdev:x:{}:ada,bob\naudio:x:63:bob\nbroken\n", kHaptonGid, kPlugdevGid));
  const Machine machine = fake.make();
  EXPECT_EQ(machine.user().uid, kUid);
  EXPECT_EQ(machine.user().name, "ada");
  EXPECT_TRUE(machine.user().is_in(kPrimaryGid));
  EXPECT_TRUE(machine.user().is_in(kHaptonGid));
  EXPECT_TRUE(machine.user().is_in(kUnnamedGid));
  EXPECT_FALSE(machine.user().is_in(kPlugdevGid)) << "not in this session";
  EXPECT_TRUE(machine.user().has_capability(User::kSysNice));
  EXPECT_FALSE(machine.user().has_capability(User::kIpcLock));
  const auto hapton = machine.find_group("hapton");
  ASSERT_TRUE(hapton);
  EXPECT_EQ(hapton->gid, kHaptonGid);
  EXPECT_TRUE(hapton->has_user) << "in the groups of this session";
  const auto plugdev = machine.find_group("plugdev");
  ASSERT_TRUE(plugdev);
  EXPECT_EQ(plugdev->gid, kPlugdevGid);
  EXPECT_TRUE(plugdev->has_user) << "in /etc/group";
  const auto audio = machine.find_group("audio");
  ASSERT_TRUE(audio);
  EXPECT_FALSE(audio->has_user);
  EXPECT_FALSE(machine.find_group("wheel"));
  EXPECT_FALSE(machine.find_group("broken"));
}

TEST(Machine, ChecksRightsByOwnerGroupAndOthers) {
  const FakeMachine fake;
  const auto may_use = [&](mode_t mode) {
    fake.write("/dev/thing", "", mode);
    return fake.make().may_use("/dev/thing");
  };
  EXPECT_TRUE(may_use(0660));
  EXPECT_FALSE(may_use(0640));
  EXPECT_FALSE(may_use(0606));                // a member of the group is not among the others
  fake.set_user(fake.another_uid(), "7001");  // a group that the file does not have
  EXPECT_FALSE(may_use(0660));
  EXPECT_TRUE(may_use(0606));
  EXPECT_FALSE(fake.make().may_use("/dev/nothing"));
}

TEST(Machine, SeesProcessesAndTheEnvironment) {
  const FakeMachine fake;
  using namespace std::string_literals;
  fake.set_environment("A=1\0HOME=/home/ada\0EMPTY=\0"s);
  const Machine machine = fake.make();
  EXPECT_EQ(machine.find_process("io_node"), 77);
  EXPECT_FALSE(machine.find_process("sofa"));
  EXPECT_EQ(machine.environment("HOME"), "/home/ada");
  EXPECT_EQ(machine.environment("A"), "1");
  EXPECT_EQ(machine.environment("EMPTY"), "");
  EXPECT_EQ(machine.environment("OM"), "") << "part of a name";
}

TEST(Words, AreCutFromLines) {
  EXPECT_THAT(split_words("  a\tb  c "), ElementsAre("a", "b", "c"));
  EXPECT_THAT(split_lines("a\n\nb"), ElementsAre("a", "", "b"));
  EXPECT_EQ(find_field("Uid:\t1 2\nGid:\t3\n", "Gid:"), "3");
  EXPECT_EQ(find_field("Uid:\t1\n", "Gid:"), "");
}

}  // namespace
}  // namespace hapton::doctor
