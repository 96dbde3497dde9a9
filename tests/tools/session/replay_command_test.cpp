#include <gtest/gtest.h>

#include <string>

#include "tests/support/scratch_folder.h"
#include "tests/tools/command_run.h"

namespace hapton {
namespace {

// The error comes before the run, which may take minutes, and not after it.
TEST(ReplayCommand, AFolderThatDoesNotExistIsAnErrorBeforeTheRun) {
  const ScratchFolder scratch;
  const std::string mesh = scratch.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::string trajectory = scratch.write("t.csv", "t_s,x_m,y_m,z_m\n0,0.1,0.1,0.1\n0.001,0.1,0.1,0.1\n");
  const std::string folder = scratch.path() / "none";
  const CommandRun without_folder = run_hapton({"replay", "--mesh", mesh, "--trajectory", trajectory, "--out", folder + "/r.csv"});
  EXPECT_EQ(without_folder.code, 1);
  EXPECT_EQ(without_folder.out, "") << "the run has not begun";
  EXPECT_NE(without_folder.err.find("there is no folder " + folder), std::string::npos) << without_folder.err;
  const CommandRun with_folder = run_hapton({"replay", "--mesh", mesh, "--trajectory", trajectory, "--out", scratch.path() / "r.csv"});
  EXPECT_EQ(with_folder.code, 0) << with_folder.err;
  EXPECT_NE(with_folder.out.find("2 steps"), std::string::npos) << with_folder.out;
}

}  // namespace
}  // namespace hapton
