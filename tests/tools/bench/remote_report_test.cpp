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

// Each mesh's error is larger by a tenth than that of the one before.
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
