#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "remote_touch/remote_run.h"
#include "tools/bench/bench_meshes.h"

namespace hapton {

// What `hapton bench remote` measures: every method over every mesh, seed, speed, round trip and loss.
struct RemoteGrid {
  std::vector<const RemoteMethod*> methods;
  std::vector<std::string> meshes;
  std::filesystem::path mesh_folder;
  std::vector<double> speeds_m_per_s;
  std::vector<double> round_trips_s;
  std::vector<double> losses;
  double jitter_s = 0.0;
  double stall_s = 0.0;
  std::uint64_t seed = 1;  // the first; of the path and the network
  std::size_t seeds = 1;
  double stiffness_n_per_m = 1000.0;
  std::string device_name;
  RemoteDevice device;
  RemoteSettings settings;
  bool has_walls = true;  // find the largest stiffness too
};

// Which run of the grid.
struct RemoteKey {
  const RemoteMethod* method = nullptr;
  std::string mesh;
  std::uint64_t seed = 0;
  double speed_m_per_s = 0.0;
  double round_trip_s = 0.0;
  double loss = 0.0;
};

// The mesh in the middle of the workspace, of the grid's stiffness.
Result<RemoteScene> make_centred_scene(const RemoteGrid& grid, const BenchMesh& mesh);
// By seeds, speeds, round trips, then losses; the path is the same for all losses. The key has no method. Stops at an error.
using UseRemotePath = std::function<Result<void>(const SlidePath&, const RemoteKey&)>;
Result<void> for_each_remote_path(const RemoteGrid& grid, const RemoteScene& scene, const std::string& mesh, const UseRemotePath& use);
// Pre: the key has a method.
RemoteCase make_remote_case(const RemoteGrid& grid, const RemoteKey& key);
// "mesh, seed 1, 100 mm/s, 30 ms, loss 10 %", with the method where there is one.
std::string describe(const RemoteKey& key);

struct RemoteRow : RemoteKey {
  PrescribedTouch touch;
  ClosedLoopTouch loop;
};

// The largest stiffness of a wall.
struct RemoteWall {
  const RemoteMethod* method = nullptr;
  double round_trip_s = 0.0;
  double loss = 0.0;
  double rest_stiffness_n_per_m = 0.0;
  double stable_n_per_m = 0.0;  // limit of linear theory for a force that is late by the round trip and never lost
};

struct RemoteResults {
  std::vector<RemoteRow> rows;  // without their traces
  std::vector<RemoteWall> walls;
};

constexpr double kMaxWallNPerM = 20'000.0;  // the stiffest wall tried; a limit above it is reported as "> 20000"
constexpr double kRemotePeriodS = 1e-3;     // of the device

Result<RemoteResults> measure_remote(const RemoteGrid& grid, const std::function<void(const std::string&)>& progress);

// One cell with all methods, period by period: the first mesh, seed, speed, round trip and loss of the grid. CSV with a comment that says
// what it is.
Result<std::string> trace_remote(const RemoteGrid& grid);

}  // namespace hapton
