#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/process/program.h"
#include "tests/process/system.h"
#include "tests/support/scratch_folder.h"

namespace hapton::process {

// A hand that a trajectory leads over a scene: io_node with a simulated device and haptics_node, as real programs, recorded.
struct LedHand {
  // scene: a file of scenes/, or an absolute path. more: further arguments of io_node.
  LedHand(const std::string& device, const std::string& way_csv, const std::string& scene, const std::vector<std::string>& more = {})
      : io("io_node", io_arguments(device, way_csv, more), scratch.path()),
        haptics("haptics_node", {"--hub", hub, "--scene", (std::filesystem::path(HAPTON_SOURCE_DIR "/scenes") / scene).string()},
                scratch.path()) {}

  // Waits until this note of the report is above `least`.
  testing::AssertionResult goes_above(const std::string& note, double least) {
    if (System::wait_until([&] { return is_up() || !io.is_running(); }) && io.is_running() &&
        System::wait_until([&] { return read_note(note) > least; })) {
      return testing::AssertionSuccess();
    }
    return testing::AssertionFailure() << note << " is not above " << least << "\n" << haptics.err() << io.err();
  }

  // From then on io_node takes signals.
  bool is_up() const { return io.out().find("hub on ") != std::string::npos; }

  // A counter of the report; -1: there is no report.
  std::int64_t read_counter(const std::string& counter) {
    if (!is_up()) return -1;
    io.send_signal(SIGUSR1);
    const Json report = Json::parse(read_text(scratch.path() / "out" / "report.json"), nullptr, false);
    return report.is_object() ? report.at("counters").at(counter).get<std::int64_t>() : -1;
  }

  // Ends both programs, which have to give exit code 0. Returns what haptics_node printed.
  std::string end() {
    std::string summary;
    for (Program* program : {&haptics, &io}) {
      program->send_signal(SIGTERM);
      const auto ended = program->wait(kPatience);
      EXPECT_TRUE(ended) << "does not end";
      if (!ended) continue;
      EXPECT_EQ(ended->exit_code, 0) << ended->err;
      if (program == &haptics) summary = ended->out;
    }
    return summary;
  }

  Ended replay() const { return run("hapton", {"session", "replay", file}, scratch.path()).value_or(Ended{}); }

  ScratchFolder scratch;
  std::string hub = "127.0.0.1:" + find_free_port();
  std::string file = (scratch.path() / "session.hapton").string();
  Program io;
  Program haptics;

 private:
  std::vector<std::string> io_arguments(const std::string& device, const std::string& way_csv, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"--bind",         hub,        "--device", device,  "--trajectory",
                                          written(way_csv), "--record", file,       "--out", (scratch.path() / "out").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  std::string written(const std::string& way_csv) {
    scratch.write("way.csv", way_csv);
    return (scratch.path() / "way.csv").string();
  }

  double read_note(const std::string& note) {
    io.send_signal(SIGUSR1);
    const Json report = Json::parse(read_text(scratch.path() / "out" / "report.json"), nullptr, false);
    return report.is_object() ? std::stod(report.at("notes").at(note).get<std::string>()) : 0.0;
  }
};

}  // namespace hapton::process
