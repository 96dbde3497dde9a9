// Objects that move by keyframes, in the real programs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/process/program.h"
#include "tests/process/system.h"
#include "tests/support/scratch_folder.h"

namespace hapton::process {
namespace {

using ::testing::HasSubstr;

// A hand that holds still over the piston of scenes/machine.toml is pushed up by it; the recording gives the same forces again.
TEST(MovingObjects, PushAHandThatHoldsStillAndAreReplayed) {
  ScratchFolder scratch;
  scratch.write("way.csv", "t_s,x_m,y_m,z_m\n0,-0.068,0.05,0\n0.5,-0.068,0.033,0\n60,-0.068,0.033,0\n");
  const std::string hub = "127.0.0.1:" + find_free_port();
  const std::string file = (scratch.path() / "machine.hapton").string();
  Program io("io_node",
             {"--bind", hub, "--device", "simulated", "--trajectory", (scratch.path() / "way.csv").string(), "--record", file, "--out",
              (scratch.path() / "out").string()},
             scratch.path());
  Program haptics("haptics_node", {"--hub", hub, "--scene", HAPTON_SOURCE_DIR "/scenes/machine.toml"}, scratch.path());
  const auto report = [&] {
    io.send_signal(SIGUSR1);
    return Json::parse(read_text(scratch.path() / "out" / "report.json"), nullptr, false);
  };
  ASSERT_TRUE(System::wait_until([&] { return io.out().find("hub on ") != std::string::npos || !io.is_running(); }));
  EXPECT_TRUE(System::wait_until([&] {
    const Json now = report();
    return now.is_object() && std::stod(now.at("notes").at("max_force_written_n").get<std::string>()) > 0.5;
  })) << haptics.err()
      << io.err();
  for (Program* program : {&haptics, &io}) {
    program->send_signal(SIGTERM);
    const auto ended = program->wait(kPatience);
    ASSERT_TRUE(ended);
    EXPECT_EQ(ended->exit_code, 0) << ended->err;
  }
  const Ended replayed = run("hapton", {"session", "replay", file}, scratch.path()).value_or(Ended{});
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr(" 0 different"));
}

}  // namespace
}  // namespace hapton::process
