#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "remote_touch/remote_run.h"
#include "tools/bench/bench_meshes.h"

namespace hapton {

// What `hapton bench remote` measures: every method with every mesh, seed, speed, round trip and loss.
struct RemoteGrid {
  std::vector<const RemoteMethod*> methods;
  std::vector<std::string> meshes;
  std::filesystem::path mesh_folder;
  std::vector<double> speeds_m_per_s;
  std::vector<double> round_trips_s;
  std::vector<double> losses;  // share of the datagrams that is lost, each way
  double jitter_s = 0.0;       // largest random extra delay of a datagram, each way
  double stall_s = 0.0;        // mean length of the stalls of the device's machine (machine_stalls.h)
  std::uint64_t seed = 1;      // the first seed, of the path and of the network
  std::size_t seeds = 1;       // number of seeds
  double stiffness_n_per_m = 1000.0;
  std::string device_name;
  RemoteDevice device;
  RemoteSettings settings;
  bool has_walls = true;  // whether the largest stiffness of a wall is measured as well
};

// Identifies a run of the grid.
struct RemoteKey {
  const RemoteMethod* method = nullptr;
  std::string mesh;
  std::uint64_t seed = 0;
  double speed_m_per_s = 0.0;
  double round_trip_s = 0.0;
  double loss = 0.0;
};

// The mesh, with its centre at that of the device's workspace, the origin, and the stiffness of the grid.
Result<RemoteScene> make_centred_scene(const RemoteGrid& grid, const BenchMesh& mesh);
// Order: seeds, speeds, round trips, losses; a path serves all losses. The key that `use` gets has no method. Stops at the first error.
using UseRemotePath = std::function<Result<void>(const SlidePath&, const RemoteKey&)>;
Result<void> for_each_remote_path(const RemoteGrid& grid, const RemoteScene& scene, const std::string& mesh, const UseRemotePath& use);
// Pre: the key has a method.
RemoteCase make_remote_case(const RemoteGrid& grid, const RemoteKey& key);
// "mesh, seed 1, 100 mm/s, 30 ms, loss 10 %"; with the method after the mesh if the key has one.
std::string describe(const RemoteKey& key);

struct RemoteRow : RemoteKey {
  PrescribedTouch touch;  // the hand follows the path, whatever the force
  ClosedLoopTouch loop;   // the force moves hand and device
};

// The largest stiffness of a wall, for one method, round trip and loss.
struct RemoteWall {
  const RemoteMethod* method = nullptr;
  double round_trip_s = 0.0;
  double loss = 0.0;
  double rest_stiffness_n_per_m = 0.0;  // the largest at which a press comes to rest (find_rest_stiffness_of); 0: none
  double stable_n_per_m = 0.0;          // limit of the linear theory, for a force that is late by the round trip and never lost
};

struct RemoteResults {
  std::vector<RemoteRow> rows;  // PrescribedTouch::rows and ClosedLoopTouch::p_WD are empty
  std::vector<RemoteWall> walls;
};

constexpr double kMaxWallNPerM = 20'000.0;  // the stiffest wall tried; this result is reported as "> 20000"

// Measures the whole grid. progress: called with a line after each path and each set of walls. Error, one line: a mesh cannot be read, no
// path over it was found, or that of a run (remote_run.h). RT: no.
Result<RemoteResults> measure_remote(const RemoteGrid& grid, const std::function<void(const std::string&)>& progress);

// Runs all methods for one case and writes every period: the first mesh, seed, speed, round trip and loss of the grid. CSV, with a comment
// line that describes the case.
Result<std::string> trace_remote(const RemoteGrid& grid);

}  // namespace hapton
