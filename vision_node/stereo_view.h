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
#include "scene/scene_view.h"
#include "vision_node/interaction.h"
#include "vision_node/live_plots.h"
#include "vision_node/probe_shown.h"
#include "vision_node/scene_painter.h"
#include "vision_node/stereo_camera.h"
#include "vision_node/stereo_mode.h"
#include "vision_node/time_line.h"
#include "vision_node/visible_depth.h"
#include "vision_node/xr/headset.h"

namespace hapton {

class AnnotationFigure;
class MenuFigure;
class TeachFigure;

struct ViewSettings {
  StereoMode stereo = StereoMode::automatic;  // openxr: the window is mono until set_stereo(openxr)
  int width_px = 1280;
  int height_px = 720;
  int msaa = 0;            // samples a pixel; 0: none. Slow in software rendering
  bool cull = true;        // leave out triangles seen from behind (memo 4.2.1), except of objects that show them
  bool offscreen = false;  // do not map a window; an X display is still needed
  bool plain = false;      // a dark background, no light, no HUD: for tests that measure pixels
  bool depth_cues = true;  // ground, shadow, workspace, haze and scale bar; none with plain
  Framing framing;
  std::vector<SceneLight> lights = {};  // in place of the light that moves with the viewer; at most SceneView::kMaxLights
};

// The pixels of the window: rows from the bottom, 3 bytes (red, green, blue) a pixel.
struct Picture {
  PictureSize size;
  std::vector<std::uint8_t> rgb;
  const std::uint8_t* at(int x, int y) const { return &rgb[3 * (static_cast<std::size_t>(y) * size.width_px + x)]; }
};

// The images of a headset: the size of each eye's image in pixels, and the rectangle that each eye looks through (look_through()).
struct HeadsetEyes {
  PictureSize size;
  StereoScreen left;
  StereoScreen right;
};

// The window with the stereo picture: static scene under its lights, probe, force arrow, HUD. The scene is drawn only
// when its image changes, and kept; probe and HUD are drawn over it. side_by_side and top_bottom draw two viewports, openxr the two
// images of a headset, each eye with its own view and off-axis projection matrix. emulate draws one eye in each frame. EyeComposer composes
// anaglyph and red_blue if there is no msaa; VTK composes the other modes of two eyes, with our eye matrices in place of its own. So all
// modes of two eyes show the same two images. Threads: all calls from the thread that opened the view. RT: no.
class StereoView {
 public:
  // Error: no display (display.h), no quad buffers for crystal_eyes, a window that OpenGL rejects, or shaders that the driver rejects.
  static Result<std::unique_ptr<StereoView>> open(const ViewSettings& settings, const std::vector<ShownObject>& objects);
  ~StereoView();

  // Shows other objects under other lights from now on; the drawn sizes of the probe do not change. Error: see ScenePainter::make; the
  // objects and lights shown then stay as they were.
  Result<void> replace_scene(const std::vector<ShownObject>& objects, const std::vector<SceneLight>& lights);
  void set_scene_pose(const Pose& X_WS);
  // Sets another view. The drawn sizes of the probe do not change.
  void set_framing(const Framing& framing);
  // automatic: crystal_eyes if the window has quad buffers, otherwise mono; a window opened in another mode than these two has none. Pre of
  // openxr: set_headset_eyes() was called. Error: crystal_eyes in a window without quad buffers.
  Result<void> set_stereo(StereoMode mode);
  // Mode openxr: sets the size of the images and what each eye sees, from the next frame on.
  void set_headset_eyes(const HeadsetEyes& eyes);
  // Mode openxr, after draw(): copies the image of an eye (0: left) into a texture of HeadsetEyes::size.
  void copy_eye(std::size_t eye, unsigned texture);
  // Mode openxr, after draw(): shows the image of the left eye in the window.
  void show_mirror();
  // Handles of the window, for the headset's runtime. The window's OpenGL context is current afterwards.
  GlxWindow glx_window();
  void make_current();
  // Exchanges the images of the two eyes, except in mode openxr; left, right and fake then show the other eye.
  void swap_eyes();
  // Sets the probe, which is drawn from the first call on.
  void set_probe(const ProbeShown& probe);
  // Sets the probe of another hand (OtherHand), which is drawn from the first call on.
  void set_other_probe(const ProbeShown& probe);
  // Texts of the HUD; an empty one is not shown.
  void set_hud(std::string_view facts, std::string_view help, std::string_view notice = {});
  // Plots of the last seconds, at the right edge; empty: none are shown.
  void set_plots(const std::vector<PlotContent>& plots);
  // The time line of a recording, at the lower edge; none: hidden. moment: position of the shown moment, 0 (begin) to 1 (end).
  void set_time_line(const std::optional<TimeLineShown>& line, double moment);
  void set_cull(bool cull);
  void set_depth_cues(bool shown);
  // Draws a rigid tool in place of stylus and tip, or in addition to them if with_stylus is true.
  void set_tool(const SceneTool& tool, bool with_stylus = false);
  // Draws stylus and tip again, in place of a tool.
  void clear_tool();
  // Draws an object with the pose X_SO of its mesh from now on, or leaves it out. Pre: object < number of shown objects.
  void place_object(std::size_t object, const Pose& X_SO, bool is_shown);
  // Replaces the vertices of an object's mesh. Pre: vertices.size() is that of the mesh. Frame: that of the mesh.
  void reshape_object(std::size_t object, std::vector<Vec3> vertices);
  // Draws these levels of detail in place of an object's mesh; see ScenePainter::replace_object.
  void replace_object(std::size_t object, std::vector<FlatLevel> levels);
  // The drawing of strokes and measures, and that of the menu. They live as long as the view.
  AnnotationFigure& annotation_figure();
  MenuFigure& menu_figure();
  // The drawing of a teaching view. It lives as long as the view.
  TeachFigure& teach_figure();
  // The radius of a spherical probe; 0: a point, drawn as a pin.
  void set_probe_radius(double radius_m);

  // The point of the scene that is visible at a pixel of the window (from the lower left corner) in the newest frame. Frame W. None for the
  // background, beside the images, with msaa, and when visible_depth() is null.
  std::optional<Vec3> pick(int x_px, int y_px);

  // The pixel of an eye's image that is shown at a pixel of the window; none if no image is shown there.
  std::optional<std::array<int, 2>> find_picture_pixel(int x_px, int y_px);

  // The surface of the scene as the first eye sees it in the newest frame. Null before the first frame, after a change of an
  // object until the next one, and with msaa.
  std::shared_ptr<const VisibleDepth> visible_depth();

  // Draws the scene and a probe with all its marks, but not into the window, so that the driver compiles all shaders now: about 0.1 s, by
  // which the first contact would otherwise be delayed. Afterwards the probe is hidden until the next set_probe().
  void prepare_shaders();

  // Draws a frame and waits until it is complete (mode openxr: does not wait). before_probe is called between scene and probe: the probe
  // and HUD that it sets are in this frame.
  void draw(std::function<void()> before_probe = {});

  // Spends some milliseconds on an image of the scene in full detail; call it while the scene is at rest. True if the next draw() may show
  // more detail than the last.
  bool refine();
  // The share of the scene's levels of detail that is ready, 0 to 1.
  double detail_progress() const;
  // Counts for the newest image of the scene that was drawn in levels of detail, for one eye.
  const PaintCount& paint_count() const;
  // Number of images of the scene drawn since open() or replace_scene(), without those of refine(). Each eye has its own image.
  std::uint64_t scenes_drawn() const;

  // The pixels of the newest frame.
  Picture read_picture();
  // Draws a frame of what is set at present, in full detail and with smooth edges, and writes it. Error: the file cannot be written.
  Result<void> save_png(const std::filesystem::path& file);

  // Events of the window (keys, mouse) since the last call.
  std::vector<WindowEvent> poll_events();
  // True: the window must be drawn again, because it was resized or uncovered since the last call, or its mode, eyes or scene changed.
  bool take_redraw_request();

  // The mode in use, never automatic.
  StereoMode mode() const;
  // The size of one eye's image.
  PictureSize picture_size() const;
  StereoScreen screen() const;
  const ProbeSizes& probe_sizes() const;
  // GL_RENDERER, for reports.
  std::string renderer_name();

 private:
  struct Window;
  explicit StereoView(std::unique_ptr<Window> window);
  std::unique_ptr<Window> window_;
};

}  // namespace hapton
