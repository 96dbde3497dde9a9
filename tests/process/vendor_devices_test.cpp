// The unmodified io_node with stand-ins of vendors' libraries and services: forces arrive, cables are pulled, VRPN clients observe.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "tests/io_node/vrpn/vrpn_program.h"
#include "tests/process/system.h"
#include "tests/standins/board.h"
#include "tests/standins/haply_service.h"
#include "tests/standins/paths.h"

namespace hapton::process {
namespace {

using ::testing::HasSubstr;

// A cube of 4 cm, soft enough for a stylus that is a mass on a spring.
void write_scene(const std::filesystem::path& folder) {
  std::ofstream(folder / "small.obj") << "v -0.02 -0.02 -0.02\nv 0.02 -0.02 -0.02\nv 0.02 0.02 -0.02\nv -0.02 0.02 -0.02\n"
                                         "v -0.02 -0.02 0.02\nv 0.02 -0.02 0.02\nv 0.02 0.02 0.02\nv -0.02 0.02 0.02\n"
                                         "f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\n"
                                         "f 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";
  std::ofstream(folder / "small.toml")
      << "[[object]]\nmesh = \"small.obj\"\nmaterial = \"soft\"\n[material.soft]\nstiffness_n_per_m = 200.0\n";
}

struct VendorDevices : testing::Test {
  TestFolder folder;
  standin::BoardFile board{folder.path() / "board"};
  const std::string hub = "127.0.0.1:" + find_free_port();
  std::unique_ptr<Program> io, haptics;

  VendorDevices() { write_scene(folder.path()); }
  ~VendorDevices() override { ::unsetenv("LD_LIBRARY_PATH"); }

  void start_io(const std::vector<std::string>& device) {
    std::vector<std::string> words = {"--bind", hub, "--out", (folder.path() / "out").string(), "--device"};
    words.insert(words.end(), device.begin(), device.end());
    io = std::make_unique<Program>("io_node", words, folder.path());
    ASSERT_TRUE(System::wait_until([&] { return io->out().starts_with("hub on ") || !io->is_running(); }));
    ASSERT_TRUE(io->is_running()) << io->err();
  }
  void start_haptics() {
    haptics = std::make_unique<Program>(
        "haptics_node", std::vector<std::string>{"--hub", hub, "--scene", (folder.path() / "small.toml").string()}, folder.path());
  }
  void end() {
    for (Program* program : {haptics.get(), io.get()}) {
      if (program == nullptr) continue;
      program->send_signal(SIGTERM);
      const auto ended = program->wait(kPatience);
      ASSERT_TRUE(ended);
      EXPECT_EQ(ended->exit_code, 0) << ended->out << ended->err;
    }
  }
};

// The middle of the stand-in's workspace is 2 cm up: in its own axes, the origin of W is at (0, 0.02, 0).
TEST_F(VendorDevices, OpenHapticsIsTouchedPulledOutInContactAndTouchedAgain) {
  ::setenv("LD_LIBRARY_PATH", standin::library("openhaptics").c_str(), 1);
  board->hand_m[1] = 0.02;
  board->hand_m[2] = 0.03;
  start_io({"openhaptics"});
  start_haptics();
  ASSERT_TRUE(System::wait_until([&] { return io->err().find("joined from") != std::string::npos && board->ticks > 1000; }));
  EXPECT_EQ(board->pushed_ticks, 0U) << "nothing is touched yet";
  // Moves the hand into the cube from above, slowly.
  const auto press = [&] {
    for (int step = 0; step <= 100; ++step) {
      board->hand_m[2] = 0.03 - 0.018 * step / 100;
      SteadyClock().sleep_until_ns(SteadyClock().now_ns() + 5 * kNanosecondsPerMillisecond);
    }
  };
  press();
  ASSERT_TRUE(System::wait_until([&] { return board->force[2] > 0.3; })) << io->err() << haptics->err();
  EXPECT_LE(board->largest_force, board->max_force_n);

  // On a machine that stands still, the device may have been disconnected for that reason: then it is pulled out again.
  bool has_logged_error = false;
  for (int attempt = 0; attempt < 5 && !has_logged_error; ++attempt) {
    board->is_plugged = 0;
    ASSERT_TRUE(System::wait_until([&] { return board->closed == board->opened; })) << io->err();
    EXPECT_TRUE(io->is_running());
    board->hand_m[2] = 0.03;
    const std::uint64_t closed = board->closed;
    board->is_plugged = 1;
    ASSERT_TRUE(System::wait_until([&] { return board->opened > closed; })) << io->err();
    has_logged_error = io->err().find("HD_COMM_ERROR (0x302)") != std::string::npos;
    press();
    ASSERT_TRUE(System::wait_until([&] { return board->force[2] > 0.3; })) << io->err() << haptics->err();
    EXPECT_LE(board->largest_force, board->max_force_n);
  }
  EXPECT_TRUE(has_logged_error) << io->err();
  end();
  EXPECT_EQ(board->force[2], 0.0);
  EXPECT_EQ(board->opened, board->closed);
  EXPECT_EQ(board->wrong_calls, 0U);
}

TEST_F(VendorDevices, ForceDimensionIsTouched) {
  ::setenv("LD_LIBRARY_PATH", standin::library("forcedimension").c_str(), 1);
  board->hand_m[2] = 0.03;  // up
  start_io({"forcedimension"});
  start_haptics();
  ASSERT_TRUE(System::wait_until([&] {
    board->hand_m[2] = std::max(0.012, board->hand_m[2] - 0.0005);
    return board->force[2] > 0.3;
  })) << io->err()
      << haptics->err();
  EXPECT_LE(board->largest_force, 12.0);
  end();
  EXPECT_EQ(board->force[2], 0.0);
}

TEST_F(VendorDevices, HaplyIsTouched) {
  HaplyService service;
  service.position_m[2] = 0.15 + 0.03;
  start_io({"haply", "--device-id", "@" + service.address()});
  start_haptics();
  EXPECT_TRUE(System::wait_until([&] {
    service.position_m[2] = std::max(0.15 + 0.016, service.position_m[2] - 0.0005);
    return service.force_n[2] > 0.3;
  })) << io->err()
      << haptics->err();
  end();
  EXPECT_EQ(service.force_n[2], 0.0);
}

TEST_F(VendorDevices, AMissingLibraryOrServiceIsOneLineAndNoStart) {
  for (const std::string device : {"openhaptics", "forcedimension"}) {
    const auto ended = run("io_node", {"--bind", hub, "--device", device}, folder.path());
    ASSERT_TRUE(ended);
    EXPECT_EQ(ended->exit_code, 1);
    EXPECT_THAT(ended->err, HasSubstr("cannot open shared object file"));
    EXPECT_EQ(std::count(ended->err.begin(), ended->err.end(), '\n'), 1) << ended->err;
  }
  const auto ended = run("io_node", {"--bind", hub, "--device", "haply", "--device-id", "@127.0.0.1:9"}, folder.path());
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 1);
  EXPECT_THAT(ended->err, HasSubstr("systemctl start haply-inverse-service"));
}

TEST_F(VendorDevices, VrpnProgramsSeeTheStylusAndItsButtons) {
  ::setenv("LD_LIBRARY_PATH", standin::library("openhaptics").c_str(), 1);
  start_io({"openhaptics", "--vrpn", "127.0.0.1:0"});
  // Finds the address in "VRPN: Phantom0@127.0.0.1:PORT".
  const std::string err = io->err();
  const std::size_t at = err.find("Phantom0@127.0.0.1:");
  ASSERT_NE(at, std::string::npos) << err;
  const auto address = parse_address("127.0.0.1:" + std::to_string(std::stoi(err.substr(at + 19))));
  ASSERT_TRUE(address);
  vrpn::Program program;
  program.request_callbacks(*address);
  ASSERT_TRUE(System::wait_until([&] {
    program.poll();
    return program.has_received("vrpn_Tracker Pos_Quat") && program.has_received("vrpn_Button States");
  }));
  board->buttons = 1;
  EXPECT_TRUE(System::wait_until([&] {
    program.poll();
    return program.has_received("vrpn_Button Change");
  }));
  end();
}

}  // namespace
}  // namespace hapton::process
