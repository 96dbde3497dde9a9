// What `hapton dds` refuses: one line on stderr, exit code 1, and nothing is published.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/process/system.h"
#include "tests/support/scratch_folder.h"

namespace hapton::process {
namespace {

using ::testing::HasSubstr;

void expect_refusal(std::vector<std::string> arguments, const std::string& says) {
  const ScratchFolder scratch;
  arguments.insert(arguments.begin(), "dds");
  const auto ended = run("hapton", arguments, scratch.path());
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 1);
  EXPECT_THAT(ended->err, HasSubstr(says));
  EXPECT_EQ(std::count(ended->err.begin(), ended->err.end(), '\n'), 1) << ended->err;
  EXPECT_EQ(ended->out, "");
}

TEST(DdsRefusals, NamesThatRos2DoesNotTake) {
  for (const char* prefix : {"", "/", "//a", "/a/", "a//b", "9a", "a b", "a__b", "a-b", "~/a", "/{x}", "\"/><x", "\xff\n"}) {
    expect_refusal({"--prefix", prefix}, "is not a name in ROS 2");
  }
  expect_refusal({"--prefix", std::string(300, 'a')}, "is not a name in ROS 2");
  for (const char* frame : {"", "/world", "my world", "a\nb", "\xc3\xa4"}) expect_refusal({"--frame", frame}, "is not a frame in ROS 2");
}

TEST(DdsRefusals, DomainsThatDoNotExist) {
  expect_refusal({"--domain", "233"}, "--domain 233 does not exist");
  expect_refusal({"--domain", "-1"}, "--domain -1 does not exist");
  for (const char* text : {"two", "5x", "233", "-1", "99999999999999999999", " 3"}) {
    ::setenv("ROS_DOMAIN_ID", text, 1);
    expect_refusal({}, "ROS_DOMAIN_ID");
  }
  ::unsetenv("ROS_DOMAIN_ID");
}

TEST(DdsRefusals, InvalidInterfaces) {
  expect_refusal({"--interface", "\"/><Tracing/>"}, "is not a network interface");
  expect_refusal({"--interface", "a b"}, "is not a network interface");
}

TEST(DdsRefusals, ForcesWithoutASensibleLimit) {
  const ScratchFolder scratch;
  for (const char* limit : {"-1", "nan", "inf", "1e9", "much"}) {
    const auto ended = run("hapton", {"dds", "--accept-forces", limit}, scratch.path());
    ASSERT_TRUE(ended);
    EXPECT_NE(ended->exit_code, 0) << limit;
    EXPECT_THAT(ended->err, HasSubstr("--accept-forces"));
  }
}

#ifdef HAPTON_WITH_DDS

TEST(DdsRefusals, AnInterfaceThatThisHostLacks) {
  expect_refusal({"--interface", "nosuch0"}, "no DDS domain 0 on network interface nosuch0");
}

TEST(DdsRefusals, NoHub) { expect_refusal({"--hub", "127.0.0.1:" + find_free_port()}, "no reply from a hub"); }

TEST(DdsRefusals, AnInvalidKeyFile) {
  const ScratchFolder scratch;
  const std::filesystem::path file = scratch.write("key", "short");
  std::filesystem::permissions(file, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  expect_refusal({"--key", file.string()}, file.string() + ": has 5 bytes, but a key file has 48");
}

TEST(DdsRefusals, AnotherKeyThanTheHubs) {
  System system;
  system.start("io_node");
  ASSERT_TRUE(System::wait_until([&] { return system["io_node"].out().starts_with("hub on "); }));
  const std::string key = (system.folder() / "other.key").string();
  ASSERT_TRUE(make_key_file(key));
  expect_refusal({"--hub", system.hub(), "--key", key}, "no reply from a hub");
  system.end_all();
}

TEST(DdsRefusals, ForcesBesideAHapticsNode) {
  System system;
  system.start("io_node");
  system.start("haptics_node");
  ASSERT_TRUE(has_contact(system.wait_for_report(has_contact)));
  // In the system's folder, where its key is.
  const auto ended = run("hapton", {"dds", "--hub", system.hub(), "--accept-forces", "1"}, system.folder());
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 1);
  EXPECT_THAT(ended->err, HasSubstr("has a haptics node already"));
  system.end_all();
}

#else

TEST(DdsRefusals, WithoutDdsItSaysWhatToInstall) { expect_refusal({}, "install cyclonedds-dev and cyclonedds-tools"); }

#endif

}  // namespace
}  // namespace hapton::process
