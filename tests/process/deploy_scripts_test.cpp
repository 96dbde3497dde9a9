// If something is missing or fails, the scripts of deploy/ say why.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "tests/process/program.h"

namespace hapton::process {
namespace {

using ::testing::HasSubstr;

// Runs a copy of a script in a temporary tree, with programs that stand in for those of the system.
class DeployScript : public ::testing::Test {
 protected:
  void copy_script(const std::string& script) {
    std::filesystem::create_directories(folder_.path() / "deploy");
    std::filesystem::copy_file(std::filesystem::path(HAPTON_SOURCE_DIR "/deploy") / script, folder_.path() / "deploy" / script);
  }
  // name: "bin/PROGRAM", which the script finds first, or "deploy/SCRIPT".
  void stand_in(const std::string& name, const std::string& commands) {
    const std::filesystem::path path = folder_.path() / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << "#!/bin/bash\n" << commands << '\n';
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  }
  std::optional<Ended> run_script(const std::string& words) {
    const std::string folder = folder_.path().string();
    return run("/bin/bash", {"-c", "export PATH='" + folder + "/bin':\"$PATH\"; exec '" + folder + "/deploy/'" + words}, folder_.path());
  }

  TestFolder folder_;
};

// `grep` fails if no step failed, and `head` ends before it has read all of a long output. Either of them once ended the script
// (pipefail) without a message.
TEST_F(DeployScript, BuildSaysWhyItFailsWithoutAFailedStepAndWithALongOne) {
  copy_script("build");
  stand_in("deploy/setup", "exit 0");
  struct Failure {
    const char* commands;
    const char* expected_text;
  };
  for (const Failure& failure : {Failure{"echo \"ninja: error: unknown target 'nonsense'\"", "unknown target 'nonsense'\n"},
                                 Failure{"echo 'FAILED: part.o'; seq 20000", "FAILED: part.o\n1\n"}}) {
    stand_in("bin/cmake", std::string("if [[ $1 == --build ]]; then ") + failure.commands + "; exit 1; fi");
    const auto ended = run_script("build nonsense");
    ASSERT_TRUE(ended) << "still runs";
    EXPECT_EQ(ended->exit_code, 1);
    EXPECT_THAT(ended->err, HasSubstr(failure.expected_text));
    EXPECT_THAT(ended->err, HasSubstr("build: preset 'release' does not build"));
  }
}

// apt-cache fails if it does not know the package.
TEST_F(DeployScript, HidTestIsSkippedWithoutListsOfPackages) {
  copy_script("hid-test");
  stand_in("bin/uname", "echo x86_64");
  for (const char* program : {"qemu-system-x86_64", "cpio", "busybox", "udevadm", "apt-get", "dpkg-deb"})
    stand_in(std::string("bin/") + program, "exit 0");
  stand_in("bin/apt-cache", "exit 100");
  const auto ended = run_script("hid-test --fetch-only");
  ASSERT_TRUE(ended) << "still runs";
  EXPECT_EQ(ended->exit_code, 77) << ended->err;
  EXPECT_THAT(ended->out, HasSubstr("skipped: no package source here knows linux-image-amd64"));
}

}  // namespace
}  // namespace hapton::process
