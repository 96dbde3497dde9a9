// The doctor uses colours only on a terminal, and only if the user has not declined them (NO_COLOR).
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/scratch_folder.h"
#include "tests/tools/command_run.h"

namespace hapton {
namespace {

constexpr const char* kColour = "\x1b[";

// Sets NO_COLOR to `value` while this object exists; without a value, it unsets NO_COLOR.
class NoColorVariable {
 public:
  explicit NoColorVariable(const std::optional<std::string>& value) {
    if (const char* was_set = std::getenv("NO_COLOR"); was_set != nullptr) previous_ = was_set;
    set(value);
  }
  ~NoColorVariable() { set(previous_); }
  NoColorVariable(const NoColorVariable&) = delete;
  NoColorVariable& operator=(const NoColorVariable&) = delete;

 private:
  static void set(const std::optional<std::string>& value) { value ? ::setenv("NO_COLOR", value->c_str(), 1) : ::unsetenv("NO_COLOR"); }
  std::optional<std::string> previous_;
};

struct DoctorColours : testing::Test {
  DoctorColours() {
    const std::filesystem::path clock = folder.path() / "sys/devices/system/clocksource/clocksource0";
    std::filesystem::create_directories(clock);
    std::ofstream(clock / "current_clocksource") << "hpet\n";
    arguments = {"hapton", "doctor", "--root", folder.path().string(), "--only", "clock"};
  }
  // What the command prints on a terminal.
  std::string output_on_terminal() {
    const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY);
    if (terminal < 0 || ::grantpt(terminal) != 0 || ::unlockpt(terminal) != 0) return "no terminal";
    const int pty_line = ::open(::ptsname(terminal), O_RDWR | O_NOCTTY);
    std::fflush(stdout);
    const int saved_stdout = ::dup(STDOUT_FILENO);
    ::dup2(pty_line, STDOUT_FILENO);
    std::vector<const char*> argv;
    for (const std::string& word : arguments) argv.push_back(word.c_str());
    EXPECT_EQ(run_hapton_command(static_cast<int>(argv.size()), argv.data()), 1);
    std::fflush(stdout);
    ::dup2(saved_stdout, STDOUT_FILENO);
    ::close(saved_stdout);
    std::array<char, 4096> read = {};
    const ssize_t count = ::read(terminal, read.data(), read.size());
    ::close(pty_line);
    ::close(terminal);
    return {read.data(), static_cast<std::size_t>(count > 0 ? count : 0)};
  }
  std::string output_in_file() { return run_hapton({arguments.begin() + 1, arguments.end()}).out; }

  ScratchFolder folder;
  std::vector<std::string> arguments;
};

TEST_F(DoctorColours, AreForATerminalAlone) {
  const NoColorVariable unset(std::nullopt);
  EXPECT_THAT(output_on_terminal(), testing::AllOf(testing::HasSubstr(kColour), testing::HasSubstr("fix: ")));
  EXPECT_THAT(output_in_file(), testing::AllOf(testing::Not(testing::HasSubstr(kColour)), testing::HasSubstr("fix: ")));
}

TEST_F(DoctorColours, CanBeDeclined) {
  const NoColorVariable set("1");
  EXPECT_THAT(output_on_terminal(), testing::AllOf(testing::Not(testing::HasSubstr(kColour)), testing::HasSubstr("fix: ")));
  EXPECT_THAT(output_in_file(), testing::Not(testing::HasSubstr(kColour)));
}

}  // namespace
}  // namespace hapton
