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
  std::string other_hub;          // hub of another hand that is shown as well; empty: none
  std::string bind;               // local address; empty: any address of the hub's family, any port
  std::string key_file;           // empty: the user's shared key, for a hub on loopback
  std::filesystem::path session;  // a recording to show in place of a hub; empty: live
  std::optional<double> at_s;     // time of the recording at which it begins, paused; none: it plays from its beginning
  double speed = 1.0;             // playing speed of the recording; 1: as it was recorded
  std::filesystem::path frames;   // folder for numbered pictures of the recording; empty: it is shown in the window
  double frame_rate_hz = 30.0;    // pictures in `frames` for each second of the video
  std::filesystem::path scene = "scenes/car_front.toml";
  bool is_scene_given = false;    // the scene is on the command line
  bool watch_scene = false;       // show the scene file again when it is saved
  bool is_loading_given = false;  // --unit or --no-fit is on the command line
  SceneLoading loading = {
      .sealing = CrackSealing::off, .fit = MeshFit::workspace, .appearance = AppearanceReading::on};  // cracks are drawn as they are
  ToolChoice tool;
  AnnotatorOptions annotations;
  ViewSettings view;
  bool culls_open = false;  // triangles of open surfaces are not drawn from behind either
  Vec3 dials_degrees = Vec3::Zero();
  std::vector<ObjectName> names;  // names of the scene's objects
  Vec3 p_SO = Vec3::Zero();       // centre of a sphere around the scene that was opened, frame S
  double scene_radius_m = 0.0;
  // These angles show depth, and a force towards the viewer; they are so small that hand and picture still seem to move alike.
  double view_yaw_deg = -25.0;
  double view_pitch_deg = 20.0;
  bool is_view_yaw_given = false;  // on the command line; otherwise the scene's camera applies, if it has one
  bool is_view_pitch_given = false;
  double stylus_lean_deg = 50.0;
  double probe_radius_m = -1.0;  // below 0: the radius that haptics_node uses
  double view_mm = 0.0;          // smaller side of the picture; 0: chosen for the scene
  double ipd_mm = 1e3 * kEyeDistance;
  double screen_width_mm = 0.0;  // 0: not known
  std::filesystem::path screen_file;
  RoomSpace room = RoomSpace::local;      // reference space of the headset
  Pose X_OW = Pose::Identity();           // of the workspace in a headset, relative to the viewer: see WorkspacePlace
  std::optional<ScreenRectangle> screen;  // read from screen_file; none: its place is not known
  Head head;                              // the viewer's head at the start
  HeadSource head_source;
  bool has_space_head = false;  // a SpaceMouse moves the head
  double rate_limit_hz = -1;    // frames a second; 0: no limit; below 0: chosen for the renderer
  double seconds = 0.0;         // 0: until the window is closed
  int bench_frames = 0;
  bool help = true;
  bool plots = false;
  TeachChoice teach;             // the teaching view at the start
  bool has_space_knobs = false;  // a SpaceMouse turns the dials, too
  std::filesystem::path screenshot;
  ScreenshotMoment screenshot_moment;
};

// The options, or the exit code that main() returns at once. RT: set-up only.
std::variant<VisionOptions, int> parse_vision_options(int argc, const char* const* argv);

// Reads the file of --screen, if there is one. Error: names the file.
Result<void> find_screen(VisionOptions& options);

// Error, one line: --stereo openxr together with an option that contradicts a headset.
Result<void> check_headset(const VisionOptions& options);

// Error, one line: a head whose position is not is_possible().
Result<void> check_head(const VisionOptions& options);

}  // namespace hapton
