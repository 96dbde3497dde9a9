#include "vision_node/stereo_view.h"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <memory>
#include <utility>

#include <vtkCallbackCommand.h>
#include <vtkNew.h>
#include <vtkOpenGLFramebufferObject.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkRenderer.h>

#include "runtime/atomic_file.h"
#include "runtime/part_file.h"
#include "vision_node/annotation_figure.h"
#include "vision_node/display.h"
#include "vision_node/edge_pointer.h"
#include "vision_node/eye_composer.h"
#include "vision_node/eye_view.h"
#include "vision_node/headset_panel.h"
#include "vision_node/headset_window.h"
#include "vision_node/menu_figure.h"
#include "vision_node/present.h"
#include "vision_node/probe_figure.h"
#include "vision_node/renderer_limits.h"
#include "vision_node/scene_layers.h"
#include "vision_node/teach_figure.h"
#include "vision_node/vtk_stereo_type.h"
#include "vision_node/window_listener.h"
#include "vision_node/window_picture.h"

namespace hapton {
namespace {

constexpr int kScreenshotSamples = 8;  // for each pixel; a free choice, because a screenshot may take longer than a frame

}  // namespace

struct StereoView::Window {
  explicit Window(DisplayConnection opened) : display(opened) {}

  DisplayConnection display;
  ViewSettings settings;
  StereoMode mode = StereoMode::mono;
  bool has_quad_buffers = false;
  bool are_eyes_swapped = false;
  // The window is destroyed after what is drawn in it.
  vtkNew<vtkRenderWindow> window;
  std::unique_ptr<WindowListener> listener;  // null if the window is off screen
  std::vector<std::unique_ptr<EyeView>> eyes;
  std::unique_ptr<SceneLayers> layers;
  std::unique_ptr<EyeComposer> composer;
  bool composes = false;  // in this mode `composer` combines the two pictures, not VTK
  std::unique_ptr<ProbeFigure> probe;
  std::unique_ptr<ProbeFigure> other_probe;
  AnnotationFigure annotations;
  MenuFigure menu;
  std::unique_ptr<HeadsetWindow> headset;
  HeadsetPanel headset_panel;
  HeadsetEyes headset_eyes;
  TeachFigure teach;
  Pose X_WS = Pose::Identity();
  std::optional<Vec3> p_WP;  // position of the tip; empty until it is first set
  bool needs_redraw = true;
  // The rest is about the frame that is being drawn.
  bool is_prepared = false;
  bool draws_full_detail = false;  // it is drawn in full detail, however long that takes
  std::function<void()> before_probe;

  vtkOpenGLRenderWindow* opengl() { return vtkOpenGLRenderWindow::SafeDownCast(window); }
  Result<void> open();
  void arrange();
  void add_eye(Eye eye, const Viewport& part);
  void begin(EyeView& view);
  void aim_headset();
  void prepare();
  void render();
  void render_both_eyes();
  void set_vtk_composes(bool vtk_composes);
  // A pixel of one eye's picture. view is null for a position outside all pictures.
  struct PixelOfEye {
    EyeView* view = nullptr;
    int x = 0;
    int y = 0;
  };
  PixelOfEye find_pixel(int x_px, int y_px);
};

Result<void> StereoView::Window::open() {
  window->SetDisplayId(display.id());
  window->SetMultiSamples(settings.msaa);
  window->SetSize(settings.width_px, settings.height_px);
  window->SetWindowName("Hapton");
  if (settings.offscreen) {
    window->ShowWindowOff();
    window->UseOffScreenBuffersOn();
  }
  const bool wants_quad = settings.stereo == StereoMode::crystal_eyes || settings.stereo == StereoMode::automatic;
  if (wants_quad) window->StereoCapableWindowOn();
  if (opengl() == nullptr) return fail("this build of VTK has no OpenGL window: install libvtk9-dev of Debian 12");
  opengl()->Initialize();
  if (opengl()->SupportsOpenGL() == 0) {
    return fail("this display cannot do OpenGL 3.2 ({}): install a newer graphics driver or Mesa's software one",
                opengl()->GetOpenGLSupportMessage());
  }
  opengl()->MakeCurrent();
  if (auto fits = read_renderer_limits().check({settings.width_px, settings.height_px}); !fits) return fits;
  has_quad_buffers = wants_quad && window->GetStereoCapableWindow() != 0;
  if (settings.stereo == StereoMode::crystal_eyes && !has_quad_buffers) {
    return fail(
        "stereo mode crystal_eyes needs a quad-buffered OpenGL visual and this display has none: use --stereo side_by_side or auto");
  }
  mode = settings.stereo;
  if (mode == StereoMode::openxr) mode = StereoMode::mono;
  if (mode == StereoMode::automatic) mode = has_quad_buffers ? StereoMode::crystal_eyes : StereoMode::mono;
  return {};
}

// Creates the renderers that the mode needs, replacing the present ones.
void StereoView::Window::arrange() {
  for (const auto& eye : eyes) {
    eye->renderer->RemoveAllObservers();
    window->RemoveRenderer(eye->renderer);
  }
  eyes.clear();
  const int type = vtk_stereo_type(mode);
  composes = settings.msaa == 0 && (mode == StereoMode::anaglyph || mode == StereoMode::red_blue);
  if (type != 0) window->SetStereoType(type);
  window->SetStereoRender(type != 0 && !composes);
  if (mode != StereoMode::openxr) headset->leave();
  if (mode == StereoMode::openxr) {
    headset->enter(headset_eyes.size);
    add_eye(Eye::left, {.to_x = 0.5});
    add_eye(Eye::right, {.from_x = 0.5});
    aim_headset();
  } else if (mode == StereoMode::side_by_side) {
    add_eye(are_eyes_swapped ? Eye::right : Eye::left, {.to_x = 0.5});
    add_eye(are_eyes_swapped ? Eye::left : Eye::right, {.from_x = 0.5});
  } else if (mode == StereoMode::top_bottom) {
    add_eye(are_eyes_swapped ? Eye::right : Eye::left, {.from_y = 0.5});
    add_eye(are_eyes_swapped ? Eye::left : Eye::right, {.to_y = 0.5});
  } else {
    add_eye(find_single_eye(mode, are_eyes_swapped), {});
  }
  needs_redraw = true;
}

void StereoView::Window::add_eye(Eye eye, const Viewport& part) {
  auto view = std::make_unique<EyeView>(part, settings.lights);
  view->eye = eye;
  view->is_composed = vtk_stereo_type(mode) != 0;
  if (composes) view->drawn_eye = are_eyes_swapped ? Eye::right : Eye::left;
  view->are_eyes_swapped = are_eyes_swapped;
  view->squeeze = mode == StereoMode::top_bottom ? 2 : 1;
  view->draw_scene = [this, each = view.get()] {
    const int* origin = each->renderer->GetOrigin();
    layers->copy_to_bound(each->current_eye(), origin[0], origin[1]);
  };
  vtkRenderer* renderer = view->renderer;
  probe->add_to(renderer);
  other_probe->add_to(renderer);
  annotations.add_to(renderer);
  menu.add_to(renderer);
  teach.add_to(renderer);
  if (!settings.plain) view->labels.add_to(renderer);
  view->has_hud = !settings.plain && mode != StereoMode::openxr;  // in a headset nobody sees the corners
  if (view->has_hud) view->hud.add_to(renderer);
  if (!settings.plain && mode == StereoMode::openxr) headset_panel.add_to(renderer);
  // Runs at the beginning of each pass of each picture, when VTK has chosen the eye and knows the viewport's size: both are up to date.
  vtkNew<vtkCallbackCommand> begin_pass;
  begin_pass->SetClientData(this);
  begin_pass->SetCallback([](vtkObject* begun, unsigned long, void* self, void*) {
    for (const auto& each : static_cast<Window*>(self)->eyes) {
      if (each->renderer.Get() == begun) static_cast<Window*>(self)->begin(*each);
    }
  });
  renderer->AddObserver(vtkCommand::StartEvent, begin_pass);
  window->AddRenderer(renderer);
  eyes.push_back(std::move(view));
}

void StereoView::Window::aim_headset() {
  eyes.front()->given_screen = headset_eyes.left;
  eyes.back()->given_screen = headset_eyes.right;
}

void StereoView::Window::begin(EyeView& view) {
  const PictureSize pixels = view.size();
  if (pixels.width_px <= 0 || pixels.height_px <= 0) return;
  if (!std::exchange(is_prepared, true)) prepare();
  view.shows_scale = settings.depth_cues && view.has_hud;
  const StereoScreen screen = view.screen(settings.framing);
  view.aim(screen);
  annotations.aim(screen, view.current_eye(), pixels);
  view.labels.place(annotations.labels(), screen, view.current_eye(), pixels);
  const bool points = p_WP && view.has_hud;
  view.hud.set_pointer(points ? find_edge_pointer(screen, view.current_eye(), pixels, *p_WP) : std::nullopt, pixels);
}

// Draws the scene for all eyes, then calls before_probe, which sets the probe. Pre: VTK's framebuffer is bound.
void StereoView::Window::prepare() {
  std::vector<ScenePass> passes;
  for (const auto& view : eyes) {
    ScenePass pass{view->eye, view->screen(settings.framing), view->size(), X_WS, settings.cull, settings.plain, settings.depth_cues};
    pass.is_even = mode == StereoMode::openxr;
    if (view->is_composed) {
      pass.eye = Eye::left;
      passes.push_back(pass);
      pass.eye = Eye::right;
    }
    passes.push_back(pass);
  }
  layers->prepare(passes, read_bound_format());
  if (draws_full_detail) layers->refine_whole();
  if (before_probe) before_probe();
}

void StereoView::Window::render() {
  is_prepared = false;
  if (mode == StereoMode::openxr) headset->enter(headset_eyes.size);
  window->Render();
}

// Both pictures show the same sample of the probe: prepare() runs only in the pass of the first eye, and its result serves both.
void StereoView::Window::render_both_eyes() {
  EyeView& view = *eyes.front();
  const Eye first = are_eyes_swapped ? Eye::right : Eye::left;
  const PictureSize size = view.size();
  view.drawn_eye = first;
  render();
  const GLuint framebuffer = opengl()->GetRenderFramebuffer()->GetFBOIndex();
  composer->keep_first_eye(framebuffer, size);
  view.drawn_eye = are_eyes_swapped ? Eye::left : Eye::right;
  window->Render();
  view.drawn_eye = first;
  composer->compose(framebuffer, size, mode == StereoMode::anaglyph);
}

// True lets VTK combine the two pictures, as smooth edges require: VTK then holds the pixels in a framebuffer of its own.
void StereoView::Window::set_vtk_composes(bool vtk_composes) {
  if (!composes) return;
  window->SetStereoRender(vtk_composes ? 1 : 0);
  EyeView& view = *eyes.front();
  view.drawn_eye = vtk_composes ? std::nullopt : std::optional(are_eyes_swapped ? Eye::right : Eye::left);
}

StereoView::StereoView(std::unique_ptr<Window> window) : window_(std::move(window)) {}

StereoView::~StereoView() {
  window_->listener.reset();
  for (const auto& eye : window_->eyes) eye->renderer->RemoveAllObservers();
  window_->window->MakeCurrent();
  window_->layers.reset();
  window_->composer.reset();
  window_->headset.reset();
}

Result<std::unique_ptr<StereoView>> StereoView::open(const ViewSettings& settings, const std::vector<ShownObject>& objects) {
  auto display = DisplayConnection::open();
  if (!display) return tl::unexpected(display.error());
  auto window = std::make_unique<Window>(*display);
  window->settings = settings;
  if (auto opened = window->open(); !opened) return tl::unexpected(opened.error());
  window->window->MakeCurrent();
  auto layers = SceneLayers::make(objects, settings.lights);
  if (!layers) return tl::unexpected(layers.error());
  window->layers = std::move(*layers);
  auto composer = EyeComposer::make();
  if (!composer) return tl::unexpected(composer.error());
  window->composer = std::move(*composer);
  window->probe = std::make_unique<ProbeFigure>(scale_probe(settings.framing), ProbeColours::first());
  window->other_probe = std::make_unique<ProbeFigure>(scale_probe(settings.framing), ProbeColours::other());
  for (ProbeFigure* figure : {window->probe.get(), window->other_probe.get()}) figure->set_shadow(settings.depth_cues && !settings.plain);
  window->headset =
      std::make_unique<HeadsetWindow>(window->opengl(), !settings.offscreen, PictureSize{settings.width_px, settings.height_px});
  window->arrange();
  if (!settings.offscreen) window->listener = std::make_unique<WindowListener>(window->window);
  return std::unique_ptr<StereoView>(new StereoView(std::move(window)));
}

Result<void> StereoView::replace_scene(const std::vector<ShownObject>& objects, const std::vector<SceneLight>& lights) {
  window_->window->MakeCurrent();
  auto layers = SceneLayers::make(objects, lights);
  if (!layers) return tl::unexpected(layers.error());
  window_->layers = std::move(*layers);
  window_->settings.lights = lights;
  window_->arrange();
  return {};
}

void StereoView::set_scene_pose(const Pose& X_WS) {
  window_->X_WS = X_WS;
  window_->teach.set_scene_pose(X_WS);
}
void StereoView::set_framing(const Framing& framing) { window_->settings.framing = framing; }

Result<void> StereoView::set_stereo(StereoMode mode) {
  if (mode == StereoMode::automatic) mode = window_->has_quad_buffers ? StereoMode::crystal_eyes : StereoMode::mono;
  if (mode == StereoMode::crystal_eyes && !window_->has_quad_buffers) return fail("this window has no quad-buffered stereo");
  window_->mode = mode;
  window_->arrange();
  return {};
}

void StereoView::set_headset_eyes(const HeadsetEyes& eyes) {
  window_->headset_eyes = eyes;
  if (window_->mode == StereoMode::openxr) window_->aim_headset();
}

void StereoView::copy_eye(std::size_t eye, unsigned texture) { window_->headset->copy_eye(eye, texture); }
void StereoView::show_mirror() { window_->headset->show_mirror(); }
GlxWindow StereoView::glx_window() { return window_->headset->handles(); }
void StereoView::make_current() { window_->window->MakeCurrent(); }

void StereoView::swap_eyes() {
  window_->are_eyes_swapped = !window_->are_eyes_swapped;
  window_->arrange();
}

StereoView::Window::PixelOfEye StereoView::Window::find_pixel(int x_px, int y_px) {
  for (const auto& view : eyes) {
    const int* origin = view->renderer->GetOrigin();
    const int x = x_px - origin[0];
    const int y = y_px - origin[1];
    const PictureSize size = view->size();
    if (x >= 0 && y >= 0 && x < size.width_px && y < size.height_px) return {view.get(), x, y};
  }
  return {};
}

std::optional<std::array<int, 2>> StereoView::find_picture_pixel(int x_px, int y_px) {
  const auto [view, x, y] = window_->find_pixel(x_px, y_px);
  return view != nullptr ? std::optional(std::array{x, y}) : std::nullopt;
}

std::optional<Vec3> StereoView::pick(int x_px, int y_px) {
  const auto [view, x, y] = window_->find_pixel(x_px, y_px);
  if (view == nullptr) return std::nullopt;
  window_->window->MakeCurrent();
  return window_->layers->find_surface(view->is_composed ? Eye::left : view->eye, x, y);
}

std::shared_ptr<const VisibleDepth> StereoView::visible_depth() {
  if (window_->eyes.empty()) return nullptr;
  window_->window->MakeCurrent();
  const EyeView& first = *window_->eyes.front();
  return window_->layers->read_surface(first.is_composed ? Eye::left : first.eye);
}

void StereoView::set_probe(const ProbeShown& probe) {
  window_->probe->set(probe);
  window_->annotations.set_probe(probe);
  window_->p_WP = probe.p_WP;
  for (const auto& eye : window_->eyes) eye->hud.set_force(probe.force_n.norm(), probe.force_limit_n, eye->size());
  window_->headset_panel.set_force(probe.force_n.norm(), probe.force_limit_n);
}
void StereoView::set_other_probe(const ProbeShown& probe) { window_->other_probe->set(probe); }

void StereoView::set_hud(std::string_view facts, std::string_view help, std::string_view notice) {
  for (const auto& eye : window_->eyes) eye->hud.set(facts, help, notice);
  window_->headset_panel.set(facts, help, notice);
}

void StereoView::set_plots(const std::vector<PlotContent>& plots) {
  for (const auto& eye : window_->eyes) eye->hud.set_plots(plots, eye->size());
  window_->headset_panel.set_plots(plots);
}
void StereoView::set_time_line(const std::optional<TimeLineShown>& line, double moment) {
  for (const auto& eye : window_->eyes) eye->hud.set_time_line(line, moment, eye->size());
}
void StereoView::set_cull(bool cull) { window_->settings.cull = cull; }
void StereoView::set_depth_cues(bool shown) {
  window_->settings.depth_cues = shown;
  for (ProbeFigure* figure : {window_->probe.get(), window_->other_probe.get()}) figure->set_shadow(shown && !window_->settings.plain);
}
void StereoView::set_tool(const SceneTool& tool, bool with_stylus) { window_->probe->set_tool(tool, with_stylus); }
void StereoView::clear_tool() { window_->probe->clear_tool(); }
void StereoView::place_object(std::size_t object, const Pose& X_SO, bool is_shown) {
  window_->window->MakeCurrent();
  window_->layers->place_object(object, X_SO, is_shown);
}
void StereoView::reshape_object(std::size_t object, std::vector<Vec3> vertices) {
  window_->window->MakeCurrent();
  window_->layers->reshape_object(object, std::move(vertices));
}
void StereoView::replace_object(std::size_t object, std::vector<FlatLevel> levels) {
  window_->window->MakeCurrent();
  window_->layers->replace_object(object, std::move(levels));
}
AnnotationFigure& StereoView::annotation_figure() { return window_->annotations; }
MenuFigure& StereoView::menu_figure() { return window_->menu; }
TeachFigure& StereoView::teach_figure() { return window_->teach; }
void StereoView::set_probe_radius(double radius_m) { window_->probe->set_tip_radius(radius_m); }

void StereoView::prepare_shaders() {
  ProbeShown probe;
  const ProbeSizes& sizes = window_->probe->sizes();
  probe.p_WD = Vec3(0.0, -sizes.tip_radius_m, 0.0);
  probe.force_n = Vec3(0.0, 2.0 * sizes.arrow_max_m / sizes.arrow_m_per_n, 0.0);  // longer than the arrow may be
  probe.contact = true;
  window_->probe->set(probe);
  window_->window->SetSwapBuffers(0);
  window_->render();
  window_->probe->hide();
}

void StereoView::draw(std::function<void()> before_probe) {
  if (window_->mode == StereoMode::emulate) {
    Eye& eye = window_->eyes.front()->eye;
    eye = eye == Eye::left ? Eye::right : Eye::left;
  }
  // VTK copies a picture to the window in three steps, with shaders. If VTK combines nothing, one step is enough: present().
  const bool is_composed = vtk_stereo_type(window_->mode) != 0 && !window_->composes;
  const bool is_headset = window_->mode == StereoMode::openxr;
  window_->window->SetSwapBuffers(!is_headset && (is_composed || window_->settings.msaa > 0));
  window_->before_probe = std::move(before_probe);
  window_->composes ? window_->render_both_eyes() : window_->render();
  window_->before_probe = {};
  // The headset waits for its pictures; nobody waits for the picture in the window.
  if (is_headset) return window_->headset->take_frame();
  if (window_->window->GetSwapBuffers() == 0 && !window_->settings.offscreen) present(window_->opengl());
  window_->window->WaitForCompletion();
}

bool StereoView::refine() {
  window_->window->MakeCurrent();
  if (window_->layers->has_new_levels()) return true;
  if (!window_->layers->wants_refining()) return false;
  return window_->layers->refine();
}

double StereoView::detail_progress() const { return window_->layers->progress(); }
const PaintCount& StereoView::paint_count() const { return window_->layers->count(); }
std::uint64_t StereoView::scenes_drawn() const { return window_->layers->drawn(); }

Picture StereoView::read_picture() { return read_window_picture(window_->window); }

Result<void> StereoView::save_png(const std::filesystem::path& file) {
  // Opens the file first: if that fails, VTK would write its own lines to stderr, or block on a pipe without a reader.
  PartPath part(file);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> tried(open_file_for(part.part(), FileReaders::everyone), &std::fclose);
  if (!tried) {
    return fail("cannot write the screenshot {}: does its folder exist, and is it writable?", file.string());
  }
  // Smooth edges take time, which is well spent on a single picture that is kept.
  window_->window->SetMultiSamples(std::max(kScreenshotSamples, window_->settings.msaa));
  window_->window->SwapBuffersOn();
  window_->draws_full_detail = true;
  window_->set_vtk_composes(true);
  window_->render();
  window_->set_vtk_composes(false);
  window_->draws_full_detail = false;
  const bool is_written = write_window_png(window_->window, part.part());
  window_->window->SetMultiSamples(window_->settings.msaa);
  if (!is_written) return fail("cannot write the screenshot {}: is the disk full?", file.string());
  return part.keep();
}

std::vector<WindowEvent> StereoView::poll_events() {
  if (!window_->listener) return {};
  std::vector<WindowEvent> events = window_->listener->poll();
  if (window_->mode == StereoMode::openxr)
    window_->headset->enter(window_->headset_eyes.size);  // after a resize, VTK uses the size of the window
  for (WindowEvent& event : events) {
    const Eigen::Vector2i at = window_->headset->find_pixel(event.x_px, event.y_px);
    event.x_px = at.x();
    event.y_px = at.y();
  }
  return events;
}

bool StereoView::take_redraw_request() {
  const bool uncovered = window_->listener && window_->listener->take_redraw_request();
  return std::exchange(window_->needs_redraw, false) || uncovered;
}

StereoMode StereoView::mode() const { return window_->mode; }

PictureSize StereoView::picture_size() const { return window_->eyes.front()->size(); }

StereoScreen StereoView::screen() const { return window_->eyes.front()->screen(window_->settings.framing); }

const ProbeSizes& StereoView::probe_sizes() const { return window_->probe->sizes(); }

std::string StereoView::renderer_name() {
  const std::string report = window_->window->ReportCapabilities();
  const auto at = report.find("OpenGL renderer string:");
  if (at == std::string::npos) return "unknown";
  const auto from = report.find_first_not_of(' ', report.find(':', at) + 1);
  return report.substr(from, report.find('\n', from) - from);
}

}  // namespace hapton
