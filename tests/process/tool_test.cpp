// A rigid tool in the real programs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tests/process/program.h"
#include "tests/process/system.h"
#include "tests/support/scratch_folder.h"

namespace hapton::process {
namespace {

using ::testing::HasSubstr;

// The peg goes half over the edge of a block, where it is pressed and tilts, and stays there.
TEST(Tool, IsFeltRecordedAndReportedWithItsTorque) {
  ScratchFolder scratch;
  scratch.write("way.csv",
                "t_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,0,0.014,0.06,0.99995,0.01,0,0\n1,0,0.014,0.024,0.99995,0.01,0,0\n"
                "20,0,0.014,0.024,0.99995,0.01,0,0\n");
  const std::string hub = "127.0.0.1:" + find_free_port();
  const std::string file = (scratch.path() / "tool.hapton").string();
  Program io("io_node",
             {"--bind", hub, "--device", "simulated-6dof", "--trajectory", (scratch.path() / "way.csv").string(), "--record", file, "--out",
              (scratch.path() / "out").string()},
             scratch.path());
  Program haptics("haptics_node", {"--hub", hub, "--scene", HAPTON_SOURCE_DIR "/scenes/pegs.toml"}, scratch.path());
  const auto report = [&] {
    io.send_signal(SIGUSR1);
    return Json::parse(read_text(scratch.path() / "out" / "report.json"), nullptr, false);
  };
  ASSERT_TRUE(System::wait_until([&] { return io.out().find("hub on ") != std::string::npos || !io.is_running(); }));
  EXPECT_TRUE(System::wait_until([&] {
    const Json now = report();
    return now.is_object() && std::stod(now.at("notes").at("max_torque_written_nm").get<std::string>()) > 0.001;
  })) << haptics.err()
      << io.err();
  for (Program* program : {&haptics, &io}) {
    program->send_signal(SIGTERM);
    const auto ended = program->wait(kPatience);
    ASSERT_TRUE(ended);
    EXPECT_EQ(ended->exit_code, 0) << ended->err;
    if (program == &haptics) {
      EXPECT_THAT(ended->out, HasSubstr("pose of the tool: p50"));
    }
  }
  const Ended exported =
      run("hapton", {"session", "export", file, "--format", "csv", "--out", (scratch.path() / "table").string()}, scratch.path())
          .value_or(Ended{});
  EXPECT_EQ(exported.exit_code, 0) << exported.err;
  EXPECT_THAT(read_text(scratch.path() / "table" / "session.csv"), HasSubstr("wanted_tx_nm"));
  const Ended replayed = run("hapton", {"session", "replay", file}, scratch.path()).value_or(Ended{});
  EXPECT_EQ(replayed.exit_code, 1);
  EXPECT_THAT(replayed.err, HasSubstr("hapton replay --tool"));
}

// Picked up from above, lifted, put into its hole, and touched there.
TEST(Tool, AnObjectIsPickedUpAndPutDownByAButton) {
  ScratchFolder scratch;
  scratch.write(
      "way.csv",
      "t_s,x_m,y_m,z_m,buttons\n0,-0.026,0.0205,0.05,0\n0.5,-0.026,0.0205,0.024,0\n1,-0.026,0.0205,0.024,1\n2,-0.026,0.0205,0.065,1\n"
      "3,-0.026,-0.0145,0.065,1\n4,-0.026,-0.0145,0.035,1\n6,-0.026,-0.0145,0.018,1\n6.5,-0.026,-0.0145,0.018,0\n60,-0.026,-0.0145,0.018,"
      "0\n");
  const std::string hub = "127.0.0.1:" + find_free_port();
  const std::string file = (scratch.path() / "pick.hapton").string();
  Program io("io_node",
             {"--bind", hub, "--device", "simulated-6dof", "--trajectory", (scratch.path() / "way.csv").string(), "--record", file},
             scratch.path());
  Program haptics("haptics_node", {"--hub", hub, "--scene", HAPTON_SOURCE_DIR "/scenes/workbench.toml"}, scratch.path());
  EXPECT_TRUE(System::wait_until([&] { return haptics.err().find("left peg is put down") != std::string::npos; })) << haptics.err();
  EXPECT_THAT(haptics.err(), HasSubstr("left peg is picked up"));
  for (Program* program : {&haptics, &io}) {
    program->send_signal(SIGTERM);
    const auto ended = program->wait(kPatience);
    ASSERT_TRUE(ended);
    EXPECT_EQ(ended->exit_code, 0) << ended->err;
    if (program == &haptics) {
      EXPECT_THAT(ended->out, HasSubstr("pose of held objects: p50"));
    }
  }
  const Ended replayed = run("hapton", {"session", "replay", file}, scratch.path()).value_or(Ended{});
  EXPECT_EQ(replayed.exit_code, 1) << "when the slow task was done is not recorded";
  EXPECT_THAT(replayed.err, HasSubstr("the stylus held a rigid tool"));
}

}  // namespace
}  // namespace hapton::process
