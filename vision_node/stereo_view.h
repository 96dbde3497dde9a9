#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "scene/scene_tool.h"
#include "vision_node/interaction.h"
#include "vision_node/live_plots.h"
#include "vision_node/probe_shown.h"
#include "vision_node/scene_painter.h"
#include "vision_node/stereo_camera.h"
#include "vision_node/stereo_mode.h"
#include "vision_node/surface_seen.h"
#include "vision_node/time_line.h"
#include "vision_node/xr/headset.h"

namespace hapton {

class AnnotationFigure;
class MenuFigure;
class TeachFigure;

struct ViewSettings {
  StereoMode stereo = StereoMode::automatic;  // openxr: mono, until the headset shows something
  int width_px = 1280;
  int height_px = 720;
  int msaa = 0;            // samples a pixel; software rendering pays dearly for any
  bool cull = true;        // leave out triangles seen from behind (memo 4.2.1)
  bool offscreen = false;  // no window is mapped; a display is needed all the same
  bool plain = false;      // one dark colour behind, no light, no HUD: for measuring pixels
  bool depth_cues = true;  // ground, shadow, workspace, haze and scale bar; none where plain
  Framing framing;
};

// What is in the window: rows from the bottom, 3 bytes a pixel.
struct Picture {
  PictureSize size;
  std::vector<std::uint8_t> rgb;
  const std::uint8_t* at(int x, int y) const { return &rgb[3 * (static_cast<std::size_t>(y) * size.width_px + x)]; }
};

// What a headset shows: the pixels of each eye's picture, and the rectangle that each eye looks through, for any Eye.
struct HeadsetEyes {
  PictureSize size;
  StereoScreen left;
  StereoScreen right;
};

// The window with the stereo picture: static scene flat shaded under one infinite light, probe, force arrow, HUD. The scene
// is drawn when it looks different and kept; probe and HUD are drawn over it. side_by_side draws two viewports, each eye with
// its own view and off-axis projection matrix. All other modes are composed by VTK, whose own eye matrices are replaced by
// ours for each eye's pass: so every mode shows the same two pictures. Threads: all calls from the one that opened it. RT:
// no.
class StereoView {
 public:
  // Error: no display (see display.h), crystal_eyes on one that does not support it, a window that OpenGL rejects.
  static Result<std::unique_ptr<StereoView>> open(const ViewSettings& settings, const std::vector<ShownObject>& objects);
  ~StereoView();

  void set_scene_pose(const Pose& X_WS);
  // Sets another view. The sizes of the probe's drawing keep their initial values.
  void set_framing(const Framing& framing);
  // Error: crystal_eyes where the display does not support it. automatic: the mode chosen at the start. openxr: see set_headset_eyes().
  Result<void> set_stereo(StereoMode mode);
  // For the mode openxr: what is drawn from now on. Pre of that mode: called before.
  void set_headset_eyes(const HeadsetEyes& eyes);
  // In that mode, after draw(): the picture of an eye (0: the left one) into a texture of that size, and the left one into the window.
  void copy_eye(std::size_t eye, unsigned texture);
  void show_mirror();
  // For the headset's runtime. The context is current then and after make_current().
  GlxWindow glx_window();
  void make_current();
  // Exchanges the two eyes' pictures, in all modes that show two eyes.
  void swap_eyes();
  // Nothing is drawn for the probe before the first call.
  void set_probe(const ProbeShown& probe);
  // Of another hand, likewise.
  void set_other_probe(const ProbeShown& probe);
  void set_hud(std::string_view facts, std::string_view help, std::string_view notice = {});
  // Over the last seconds, at the right; empty: none.
  void set_plots(const std::vector<PlotShown>& plots);
  // At the lower edge; none: hidden. moment: share of the line.
  void set_time_line(const std::optional<TimeLineShown>& line, double moment);
  void set_cull(bool cull);
  void set_depth_cues(bool shown);
  // A rigid tool, drawn in place of stylus and tip, or beside them.
  void set_tool(const SceneTool& tool, bool with_stylus = false);
  // The stylus holds nothing: stylus and tip are drawn.
  void clear_tool();
  // Moves an object, as its mesh has it, by X_SO from now on, or leaves it out. Pre: one of those the view was opened with.
  void place_object(std::size_t object, const Pose& X_SO, bool is_shown);
  // Gives an object's mesh other vertices, as many as it has, in the frame of that mesh.
  void reshape_object(std::size_t object, std::vector<Vec3> vertices);
  // Draws these levels in place of an object's mesh, as ScenePainter has it.
  void replace_object(std::size_t object, std::vector<FlatLevel> levels);
  // Strokes, measures and the menu in the workspace. They live as long as the view.
  AnnotationFigure& annotation_figure();
  MenuFigure& menu_figure();
  // Likewise of a teaching view.
  TeachFigure& teach_figure();
  // The probe's true radius; 0: a point, drawn as a pin.
  void set_probe_radius(double radius_m);

  // The visible point of the scene at that pixel of the window, from the lower left corner, in the newest picture; empty for background.
  // Frame W. Empty also while the window is drawn with smoothed edges.
  std::optional<Vec3> pick(int x_px, int y_px);

  // That pixel of the window in the eye's picture that is there; empty beside all pictures.
  std::optional<std::array<int, 2>> find_picture_pixel(int x_px, int y_px);

  // The scene's surface as the first eye sees it, in the newest picture. Null before the first one, and while edges are smoothed.
  std::shared_ptr<const SurfaceSeen> surface_seen();

  // Draws the scene and a probe with all its marks, but not into the window: builds shaders, some tenth of a second that no probe then
  // waits for.
  void prepare_shaders();

  // Draws and waits until it is done. before_probe is called when the scene is drawn and the probe is not: the probe and HUD that it sets
  // are in the picture.
  void draw(std::function<void()> before_probe = {});

  // Spends some milliseconds on a picture of the scene in full detail; call it while the scene is at rest. True if the next draw() shows
  // more than the last.
  bool refine();
  // How much of the scene's levels of detail has been made, 0 to 1.
  double detail_progress() const;
  // Of the newest picture of the scene drawn in levels, one eye's.
  const PaintCount& paint_count() const;
  // Number of drawings of the scene, each eye's picture counted.
  std::uint64_t scenes_drawn() const;

  // The newest picture, as drawn.
  Picture read_picture();
  // The same picture, drawn once more with smoothed edges. Error: a file that cannot be written.
  Result<void> save_png(const std::filesystem::path& file);

  // What happened in the window since the last call.
  std::vector<WindowEvent> poll_events();
  // The window was resized or uncovered since the last call and wants to be drawn again.
  bool take_stale();

  // The mode in use: what automatic came to.
  StereoMode mode() const;
  // One eye's picture.
  PictureSize picture_size() const;
  StereoScreen screen() const;
  const ProbeSizes& probe_sizes() const;
  // OpenGL's renderer string, for reports.
  std::string renderer_name();

 private:
  struct Window;
  explicit StereoView(std::unique_ptr<Window> window);
  std::unique_ptr<Window> window_;
};

}  // namespace hapton
