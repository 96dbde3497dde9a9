#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>

#include "core/geometry/screen_rectangle.h"
#include "scene/find_tool.h"
#include "scene/object_names.h"
#include "scene/scene_loading.h"
#include "vision_node/annotator.h"
#include "vision_node/head_tracker.h"
#include "vision_node/screenshot_moment.h"
#include "vision_node/stereo_camera.h"
#include "vision_node/stereo_mode.h"
#include "vision_node/stereo_view.h"
#include "vision_node/teach_choice.h"
#include "vision_node/xr/workspace_place.h"

namespace hapton {

// The command line, read and checked.
struct VisionOptions {
  std::string hub = "127.0.0.1";
  std::string other_hub;          // of another hand to show; empty: none
  std::string bind;               // empty: any address of the hub's family, any port
  std::string key_file;           // empty: the user's own, on loopback
  std::filesystem::path session;  // a recording to show in place of a hub; empty: live
  std::optional<double> at_s;     // its moment at the start, where it is paused; none: its begin
  double speed = 1.0;             // that it plays at
  std::filesystem::path frames;   // folder for its pictures, one after the other; empty: it is played in the window
  double frame_rate_hz = 30.0;    // of these pictures
  std::filesystem::path scene = "scenes/car_front.toml";
  bool is_scene_given = false;    // on the command line
  bool watch_scene = false;       // show the scene file again when it is saved
  bool is_loading_given = false;  // unit or fit are on the command line
  SceneLoading loading = {
      .sealing = CrackSealing::off, .fit = MeshFit::workspace, .appearance = AppearanceReading::on};  // drawn as it came
  ToolChoice tool;
  AnnotatorOptions annotations;
  ViewSettings view;
  bool culls_open = false;  // open surfaces show no triangles seen from behind either
  Vec3 dials_degrees = Vec3::Zero();
  std::vector<ObjectName> names;  // of the scene's objects
  Vec3 p_SO = Vec3::Zero();       // a sphere around the scene that was opened
  double scene_radius_m = 0.0;
  // A three-quarter view shows depth and the force that points at the hand, and is little enough for the hand not to mind.
  double view_yaw_deg = -25.0;
  double view_pitch_deg = 20.0;
  bool is_view_yaw_given = false;  // on the command line; otherwise the scene's camera counts, where there is one
  bool is_view_pitch_given = false;
  double stylus_lean_deg = 50.0;
  double probe_radius_m = -1.0;  // below 0: as the haptics node says
  double view_mm = 0.0;          // 0: as the scene needs
  double ipd_mm = 1e3 * kEyeDistance;
  double screen_width_mm = 0.0;  // 0: not known
  std::filesystem::path screen_file;
  RoomSpace room = RoomSpace::local;      // of a headset
  Pose X_OW = Pose::Identity();           // the workspace in it, before the viewer
  std::optional<ScreenRectangle> screen;  // what is in that file; none: it is not known where the screen is
  Head head;                              // at the start
  HeadSource head_source;
  bool has_space_head = false;  // a SpaceMouse moves the head
  double rate_limit_hz = -1;    // below 0: chosen by the renderer
  double seconds = 0.0;         // 0: until the window is closed
  int bench_frames = 0;
  bool help = true;
  bool plots = false;
  TeachChoice teach;             // a view that shows what a method computes with
  bool has_space_knobs = false;  // a SpaceMouse turns the dials, too
  std::filesystem::path screenshot;
  ScreenshotMoment screenshot_moment;
};

// The options, or the exit code to leave main with. RT: set-up only.
std::variant<VisionOptions, int> parse_vision_options(int argc, const char* const* argv);

// Reads the file of --screen, if there is one. Error: names the file.
Result<void> find_screen(VisionOptions& options);

// Error: --stereo openxr with what contradicts a headset, one line.
Result<void> check_headset(const VisionOptions& options);

// Error: a head from which the screen cannot be seen, one line.
Result<void> check_head(const VisionOptions& options);

}  // namespace hapton
