// A rigid tool in the real programs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tests/process/program.h"
#include "tests/process/system.h"
#include "tests/process/trajectory_session.h"
#include "tests/support/scratch_folder.h"

namespace hapton::process {
namespace {

using ::testing::HasSubstr;

// With --loop the hand repeats its motion: on a busy machine haptics_node may join while the tool already overlaps the scene and gives no
// force, or while the button is already pressed; the next round is felt then.

// The peg moves down, half over the edge of a block, where it is pressed and tilts, and back up.
TEST(Tool, IsFeltRecordedAndReportedWithItsTorque) {
  TrajectorySession session("simulated-6dof",
                            "t_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,0,0.014,0.06,0.99995,0.01,0,0\n1,0,0.014,0.024,0.99995,0.01,0,0\n"
                            "4,0,0.014,0.024,0.99995,0.01,0,0\n5,0,0.014,0.06,0.99995,0.01,0,0\n",
                            "pegs.toml", {"--loop"});
  EXPECT_TRUE(session.wait_for_note_above("max_torque_written_nm", 0.001));
  EXPECT_THAT(session.end(), HasSubstr("pose of the tool: p50"));
  const std::string table = (session.scratch.path() / "table").string();
  const Ended exported =
      run("hapton", {"session", "export", session.file, "--format", "csv", "--out", table}, session.scratch.path()).value_or(Ended{});
  EXPECT_EQ(exported.exit_code, 0) << exported.err;
  EXPECT_THAT(read_text(session.scratch.path() / "table" / "session.csv"), HasSubstr("wanted_tx_nm"));
  const Ended replayed = session.replay();
  EXPECT_EQ(replayed.exit_code, 1);
  EXPECT_THAT(replayed.err, HasSubstr("hapton replay --tool"));
}

// The peg is pressed onto a block; meanwhile `hapton set` makes all materials softer and rougher.
TEST(Tool, ItsMaterialsAreTunedWhileItIsPressed) {
  TrajectorySession session("simulated-6dof", "t_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,0,0.014,0.06,1,0,0,0\n1,0,0.014,0.024,1,0,0,0\n",
                            "pegs.toml");
  EXPECT_TRUE(session.wait_for_note_above("max_force_written_n", 0.5));
  const Ended tuned =
      run("hapton", {"set", "--hub", session.hub, "--stiffness", "300", "--friction-static", "0.5", "--friction-dynamic", "0.4"},
          session.scratch.path())
          .value_or(Ended{});
  EXPECT_EQ(tuned.exit_code, 0) << tuned.err;
  EXPECT_TRUE(System::wait_until([&] { return session.haptics.err().find("stiffness 300 N/m") != std::string::npos; }))
      << session.haptics.err();
  session.end();
  const Ended info = run("hapton", {"session", "info", session.file}, session.scratch.path()).value_or(Ended{});
  EXPECT_EQ(info.exit_code, 0) << info.err;
  EXPECT_THAT(info.out, HasSubstr("name=tool stiffness_n_per_m=300 "));
}

// A peg is picked up from above, lifted, put into its hole, and touched there.
TEST(Tool, AnObjectIsPickedUpAndPutDownByAButton) {
  TrajectorySession session(
      "simulated-6dof",
      "t_s,x_m,y_m,z_m,buttons\n0,-0.026,0.0205,0.05,0\n0.5,-0.026,0.0205,0.024,0\n1,-0.026,0.0205,0.024,1\n2,-0.026,0.0205,0.065,1\n"
      "3,-0.026,-0.0145,0.065,1\n4,-0.026,-0.0145,0.035,1\n6,-0.026,-0.0145,0.018,1\n6.5,-0.026,-0.0145,0.018,0\n8,-0.026,-0.0145,0.065,"
      "0\n8.5,-0.026,0.0205,0.05,0\n",
      "workbench.toml", {"--loop"});
  EXPECT_TRUE(System::wait_until([&] { return session.haptics.err().find("left peg is put down") != std::string::npos; }))
      << session.haptics.err();
  EXPECT_THAT(session.haptics.err(), HasSubstr("left peg is picked up"));
  EXPECT_THAT(session.end(), HasSubstr("pose of held objects: p50"));
  const Ended replayed = session.replay();
  EXPECT_EQ(replayed.exit_code, 1) << "when the slow task was done is not recorded";
  EXPECT_THAT(replayed.err, HasSubstr("the stylus held a rigid tool"));
}

}  // namespace
}  // namespace hapton::process
