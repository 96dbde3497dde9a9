#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

struct FramesMesh {
  std::string name;
  std::shared_ptr<const TriangleMesh> mesh;  // m, about the workspace centre
};

struct FramesSettings {
  int frames = 120;  // of each program and mesh
  int block = 6;     // drawn in a row before it is the other's turn
  bool offscreen = false;
};

// One program on one mesh, the scene turning all the time.
struct FramesRate {
  double hz = 0.0;  // frames over the time they took
  double p50_ms = 0.0;
  double p99_ms = 0.0;
  double cpu_ms = 0.0;  // of all threads of the process, a frame: what other programs leave as it is
};

struct FramesRow {
  std::string mesh;
  std::size_t triangles = 0;
  FramesRate plain;
  FramesRate hapton;
  double first_frame_ms = 0.0;  // from the mesh in memory to the first frame in the window
  double levels_s = 0.0;        // until all levels of detail are made
  double probe_hz = 0.0;        // frames per second while the scene is at rest and the probe moves
  double probe_cpu_ms = 0.0;
  std::size_t shown_triangles = 0;  // of the level that was drawn while the scene turned
  double error_px = 0.0;            // how far it lies from the mesh
  double ratio() const { return plain.hz > 0.0 ? hapton.hz / plain.hz : 0.0; }
};

// 1280 x 720, two eyes side by side. The two programs alternate, so that other load of the machine affects both. Error: no display.
Result<FramesRow> run_frames(const FramesMesh& mesh, const FramesSettings& settings);

std::string describe_frames(const std::vector<FramesRow>& rows);
std::string frames_csv(const std::vector<FramesRow>& rows);

}  // namespace hapton
