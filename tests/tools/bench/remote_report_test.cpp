#include "tools/bench/remote_report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace hapton {
namespace {

RemoteGrid grid_of(std::size_t meshes) {
  RemoteGrid grid;
  grid.methods = {find_remote_method("remote-held"), find_remote_method("patch")};
  grid.meshes.assign(meshes, "mesh");
  grid.speeds_m_per_s = {0.1};
  grid.round_trips_s = {0.0, 0.1};
  grid.losses = {0.1};
  grid.device_name = "touch in hand stylus";
  return grid;
}

// The error of each mesh is 0.1 more than that of the previous mesh.
RemoteResults results_of(const RemoteGrid& grid) {
  RemoteResults results;
  for (std::size_t mesh = 0; mesh < grid.meshes.size(); ++mesh) {
    for (const double round_trip_s : grid.round_trips_s) {
      for (const RemoteMethod* method : grid.methods) {
        RemoteRow row;
        row.method = method;
        row.mesh = "mesh";
        row.speed_m_per_s = 0.1;
        row.round_trip_s = round_trip_s;
        row.loss = 0.1;
        row.touch.force.error_rms = 0.1 * static_cast<double>(mesh + 1);
        results.rows.push_back(row);
        if (mesh == 0) results.walls.push_back({method, round_trip_s, 0.1, method->name == "patch" ? 0.0 : 3000.0, 5000.0});
      }
    }
  }
  return results;
}

TEST(RemoteReport, TheTextHasMedianAndWorstAndTheWalls) {
  const RemoteGrid grid = grid_of(3);
  const std::string text = to_text(grid, results_of(grid));
  EXPECT_NE(text.find("20.0000 30.0000"), std::string::npos) << text;
  EXPECT_NE(text.find("theory, held"), std::string::npos);
  EXPECT_NE(text.find("none"), std::string::npos) << "a wall that holds at no stiffness";
  EXPECT_NE(text.find("3000"), std::string::npos);
}

TEST(RemoteReport, TheTablesHaveALineForEachRunAndWall) {
  const RemoteGrid grid = grid_of(2);
  const RemoteResults results = results_of(grid);
  const std::string csv = to_csv(results);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 8);
  EXPECT_EQ(csv.find("method,mesh,seed,speed_mm_per_s,round_trip_ms,loss,force_error_rms,"), 0U);
  const std::string first = csv.substr(0, csv.find('\n'));
  const std::string second = csv.substr(first.size() + 1, csv.find('\n', first.size() + 1) - first.size() - 1);
  EXPECT_EQ(std::count(first.begin(), first.end(), ','), std::count(second.begin(), second.end(), ','));
  const std::string walls = walls_to_csv(results);
  EXPECT_EQ(std::count(walls.begin(), walls.end(), '\n'), 1 + 4);
}

TEST(RemoteReport, EachFigureOfARunIsUnderItsName) {
  RemoteRow row;
  row.method = find_remote_method("patch");
  row.mesh = "fish";
  row.seed = 2;
  row.speed_m_per_s = 0.2;
  row.round_trip_s = 0.03;
  row.loss = 0.05;
  row.touch.force = {.error_rms = 1.0,
                     .error_max_n = 2.0,
                     .direction_rms_deg = 3.0,
                     .direction_max_deg = 4.0,
                     .time_offset_s = 5e-3,
                     .value_offset = 6.0,
                     .falls = 7,
                     .fall_s = 8.0,
                     .generated_j = 10e-3,
                     .zero_delay_generated_j = 11e-3,
                     .contact_s = 9.0};
  row.loop = {.is_bounded = true, .limit_cycle_m = 14e-3, .generated_j = 13e-3, .path_error_m = 15e-3, .most_force_n = 16.0, .p_WD = {}};
  row.touch.rates = {.packets_up = 17.0, .packets_down = 18.0, .bytes_up = 19.0, .bytes_down = 20.0};
  row.touch.scene_kb = 21.0;
  row.touch.ready_s = 22.0;
  RemoteRow unbounded = row;
  unbounded.loop.is_bounded = false;
  const std::string names =
      "method,mesh,seed,speed_mm_per_s,round_trip_ms,loss,force_error_rms,force_error_max_n,direction_error_rms_deg,"
      "direction_error_max_deg,time_offset_ms,value_offset,falls,fall_s,contact_s,generated_mj,zero_delay_generated_mj,loop_bounded,"
      "loop_generated_mj,loop_limit_cycle_mm,loop_path_error_mm,loop_most_force_n,packets_up_per_s,packets_down_per_s,bytes_up_per_s,"
      "bytes_down_per_s,scene_kb,ready_s\n";
  const std::string key = "patch,fish,2,200,30,0.05,";
  EXPECT_EQ(to_csv(RemoteResults{.rows = {row, unbounded}, .walls = {}}),
            names + key + "1,2,3,4,5,6,7,8,9,10,11,1,13,14,15,16,17,18,19,20,21,22\n" + key +
                "1,2,3,4,5,6,7,8,9,10,11,0,13,14,15,16,17,18,19,20,21,22\n");
}

TEST(RemoteReport, AWallHasTheStiffnessAtWhichAPressRestsAndThatOfTheTheory) {
  const RemoteGrid grid = grid_of(1);
  RemoteResults results;
  results.walls = {{find_remote_method("patch"), 0.03, 0.05, 3000.0, 5000.0}};
  EXPECT_EQ(walls_to_csv(results), "method,round_trip_ms,loss,rest_stiffness_n_per_m,stable_stiffness_n_per_m\npatch,30,0.05,3000,5000\n");
  const auto wall = nlohmann::json::parse(to_json(grid, results)).at("walls").at(0);
  EXPECT_EQ(wall.at("rest_stiffness_n_per_m"), 3000.0);
  EXPECT_EQ(wall.at("stable_stiffness_n_per_m"), 5000.0);
}

TEST(RemoteReport, TheJsonSaysWhatItIs) {
  const RemoteGrid grid = grid_of(1);
  const auto json = nlohmann::json::parse(to_json(grid, results_of(grid)));
  EXPECT_EQ(json["schema"], "hapton.bench.remote/1");
  EXPECT_EQ(json["runs"].size(), 4U);
  EXPECT_EQ(json["runs"][0]["force_error_rms"], 0.1);
  EXPECT_EQ(json["walls"].size(), 4U);
}

TEST(RemoteReport, ThePlotHasALineForEachMethodAndAPanelForTheWalls) {
  const RemoteGrid grid = grid_of(1);
  RemoteResults results = results_of(grid);
  const std::string both = make_remote_plot(grid, results, "a.png.part");
  EXPECT_NE(both.find("layout 1,2"), std::string::npos);
  EXPECT_NE(both.find("title 'patch'"), std::string::npos);
  EXPECT_NE(both.find("set output 'a.png.part'"), std::string::npos);
  results.walls.clear();
  EXPECT_NE(make_remote_plot(grid, results, "a.png.part").find("layout 1,1"), std::string::npos);
}

}  // namespace
}  // namespace hapton
