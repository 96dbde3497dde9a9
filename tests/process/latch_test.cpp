// Only a person resets a latched fault: neither a crash nor a new start of io_node resets it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/process/program.h"
#include "tests/process/system.h"
#include "tests/standins/paths.h"

namespace hapton::process {
namespace {

using testing::HasSubstr;
using testing::Not;

// A device that does not move and, if requested, jumps by 50 mm once, after half a second.
void write_trajectory(const std::filesystem::path& path, bool jumps) {
  std::ofstream file(path);
  file << "t_s,x_m,y_m,z_m\n";
  for (int n = 0; n < 60'000; ++n) file << 0.001 * n << "," << (jumps && n >= 500 ? 0.05 : 0.0) << ",0,0\n";
}

struct Latched : testing::Test {
  TestFolder folder;
  std::string hub = "127.0.0.1:" + find_free_port();

  Program start(const std::string& trajectory) {
    return Program("io_node",
                   {"--bind", hub, "--rt", "off", "--watchdog", "off", "--max-speed", "1", "--device", "replay", "--trajectory",
                    (folder.path() / trajectory).string()},
                   folder.path());
  }
  bool says(const Program& program, const std::string& text) {
    return System::wait_until([&] { return program.err().find(text) != std::string::npos; });
  }
  // True if a latched fault is saved in the runtime folder, which is the test's own.
  bool has_saved_fault() const {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path())) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with("latched-") && !name.ends_with(".part")) return true;
    }
    return false;
  }
  int reset() { return run("hapton", {"set", "--hub", hub, "--reset-faults"}, folder.path()).value_or(Ended{}).exit_code; }
};

TEST_F(Latched, OutlivesTheProcessUntilItIsReset) {
  write_trajectory(folder.path() / "jumps.csv", true);
  write_trajectory(folder.path() / "rests.csv", false);
  const std::string kLatched = "fault latched, no force";
  const std::string kNotReset = "a fault latched before this start has not been reset: the device's position jumped";
  {
    Program io = start("jumps.csv");
    ASSERT_TRUE(says(io, kLatched)) << io.err();
    EXPECT_THAT(io.err(), Not(HasSubstr(kNotReset)));
    ASSERT_TRUE(System::wait_until([&] { return has_saved_fault(); })) << "no fault is kept in " << folder.path();
    io.kill();
  }
  for (const bool resets : {false, true}) {
    Program io = start("rests.csv");
    ASSERT_TRUE(says(io, kNotReset)) << io.err();
    ASSERT_TRUE(says(io, "info  real time"));
    if (resets) {
      EXPECT_EQ(reset(), 0) << io.err();
      EXPECT_TRUE(says(io, "fault reset (jump)")) << io.err();
    }
    io.send_signal(SIGTERM);
    ASSERT_TRUE(io.wait(kPatience));
  }
  Program io = start("rests.csv");
  ASSERT_TRUE(says(io, "info  real time"));
  EXPECT_THAT(io.err(), Not(HasSubstr(kNotReset)));
}

// The other device runs on when one has failed for good. If the process is then killed, systemd starts it again; if it ends by itself with
// this exit code, systemd does not.
TEST_F(Latched, ADeviceThatFailedForGoodHasNoForceAfterACrashOfTheOthers) {
  const std::string left = "plugin:" + standin::library("plugins/odd_device.so") + ":does=fault,after=500";
  std::ofstream(folder.path() / "devices.toml")
      << "[[device]]\nname = \"left\"\ndevice = \"" << left << "\"\nbind = \"" << hub
      << "\"\n[[device]]\nname = \"right\"\ndevice = \"simulated\"\nbind = \"127.0.0.1:" << find_free_port() << "\"\n";
  const std::string kNotReset = "a fault latched before this start has not been reset: the device stopped replying";
  for (const bool is_killed : {true, false}) {
    Program io("io_node", {"--devices", (folder.path() / "devices.toml").string(), "--rt", "off", "--watchdog", "off"}, folder.path());
    ASSERT_TRUE(says(io, "stopped replying; check its cable")) << io.err();
    EXPECT_EQ(io.err().find(kNotReset) == std::string::npos, is_killed) << io.err();
    ASSERT_TRUE(System::wait_until([&] { return has_saved_fault(); })) << "no fault is kept in " << folder.path();
    if (is_killed) {
      io.kill();
      continue;
    }
    io.send_signal(SIGTERM);
    const auto ended = io.wait(kPatience);
    ASSERT_TRUE(ended);
    EXPECT_EQ(ended->exit_code, 3);
    EXPECT_FALSE(has_saved_fault()) << "the next start is a person's";
  }
}

}  // namespace
}  // namespace hapton::process
