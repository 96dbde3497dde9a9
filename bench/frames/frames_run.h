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
  std::shared_ptr<const TriangleMesh> mesh;  // m, centred on the middle of the workspace
};

struct FramesSettings {
  int frames = 120;  // number of frames that each program draws of each mesh
  int block = 6;     // number of frames that one program draws in a row before it is the other program's turn
  bool offscreen = false;
};

// Frame rate of one program on one mesh while the scene turns all the time.
struct FramesRate {
  double hz = 0.0;  // number of frames divided by the time that drawing them took
  double p50_ms = 0.0;
  double p99_ms = 0.0;
  double cpu_ms = 0.0;  // CPU time per frame of all threads of the process; the load of other programs does not count in it
};

struct FramesRow {
  std::string mesh;
  std::size_t triangles = 0;
  FramesRate plain;
  FramesRate hapton;
  double first_frame_ms = 0.0;  // time from the mesh in memory to the first frame in the window
  double levels_s = 0.0;        // time from the same moment until all levels of detail are made; at most 120 s
  double probe_hz = 0.0;        // frames per second while the scene is at rest and the probe moves
  double probe_cpu_ms = 0.0;
  std::size_t shown_triangles = 0;  // number of triangles of the level of detail that was drawn while the scene turned
  double error_px = 0.0;            // largest error of that level of detail against the full mesh, in the picture
  double ratio() const { return plain.hz > 0.0 ? hapton.hz / plain.hz : 0.0; }
};

// The picture: 1280 x 720, two eyes side by side. The two programs alternate, so that other load affects both. Error: no display.
Result<FramesRow> run_frames(const FramesMesh& mesh, const FramesSettings& settings);

std::string describe_frames(const std::vector<FramesRow>& rows);
std::string frames_csv(const std::vector<FramesRow>& rows);

}  // namespace hapton
