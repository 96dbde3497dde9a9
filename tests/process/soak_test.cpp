// A minute of soak, as in CI: whole programs, observed from outside.
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <system_error>

#include "tests/process/program.h"

namespace hapton::process {
namespace {

using Json = nlohmann::json;

// A sanitizer keeps freed memory and records accesses: memory then grows without a leak.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kCanCheckMemory = false;
#else
constexpr bool kCanCheckMemory = true;
#endif

// Rate and drift are not checked here: this machine may be busy.
bool is_checked(const std::string& what) { return what != "rate" && what != "drift" && (what != "memory" || kCanCheckMemory); }

// The process ID of the child with this name; -1 if there is none.
pid_t find_child(pid_t parent, const std::string& name) {
  const std::string parent_line = "\nPPid:\t" + std::to_string(parent) + "\n";
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc", error)) {
    const std::string pid = entry.path().filename().string();
    if (pid.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string status = read_text(entry.path() / "status");
    if (status.starts_with("Name:\t" + name + "\n") && status.find(parent_line) != std::string::npos) return std::stoi(pid);
  }
  return -1;
}

TEST(Soak, AMinuteKeepsMemoryDescriptorsAndThreadsAndLosesNoForce) {
  const TestFolder folder;
  const std::string out = (folder.path() / "soak").string();
  const std::string scene = HAPTON_SOURCE_DIR "/scenes/car_front.toml";
  const auto ended = run("hapton", {"soak", "--seconds", "60", "--scene", scene, "--out", out}, folder.path(), Seconds(240));
  ASSERT_TRUE(ended) << "still runs";
  const Json soak = Json::parse(read_text(folder.path() / "soak" / "soak.json"), nullptr, false);
  ASSERT_TRUE(soak.is_object()) << ended->out << ended->err;
  EXPECT_EQ(soak.at("schema"), "hapton.soak/1");
  EXPECT_EQ(soak.at("looks"), 30);
  EXPECT_EQ(soak.at("counters").at("lost"), 0);
  int checked = 0;
  for (const Json& finding : soak.at("findings")) {
    if (!is_checked(finding.at("what"))) continue;
    ++checked;
    EXPECT_TRUE(finding.at("flat").get<bool>()) << finding;
  }
  EXPECT_EQ(checked, kCanCheckMemory ? 8 : 6);  // the run, lost forces; memory, descriptors and threads of two processes
  EXPECT_EQ(ended->exit_code, soak.at("flat").get<bool>() ? 0 : 1) << ended->err;
  // Part of the run is in contact: a force that is always zero would prove little.
  const std::string table = read_text(folder.path() / "soak" / "soak.csv");
  EXPECT_TRUE(std::regex_search(table, std::regex("\n[0-9.]+,[0-9.]+,[0-9.]+,[1-9][0-9.]*,"))) << table;
}

TEST(Soak, OfANodeThatDiesEndsAtOnceAndSaysWhichOne) {
  const TestFolder folder;
  const std::string out = (folder.path() / "soak").string();
  const std::string scene = HAPTON_SOURCE_DIR "/scenes/car_front.toml";
  Program soak("hapton", {"soak", "--seconds", "200", "--every", "0.5", "--scene", scene, "--out", out}, folder.path());
  // The soak test reports its first sample when the nodes are running.
  const std::regex kFirstProgress("soak: [0-9]+ of 200 s");
  for (int tries = 0; tries < 1200 && !std::regex_search(soak.out(), kFirstProgress) && soak.is_running(); ++tries) {
    (void)soak.wait(Seconds(0.05));
  }
  ASSERT_TRUE(std::regex_search(soak.out(), kFirstProgress)) << soak.out() << soak.err();
  const pid_t node = find_child(soak.pid(), "haptics_node");
  ASSERT_GT(node, 0);
  ASSERT_EQ(::kill(node, SIGKILL), 0);
  const auto ended = soak.wait(Seconds(60));
  ASSERT_TRUE(ended) << "still runs";
  EXPECT_EQ(ended->exit_code, 1);
  EXPECT_NE(ended->out.find("not flat: haptics_node ended with 137"), std::string::npos) << ended->out << ended->err;
}

TEST(Soak, RejectsATimeTooShortForItsSamples) {
  const TestFolder folder;
  const auto ended = run("hapton", {"soak", "--seconds", "12"}, folder.path());
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 2);
  EXPECT_NE(ended->err.find("12 s are too few for 10 observations, one every 2 s"), std::string::npos) << ended->err;
}

}  // namespace
}  // namespace hapton::process
