#include "tools/bench/remote_processes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

namespace hapton {
namespace {

TEST(RemoteProcesses, TheProgramsHaveFourOfTheMethods) {
  std::string names;
  for (const RemoteMethod& method : remote_methods()) names += is_implemented_by_programs(method) ? std::string(method.name) + " " : "";
  EXPECT_EQ(names, "remote remote-passive patch patch-passive ");
}

TEST(RemoteProcesses, AMethodWithoutProgramsIsRejectedBeforeAnythingRuns) {
  RemoteGrid grid;
  grid.methods = {find_remote_method("plane")};
  grid.meshes = {"no such mesh"};
  const auto rows = measure_remote_processes(grid, [](const std::string&) {});
  ASSERT_FALSE(rows);
  EXPECT_NE(rows.error().what.find("--method plane"), std::string::npos) << rows.error().what;
}

TEST(RemoteProcesses, TheTablesHaveTheSameFigures) {
  RemoteGrid grid;
  RemoteProcessRow row;
  row.method = find_remote_method("patch");
  row.mesh = "fish";
  row.seed = 3;
  row.round_trip_s = 0.3;
  row.loss = 0.1;
  row.real.force.error_rms = 0.0125;
  row.real.missed = 17;
  row.simulated.force.error_rms = 0.25;
  const std::string csv = processes_to_csv({row, row});
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3);
  const std::string names = csv.substr(0, csv.find('\n'));
  const std::string values = csv.substr(names.size() + 1, csv.find('\n', names.size() + 1) - names.size() - 1);
  EXPECT_EQ(std::count(names.begin(), names.end(), ','), std::count(values.begin(), values.end(), ','));
  EXPECT_EQ(values.find("patch,fish,3,0,300,0.1,0.0125,"), 0U) << values;
  const auto json = nlohmann::json::parse(processes_to_json(grid, {row}));
  EXPECT_EQ(json.at("schema"), "hapton.bench.remote_processes/1");
  EXPECT_EQ(json.at("runs").at(0).at("missed_cycles"), 17);
  EXPECT_EQ(json.at("runs").at(0).at("simulated_force_error_rms"), 0.25);
  const std::string text = processes_to_text(grid, {row});
  EXPECT_NE(text.find("1.2500"), std::string::npos) << text;
  EXPECT_NE(text.find("25.0000"), std::string::npos) << text;
}

}  // namespace
}  // namespace hapton
