// Keys as users meet them: none given, one named, the wrong one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/process/system.h"

namespace hapton::process {
namespace {

std::string make_key(const System& system, const std::string& name) {
  const std::string path = (system.folder() / name).string();
  const auto made = run("hapton", {"keygen", path}, system.folder());
  EXPECT_TRUE(made && made->exit_code == 0);
  return path;
}

TEST(Keys, ByDefaultNodesOfOneUserShareOne) {
  System system;
  for (const char* node : {"haptics_node", "io_node"}) system.start(node);
  EXPECT_TRUE(has_contact(system.wait_for_report(has_contact)));
  EXPECT_EQ(std::filesystem::status(system.folder() / "hapton" / "master").permissions(), std::filesystem::perms(0600));
  system.end_all();
}

TEST(Keys, ANamedOneIsUsedAndNoOtherMade) {
  System system;
  const std::string key = make_key(system, "our.key");
  for (const char* node : {"haptics_node", "io_node"}) {
    system.add_arguments(node, {"--key", key});
    system.start(node);
  }
  EXPECT_TRUE(has_contact(system.wait_for_report(has_contact)));
  EXPECT_FALSE(std::filesystem::exists(system.folder() / "hapton"));
  system.end_all();
}

std::string make_role_key(const System& system, const std::string& role, const std::string& master) {
  const std::string path = (system.folder() / (role + ".key")).string();
  const auto made = run("hapton", {"keygen", "--role", role, "--master", master, path}, system.folder());
  EXPECT_TRUE(made && made->exit_code == 0);
  return path;
}

TEST(Keys, EachRoleHasItsOwnAndTheHubTheMaster) {
  System system;
  const std::string master = make_key(system, "our.key");
  system.add_arguments("io_node", {"--key", master});
  system.add_arguments("haptics_node", {"--key", make_role_key(system, "haptics", master)});
  for (const char* node : {"io_node", "haptics_node"}) system.start(node);
  EXPECT_TRUE(has_contact(system.wait_for_report(has_contact)));
  const auto set = [&](const std::string& key, const std::vector<std::string>& what) {
    std::vector<std::string> arguments = {"set", "--hub", system.hub(), "--key", key};
    arguments.insert(arguments.end(), what.begin(), what.end());
    return run("hapton", arguments, system.folder());
  };
  const std::string tool = make_role_key(system, "tool", master);
  const auto rate = set(tool, {"--rate", "800"});
  ASSERT_TRUE(rate);
  EXPECT_EQ(rate->exit_code, 0) << rate->err;
  const auto reset = set(tool, {"--reset-faults"});
  ASSERT_TRUE(reset);
  EXPECT_EQ(reset->exit_code, 1);
  EXPECT_THAT(reset->err, ::testing::HasSubstr("is the key of role tool, and this needs that of role operator"));
  const auto by_operator = set(make_role_key(system, "operator", master), {"--reset-faults"});
  ASSERT_TRUE(by_operator);
  EXPECT_EQ(by_operator->exit_code, 0) << by_operator->err;
  system.end_all();
}

TEST(Keys, AKeyOfAnotherRoleOrOfAnOlderVersionIsRejectedInALine) {
  System system;
  const std::string master = make_key(system, "our.key");
  const std::string vision = make_role_key(system, "vision", master);
  const auto old = system.folder() / "old.key";
  std::ofstream(old) << "thirty-two bytes of an older key";
  std::filesystem::permissions(old, std::filesystem::perms(0600));
  const auto rejection = [&](const std::string& program, const std::string& key) {
    const auto ended = run(program, {"--key", key, "--seconds", "0.1"}, system.folder());
    EXPECT_TRUE(ended && ended->exit_code == 1);
    return ended ? ended->err : std::string();
  };
  EXPECT_THAT(rejection("io_node", vision), ::testing::HasSubstr("the hub needs the master key"));
  EXPECT_THAT(rejection("haptics_node", vision), ::testing::HasSubstr("is the key of role vision"));
  for (const char* program : {"io_node", "haptics_node"}) {
    EXPECT_THAT(rejection(program, old.string()), ::testing::HasSubstr("is a key of an older Hapton"));
  }
}

TEST(Keys, ANodeWithAnotherOneGetsNoReplyAndTheHubSaysSo) {
  System system;
  system.start("io_node");
  system.start("haptics_node");
  ASSERT_TRUE(has_contact(system.wait_for_report(has_contact)));
  Program unknown("haptics_node",
                  {"--hub", system.hub(), "--scene", (system.folder() / "cube.toml").string(), "--key", make_key(system, "other.key")},
                  system.folder());
  const auto is_rejected = [](const Json& report) { return count(report, "rejected_wrong_key") > 0; };
  const Json rejected = system.wait_for_report(is_rejected);
  EXPECT_TRUE(is_rejected(rejected)) << rejected;
  EXPECT_EQ(count(rejected, "joins_rejected"), 0);
  EXPECT_TRUE(System::wait_until([&] { return system["io_node"].err().find("hapton keygen --role ROLE") != std::string::npos; }));
  EXPECT_TRUE(System::wait_until([&] { return unknown.err().find("no reply from a hub") != std::string::npos; }));
  const auto goes_on = [&](const Json& report) { return count(report, "contact_samples") > count(rejected, "contact_samples") + 100; };
  EXPECT_TRUE(goes_on(system.wait_for_report(goes_on)));
  unknown.send_signal(SIGTERM);
  const auto ended = unknown.wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 0);
  system.end_all();
}

}  // namespace
}  // namespace hapton::process
