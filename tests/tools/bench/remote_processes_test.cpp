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

TEST(RemoteProcesses, EachFigureIsUnderItsName) {
  RemoteProcessRow row;
  row.method = find_remote_method("remote");
  row.mesh = "fish";
  row.seed = 3;
  row.real.force = {.error_rms = 1.0,
                    .error_max_n = 2.0,
                    .direction_rms_deg = 3.0,
                    .direction_max_deg = 100.0,
                    .time_offset_s = 4e-3,
                    .value_offset = 5.0,
                    .falls = 6,
                    .fall_s = 7.0,
                    .generated_j = 9e-3,
                    .zero_delay_generated_j = 10e-3,
                    .contact_s = 8.0};
  row.real.rates = {.packets_up = 11.0, .packets_down = 12.0, .bytes_up = 13.0, .bytes_down = 14.0};
  row.real.scene_kb = 15.0;
  row.real.ready_s = 16.0;
  row.real.local_error_rms = 17.0;
  row.real.local_error_max_n = 18.0;
  row.real.local_share = 19.0;
  row.real.cycles = 20;
  row.real.missed = 21;
  row.simulated.force.error_rms = 22.0;
  row.simulated.force.falls = 23;
  row.simulated.rates = {.packets_up = 24.0, .packets_down = 25.0, .bytes_up = 101.0, .bytes_down = 102.0};
  EXPECT_EQ(processes_to_csv({row}),
            "method,mesh,seed,speed_mm_per_s,round_trip_ms,loss,force_error_rms,force_error_max_n,direction_error_rms_deg,time_offset_ms,"
            "value_offset,falls,fall_s,contact_s,generated_mj,zero_delay_generated_mj,packets_up_per_s,packets_down_per_s,bytes_up_per_s,"
            "bytes_down_per_s,scene_kb,ready_s,local_error_rms,local_error_max_n,local_share,cycles,missed_cycles,"
            "simulated_force_error_rms,simulated_falls,simulated_packets_up_per_s,simulated_packets_down_per_s\n"
            "remote,fish,3,0,0,0,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17,18,19,20,21,22,23,24,25\n");
}

}  // namespace
}  // namespace hapton
