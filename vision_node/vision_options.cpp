#include "vision_node/vision_options.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include <fmt/core.h>
#include <CLI/CLI.hpp>

#include "core/math/turn_by_degrees.h"
#include "link/link_key.h"
#include "runtime/config.h"
#include "runtime/flag_checks.h"
#include "scene/screen_file.h"
#include "scene/text_cursor.h"
#include "vision_node/hud_text.h"
#include "vision_node/session_player.h"

namespace hapton {
namespace {

// Removes the text up to the separator from `rest`, and the separator as well; returns the text.
std::string_view take_word(std::string_view& rest, char separator) {
  const std::size_t end = std::min(rest.find(separator), rest.size());
  const std::string_view word = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return word;
}

Result<PictureSize> parse_size(std::string_view text) {
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::string_view rest = text;
  const bool is_one = parse_integer(take_word(rest, 'x'), width) && parse_integer(rest, height);
  if (!is_one || width < 64 || height < 64 || width > 16384 || height > 16384) {
    return fail("'{}' is not a size; give WIDTHxHEIGHT in pixels, from 64x64 to 16384x16384", text);
  }
  return PictureSize{static_cast<int>(width), static_cast<int>(height)};
}

Result<Vec3> parse_triple(std::string_view text) {
  Vec3 numbers = Vec3::Zero();
  std::string_view rest = text;
  const bool is_one =
      parse_number(take_word(rest, ','), numbers.x()) && parse_number(take_word(rest, ','), numbers.y()) && parse_number(rest, numbers.z());
  constexpr double kMax = 1e6;  // for each number, in its unit, so that results computed from it are finite
  if (!is_one || !(numbers.cwiseAbs().array() <= kMax).all()) return fail("'{}' is not a triple; give X,Y,Z without spaces", text);
  return numbers;
}

// The texts of the options about the viewer's head, not parsed yet.
struct HeadWords {
  std::string source = "keys";
  std::string at_mm = "0,0,600";
  std::string turn_deg = "0,0,0";
  std::string tracker_mm = "0,0,0";
  std::string tracker_turn_deg = "0,0,0";
  std::string eyes_mm = "0,0,0";
};

void add_head_options(CLI::App& app, HeadWords& words, VisionOptions& options) {
  app.add_option("--screen-width-mm", options.screen_width_mm,
                 "Physical width of the picture for each eye: eyes and head are then in true proportion to it (default: a viewer at a "
                 "desk, scaled with the scene)")
      ->check(between(10.0, 100'000.0));
  const auto head = app.add_option("--head", words.source,
                                   "What moves the viewer's head: keys (arrows, page up, page down, home); or in addition spacemouse "
                                   "(pushes of its cap) or vrpn:NAME@HOST[:PORT] (a tracker)")
                        ->check(accepts(parse_head_input))
                        ->capture_default_str();
  app.add_option("--head-mm", words.at_mm,
                 "The point midway between the eyes at the start: X,Y,Z in mm from the screen's centre, right, up, towards the viewer")
      ->check(accepts(parse_triple))
      ->capture_default_str();
  app.add_option("--head-turn-deg", words.turn_deg, "Rotation of the head at the start: X,Y,Z in degrees, about the screen's x, y, z")
      ->check(accepts(parse_triple))
      ->capture_default_str();
  app.add_option("--head-sensor", options.head_source.sensor, "Number of the tracker's sensor on the head")
      ->check(between(0, 1000))
      ->capture_default_str()
      ->needs(head);
  app.add_option("--eyes-mm", words.eyes_mm, "The point midway between the eyes in the frame of that sensor: X,Y,Z in mm")
      ->check(accepts(parse_triple))
      ->capture_default_str()
      ->needs(head);
  app.add_option("--tracker-mm", words.tracker_mm, "Position of the tracker's origin, in the frame of --head-mm")
      ->check(accepts(parse_triple))
      ->capture_default_str()
      ->needs(head);
  app.add_option("--tracker-turn-deg", words.tracker_turn_deg, "Rotation of the tracker's axes, as --head-turn-deg")
      ->check(accepts(parse_triple))
      ->capture_default_str()
      ->needs(head);
}

// Pre: each text has passed the check of its option.
void set_head(const HeadWords& words, VisionOptions& options) {
  options.head = {1e-3 * *parse_triple(words.at_mm), turn_by_degrees(*parse_triple(words.turn_deg))};
  HeadSource& source = options.head_source;
  const HeadInput input = *parse_head_input(words.source);
  options.has_space_head = input.is_space_mouse;
  source.tracker = input.tracker;
  source.p_BH = 1e-3 * *parse_triple(words.eyes_mm);
  source.X_RT = Eigen::Translation3d(1e-3 * *parse_triple(words.tracker_mm)) * turn_by_degrees(*parse_triple(words.tracker_turn_deg));
}

// Adds the options that show a recording in place of a hub. Pre: the app already has all flags of a live session.
void add_session_options(CLI::App& app, VisionOptions& options) {
  const auto session =
      app.add_option("--session", options.session,
                     "Recording (io_node --record) to show in place of a hub, with a time line; its scene is the one that it "
                     "names, or --scene");
  for (const char* live : {"--hub", "--bind", "--key", "--bench-frames", "--strokes", "--knobs", "--watch-scene"}) {
    session->excludes(app.get_option(live));
  }
  app.add_option_function<double>(
         "--at", [&options](const double& at_s) { options.at_s = at_s; },
         "Begin at this time of the recording, s, and pause; with --screenshot: show that moment and end")
      ->check(between(-1e9, 1e9))
      ->needs(session);
  app.add_option("--speed", options.speed, "Play the recording at this speed ([ and ] change it)")
      ->check(between(SessionPlayer::kSlowest, SessionPlayer::kFastest))
      ->capture_default_str()
      ->needs(session);
  const auto frames =
      app.add_option("--frames", options.frames,
                     "New or empty folder for pictures frame_000001.png ..., from --at, or the beginning, to the end, or for "
                     "--seconds: for a video")
          ->needs(session)
          ->excludes(app.get_option("--screenshot"));
  app.add_option("--frame-rate", options.frame_rate_hz, "Pictures for each second of the video")
      ->check(between(1.0, 240.0))
      ->capture_default_str()
      ->needs(frames);
}

// Adds the options that say where the viewer is, and --screen, which says where the screen is instead.
void add_view_options(CLI::App& app, VisionOptions& options) {
  const auto screen = app.add_option("--screen", options.screen_file,
                                     "File (TOML) that hapton screen wrote: draws in true size on a screen that stands there, so "
                                     "that things are seen where they are felt");
  screen->excludes(app.get_option("--screen-width-mm"));
  app.add_option("--view-mm", options.view_mm, "Smaller side of the picture in the screen's plane, mm (default: the scene fits)")
      ->check(between(0.0, 1e9))
      ->excludes(screen);
  app.add_option("--view-yaw-deg", options.view_yaw_deg,
                 "The viewer stands this many degrees to the right; 0: screen and device are parallel")
      ->check(between(-180.0, 180.0))
      ->capture_default_str()
      ->excludes(screen);
  app.add_option("--view-pitch-deg", options.view_pitch_deg, "The viewer stands this many degrees above")
      ->check(between(-89.0, 89.0))
      ->capture_default_str()
      ->excludes(screen);
}

// The texts of the options about a headset's room, not parsed yet.
struct RoomWords {
  std::string space = "local";
  std::string at_m;
  std::string turn_deg = "0,0,0";
};

// Defaults of --workspace-m, where hands are: below the eyes of someone who sits or stands, and at the height of a table.
constexpr const char* kBeforeTheEyes = "0,-0.25,-0.5";
constexpr const char* kAboveTheFloor = "0,1,-0.5";

void add_room_options(CLI::App& app, RoomWords& words) {
  app.add_option("--room", words.space, "Origin of --workspace-m in a headset: local (the eyes at the start), stage (the floor)")
      ->check(CLI::IsMember({"local", "stage"}))
      ->capture_default_str();
  app.add_option("--workspace-m", words.at_m,
                 fmt::format("Workspace's centre in a headset: X,Y,Z in m, right, up, back (default: {}; stage: {})", kBeforeTheEyes,
                             kAboveTheFloor))
      ->check(accepts(parse_triple));
  app.add_option("--workspace-turn-deg", words.turn_deg, "Rotation of the workspace there: X,Y,Z in degrees")
      ->check(accepts(parse_triple))
      ->capture_default_str();
}

// Pre: each text has passed the check of its option.
void set_room(const RoomWords& words, VisionOptions& options) {
  options.room = words.space == "stage" ? RoomSpace::stage : RoomSpace::local;
  const std::string at_m = !words.at_m.empty() ? words.at_m : options.room == RoomSpace::stage ? kAboveTheFloor : kBeforeTheEyes;
  options.X_OW = Eigen::Translation3d(*parse_triple(at_m)) * Pose(turn_by_degrees(*parse_triple(words.turn_deg)));
}

// The texts of options that are parsed after the whole command line was read.
struct VisionWords {
  std::vector<std::string> hubs;
  std::string stereo = "auto";
  std::string size = "1280x720";
  std::string when = "contact";
  std::string teach = "off";
  std::string unit;
  std::string tool_unit;
  std::string tool_grip = "origin";
  bool no_fit = false;
  std::string knobs = "window";
  bool no_cull = false;
  bool no_help = false;
  bool no_depth_cues = false;
};

// Adds the options for the hub, and for the scene and tool that are drawn.
void add_scene_options(CLI::App& app, VisionOptions& options, VisionWords& words) {
  app.add_option("--hub", words.hubs,
                 "Where io_node is: HOST or HOST:PORT (default: 127.0.0.1); if given twice, the hand of the second hub is shown as well")
      ->expected(1, 2);
  app.add_option("--bind", options.bind, "Local address: ADDRESS:PORT (default: any)");
  app.add_option("--key", options.key_file, kKeyHelp);
  app.add_option("--scene", options.scene, "Scene file (TOML) or mesh file")->capture_default_str();
  app.add_flag("--watch-scene", options.watch_scene,
               "Show the scene file again when it is saved, once haptics_node uses it, which needs the same option");
  app.add_flag("--no-fit", words.no_fit, "Keep a mesh file's position and size; haptics_node needs the same option");
  app.add_option("--unit", words.unit, "Unit of a mesh file: m (default), cm, mm or in")->check(accepts(parse_unit));
  const auto tool =
      app.add_option("--tool", options.tool.file, "Mesh of the tool that the stylus holds, as haptics_node has it (default: the scene's)");
  app.add_option("--tool-unit", words.tool_unit, "Unit of the tool's file: m, cm, mm or in (default: --unit)")
      ->check(accepts(parse_unit))
      ->needs(tool);
  app.add_option("--tool-grip", words.tool_grip, "Where the stylus holds it: origin (of its mesh) or centre (of its box)")
      ->check(accepts(parse_tool_grip))
      ->capture_default_str()
      ->needs(tool);
}

void add_picture_options(CLI::App& app, VisionOptions& options, VisionWords& words) {
  app.add_option("--stereo", words.stereo,
                 fmt::format("One of: {}. auto: quad-buffer if the display supports it, else mono; openxr: a headset",
                             [] {
                               std::string all;
                               for (const auto& name : stereo_mode_names()) all += (all.empty() ? "" : ", ") + name;
                               return all;
                             }()))
      ->check(accepts(find_stereo_mode))
      ->capture_default_str();
  app.add_option("--size", words.size, "Window, WIDTHxHEIGHT in pixels")->check(accepts(parse_size))->capture_default_str();
  app.add_option("--ipd-mm", options.ipd_mm, "Distance between the eyes, mm; 0: no depth")
      ->check(between(0.0, 200.0))
      ->capture_default_str();
}

void add_probe_options(CLI::App& app, VisionOptions& options) {
  app.add_option("--stylus-lean-deg", options.stylus_lean_deg, "Tilt the drawn stylus to the upper right by this angle; 0: as reported")
      ->check(between(0.0, 90.0))
      ->capture_default_str();
  app.add_option("--probe-radius", options.probe_radius_m,
                 "Draw the probe with this radius, metres; 0: a pin (default: the radius that haptics_node uses)")
      ->check(between(0.0, 1.0));
}

// Adds the options for what is drawn besides scene and probe, for how it is drawn, and for the dials that turn the scene.
void add_drawing_options(CLI::App& app, VisionOptions& options, VisionWords& words) {
  app.add_flag("--no-depth-cues", words.no_depth_cues, "Leave out ground, shadow, workspace, haze and scale bar (g brings them back)");
  app.add_option("--dial-x-deg", options.dials_degrees.x(), "Knob box at the start: degrees about the x axis")
      ->check(between(-360.0, 360.0));
  app.add_option("--dial-y-deg", options.dials_degrees.y(), "Knob box at the start: degrees about the y axis")
      ->check(between(-360.0, 360.0));
  app.add_option("--dial-z-deg", options.dials_degrees.z(), "Knob box at the start: degrees about the z axis")
      ->check(between(-360.0, 360.0));
  app.add_option("--knobs", words.knobs, "What turns the dials: window (keys and mouse); or in addition spacemouse (turns of its cap)")
      ->check(CLI::IsMember({"window", "spacemouse"}))
      ->capture_default_str();
  app.add_option("--frames-per-second-limit", options.rate_limit_hz, "Maximum frames a second, 0: no limit (default: 60, in software 30)")
      ->check(between(0.0, 10000.0));
  app.add_option("--msaa", options.view.msaa, "Samples per pixel; slow in software")->check(between(0, 16))->capture_default_str();
  app.add_flag("--no-cull", words.no_cull, "Draw triangles seen from behind of closed surfaces as well");
  app.add_flag("--cull-open", options.culls_open,
               "Leave out triangles seen from behind of open surfaces as well, though they can be felt: faster")
      ->excludes("--no-cull");
  app.add_flag("--no-keys-help", words.no_help, "Do not show the help on keys (k shows it)");
  app.add_flag("--plots", options.plots, "Plot the force, and the age of the drawn state, over the last 5 s (c switches the plots)");
  app.add_option("--teach", words.teach,
                 "Show the data of the force method: contact, local-set, tree:LEVEL, grid (32 x 32 x 32 cells) or curvature (v changes it)")
      ->check(accepts(parse_teach));
  app.add_flag("--offscreen", options.view.offscreen, "Show no window; an X display is still needed");
  app.add_option("--seconds", options.seconds, "End after this long, s; 0: when the window is closed")
      ->check(between(0.0, 1e9))
      ->capture_default_str();
}

void add_annotation_options(CLI::App& app, VisionOptions& options) {
  app.add_option(
      "--annotations", options.annotations.file,
      "File (.toml) of strokes, measures, poses and carves: read at the start where it exists, written at the end and by the key w; with "
      "--session its strokes and measures are shown, and it is not written");
  app.add_option("--strokes", options.annotations.strokes,
                 "Write strokes and measures as polylines, at the end and by the key w: FILE.obj or FILE.vtp");
  app.add_option("--draw-button", options.annotations.draw_button, "Button of the stylus that draws on what is touched, 0: none")
      ->check(between(0, 32))
      ->capture_default_str();
  app.add_option("--measure-button", options.annotations.measure_button, "Button of the stylus that sets an end of a measure, 0: none")
      ->check(between(0, 32))
      ->capture_default_str();
  app.add_option("--menu-button", options.annotations.menu_button,
                 "Button of the stylus that opens and closes the menu in the workspace, 0: none")
      ->check(between(0, 32))
      ->capture_default_str();
}

void add_screenshot_options(CLI::App& app, VisionOptions& options, VisionWords& words) {
  app.add_option("--screenshot", options.screenshot, "Write one picture to this PNG file");
  app.add_option("--screenshot-when", words.when,
                 "When to take the screenshot: contact, exit or SECONDS after the start; at the latest at exit")
      ->check(accepts(ScreenshotMoment::parse))
      ->capture_default_str();
  app.add_option(
         "--bench-frames", options.bench_frames,
         "Draw this many frames as fast as possible with turning dials, print rate, time of the first frame and motion to photon, then end")
      ->check(between(0, 1'000'000));
}

void set_words(const VisionWords& words, VisionOptions& options) {
  const PictureSize pixels = *parse_size(words.size);
  options.view.stereo = *find_stereo_mode(words.stereo);
  options.view.width_px = pixels.width_px;
  options.view.height_px = pixels.height_px;
  options.view.cull = !words.no_cull;
  options.help = !words.no_help;
  options.view.depth_cues = !words.no_depth_cues;
  options.has_space_knobs = words.knobs == "spacemouse";
  options.teach = *parse_teach(words.teach);
  options.screenshot_moment = *ScreenshotMoment::parse(words.when);
  if (!words.unit.empty()) options.loading.unit = *parse_unit(words.unit);
  if (!words.tool_unit.empty()) options.tool.unit = *parse_unit(words.tool_unit);
  options.tool.grip = *parse_tool_grip(words.tool_grip);
  if (words.no_fit) options.loading.fit = MeshFit::off;
}

}  // namespace

Result<void> check_headset(const VisionOptions& options) {
  if (options.view.stereo != StereoMode::openxr) return {};
  if (options.head_source.tracker || options.has_space_head || options.screen || options.screen_width_mm > 0.0) {
    return fail("--stereo openxr: the headset knows where the eyes are; leave out --head, --screen and --screen-width-mm");
  }
  if (options.bench_frames > 0) return fail("--stereo openxr: --bench-frames measures the window; leave out one of the two");
  if (!options.session.empty()) return fail("--stereo openxr: a recording is shown in the window; leave out one of --stereo and --session");
  return {};
}

Result<void> find_screen(VisionOptions& options) {
  if (options.screen_file.empty()) return {};
  const auto screen = read_screen(options.screen_file);
  if (!screen) return fail("--screen {}", screen.error().what);
  options.screen = *screen;
  return {};
}

Result<void> check_head(const VisionOptions& options) {
  if (is_possible(options.head, 1e-3 * options.ipd_mm)) return {};
  const Vec3 mm = 1e3 * options.head.p_RH;
  return fail(
      "--head-mm {:g},{:g},{:g}: both eyes must be at least {:g} mm in front of the screen and the head within {:g} m; the third number "
      "is the distance",
      mm.x(), mm.y(), mm.z(), 1e3 * kNearestEyeM, kFarthestHeadM);
}

std::variant<VisionOptions, int> parse_vision_options(int argc, const char* const* argv) {
  VisionOptions options;
  VisionWords words;
  words.hubs = {options.hub};
  HeadWords head;
  RoomWords room;

  CLI::App app{
      "Draws the scene and the probe, in stereo with --stereo, sends the view transform of the knob box, and lets the mouse move the "
      "simulated hand.\n\nIn the window:\n" +
          std::string(keys_help()),
      "vision_node"};
  add_scene_options(app, options, words);
  add_picture_options(app, options, words);
  add_head_options(app, head, options);
  add_view_options(app, options);
  add_room_options(app, room);
  add_probe_options(app, options);
  add_drawing_options(app, options, words);
  add_annotation_options(app, options);
  add_screenshot_options(app, options, words);
  add_session_options(app, options);

  if (const auto code = parse_command_line(app, argc, argv)) return *code;
  options.is_scene_given = app.count("--scene") > 0;
  options.is_view_yaw_given = app.count("--view-yaw-deg") > 0;
  options.is_view_pitch_given = app.count("--view-pitch-deg") > 0;
  options.is_loading_given = app.count("--unit") + app.count("--no-fit") > 0;
  set_head(head, options);
  set_room(room, options);
  options.hub = words.hubs.front();
  if (words.hubs.size() > 1) options.other_hub = words.hubs.back();
  set_words(words, options);
  return options;
}

}  // namespace hapton
