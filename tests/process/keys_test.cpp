// Keys as people meet them: none given, one named, the wrong one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/process/system.h"

namespace hapton::process {
namespace {

std::string make_key(const System& system, const std::string& name) {
  const std::string path = (system.folder() / name).string();
  const auto made = run("hapton", {"keygen", path}, system.folder());
  EXPECT_TRUE(made && made->exit_code == 0);
  return path;
}

TEST(Keys, WithoutBeingToldNodesOfOneUserShareOne) {
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

TEST(Keys, ANodeWithAnotherOneIsMetWithSilenceAndTheHubSaysSo) {
  System system;
  system.start("io_node");
  system.start("haptics_node");
  ASSERT_TRUE(has_contact(system.wait_for_report(has_contact)));
  Program stranger("haptics_node",
                   {"--hub", system.hub(), "--scene", (system.folder() / "cube.toml").string(), "--key", make_key(system, "other.key")},
                   system.folder());
  const auto is_refused = [](const Json& report) { return count(report, "refused_wrong_key") > 0; };
  const Json refused = system.wait_for_report(is_refused);
  EXPECT_TRUE(is_refused(refused)) << refused;
  EXPECT_EQ(count(refused, "joins_refused"), 0);
  EXPECT_TRUE(System::wait_until([&] { return system["io_node"].err().find("--key FILE") != std::string::npos; }));
  EXPECT_TRUE(System::wait_until([&] { return stranger.err().find("no hub answers") != std::string::npos; }));
  const auto goes_on = [&](const Json& report) { return count(report, "contact_samples") > count(refused, "contact_samples") + 100; };
  EXPECT_TRUE(goes_on(system.wait_for_report(goes_on)));
  stranger.send_signal(SIGTERM);
  const auto ended = stranger.wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 0);
  system.end_all();
}

}  // namespace
}  // namespace hapton::process
