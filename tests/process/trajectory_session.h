#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/process/program.h"
#include "tests/process/system.h"
#include "tests/support/scratch_folder.h"

namespace hapton::process {

// A recorded session of the real programs io_node and haptics_node, in which the hand of a simulated device follows a trajectory.
struct TrajectorySession {
  // scene: a file of scenes/, or an absolute path. further_arguments: of io_node.
  TrajectorySession(const std::string& device, const std::string& trajectory_csv, const std::string& scene,
                    const std::vector<std::string>& further_arguments = {})
      : io("io_node", io_arguments(device, trajectory_csv, further_arguments), scratch.path()),
        haptics("haptics_node", {"--hub", hub, "--scene", (std::filesystem::path(HAPTON_SOURCE_DIR "/scenes") / scene).string()},
                scratch.path()) {}

  // Waits until this note of the report is above `limit`.
  testing::AssertionResult wait_for_note_above(const std::string& note, double limit) {
    if (System::wait_until([&] { return is_up() || !io.is_running(); }) && io.is_running() &&
        System::wait_until([&] { return read_note(note) > limit; })) {
      return testing::AssertionSuccess();
    }
    return testing::AssertionFailure() << note << " is not above " << limit << "\n" << haptics.err() << io.err();
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
  std::vector<std::string> io_arguments(const std::string& device, const std::string& trajectory_csv,
                                        const std::vector<std::string>& further_arguments) {
    std::vector<std::string> arguments = {"--bind",       hub,
                                          "--device",     device,
                                          "--trajectory", write_trajectory(trajectory_csv),
                                          "--record",     file,
                                          "--out",        (scratch.path() / "out").string()};
    arguments.insert(arguments.end(), further_arguments.begin(), further_arguments.end());
    return arguments;
  }
  std::string write_trajectory(const std::string& trajectory_csv) {
    scratch.write("way.csv", trajectory_csv);
    return (scratch.path() / "way.csv").string();
  }

  double read_note(const std::string& note) {
    io.send_signal(SIGUSR1);
    const Json report = Json::parse(read_text(scratch.path() / "out" / "report.json"), nullptr, false);
    return report.is_object() ? std::stod(report.at("notes").at(note).get<std::string>()) : 0.0;
  }
};

}  // namespace hapton::process
