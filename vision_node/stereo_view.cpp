#include "vision_node/stereo_view.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>

#include <vtkActor.h>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkLight.h>
#include <vtkNew.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkPNGWriter.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

#include "runtime/atomic_file.h"
#include "vision_node/display.h"
#include "vision_node/probe_figure.h"
#include "vision_node/vtk_shapes.h"

namespace hapton {
namespace {

constexpr int kScreenshotSamples = 8;

int vtk_stereo_type(StereoMode mode) {
  switch (mode) {
    case StereoMode::crystal_eyes:
      return VTK_STEREO_CRYSTAL_EYES;
    case StereoMode::red_blue:
      return VTK_STEREO_RED_BLUE;
    case StereoMode::interlaced:
      return VTK_STEREO_INTERLACED;
    case StereoMode::left:
      return VTK_STEREO_LEFT;
    case StereoMode::right:
      return VTK_STEREO_RIGHT;
    case StereoMode::dresden:
      return VTK_STEREO_DRESDEN;
    case StereoMode::anaglyph:
      return VTK_STEREO_ANAGLYPH;
    case StereoMode::checkerboard:
      return VTK_STEREO_CHECKERBOARD;
    case StereoMode::split_viewport:
      return VTK_STEREO_SPLITVIEWPORT_HORIZONTAL;
    case StereoMode::fake:
      return VTK_STEREO_FAKE;
    case StereoMode::emulate:
    case StereoMode::automatic:
    case StereoMode::mono:
    case StereoMode::side_by_side:
      return 0;
  }
  return 0;
}

// Two lines of text in a corner of one eye's picture: the same place in both, so it lies in the screen's plane.
struct HudText {
  vtkNew<vtkTextActor> facts;
  vtkNew<vtkTextActor> help;

  void dress(vtkRenderer* renderer) {
    for (vtkTextActor* text : {facts.Get(), help.Get()}) {
      vtkTextProperty* look = text->GetTextProperty();
      look->SetFontFamilyToArial();
      look->SetColor(0.96, 0.97, 0.98);
      look->SetBackgroundColor(0.03, 0.04, 0.06);
      look->SetBackgroundOpacity(0.45);
      look->SetLineSpacing(1.15);
      text->SetVisibility(false);
      renderer->AddActor2D(text);
    }
    facts->GetTextProperty()->SetVerticalJustificationToTop();
  }

  void place(PictureSize size) {
    const int font = std::clamp(std::min(size.width_px / 44, size.height_px / 46), 9, 40);
    const int edge = font / 2;
    facts->GetTextProperty()->SetFontSize(font);
    help->GetTextProperty()->SetFontSize(std::max(9, font - 2));
    facts->SetPosition(edge, size.height_px - edge);
    help->SetPosition(edge, edge);
  }

  static void set(vtkTextActor* actor, std::string_view text) {
    const std::string owned(text);
    actor->SetVisibility(!owned.empty());
    if (!owned.empty() && (actor->GetInput() == nullptr || owned != actor->GetInput())) actor->SetInput(owned.c_str());
  }
};

// One viewport: the whole window, or one eye's half of it.
struct EyeView {
  Eye eye = Eye::centre;
  bool composed = false;  // VTK draws both eyes through this view and says which by the camera's LeftEye
  Framing framing;
  vtkNew<vtkRenderer> renderer;
  vtkNew<vtkCamera> camera;
  HudText hud;
  PictureSize placed;

  PictureSize size() {
    const int* pixels = renderer->GetSize();
    return {pixels[0], pixels[1]};
  }

  // Runs as each pass of each picture begins, when VTK has chosen the eye and knows the viewport's size: nothing can be stale.
  void aim() {
    const Eye now = !composed ? eye : camera->GetLeftEye() != 0 ? Eye::left : Eye::right;
    const PictureSize pixels = size();
    if (pixels.width_px <= 0 || pixels.height_px <= 0) return;
    const StereoScreen screen = compute_screen(framing, pixels);
    // VTK's own view matrix from position, focal point and up is exactly ours; its projection is replaced.
    const Vec3 p_WE = compute_eye_position(screen, now);
    const Vec3 ahead = p_WE - screen.distance_m * screen.X_WV.linear().col(2);
    const Vec3 up = screen.X_WV.linear().col(1);
    camera->SetPosition(p_WE.data());
    camera->SetFocalPoint(ahead.data());
    camera->SetViewUp(up.data());
    camera->SetClippingRange(screen.near_m, screen.far_m);
    vtkNew<vtkMatrix4x4> projection;
    copy_matrix(compute_projection_matrix(screen, now), projection);
    camera->SetExplicitProjectionTransformMatrix(projection);
    camera->UseExplicitProjectionTransformMatrixOn();
    if (pixels != placed) {
      placed = pixels;
      hud.place(pixels);
    }
  }
};

void aim_before_drawing(vtkObject*, unsigned long, void* view, void*) { static_cast<EyeView*>(view)->aim(); }

}  // namespace

struct StereoView::Window {
  explicit Window(DisplayConnection opened) : display(opened) {}

  DisplayConnection display;
  ViewSettings settings;
  StereoMode mode = StereoMode::mono;
  // The window dies after what is drawn in it.
  vtkNew<vtkRenderWindow> window;
  vtkSmartPointer<vtkRenderWindowInteractor> interactor;  // none off screen
  std::vector<std::unique_ptr<EyeView>> eyes;
  std::vector<vtkSmartPointer<vtkActor>> scene;
  std::unique_ptr<ProbeFigure> probe;
  std::unique_ptr<ProbeFigure> other_probe;
  std::vector<WindowEvent> events;
  bool stale = true;

  Result<void> open();
  void add_eye(Eye eye, double from, double to);
  void listen();
  void hear(unsigned long event);
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
  auto* opengl = vtkOpenGLRenderWindow::SafeDownCast(window);
  if (opengl == nullptr) return fail("this build of VTK has no OpenGL window: install libvtk9-dev of Debian 12");
  opengl->Initialize();
  if (opengl->SupportsOpenGL() == 0) {
    return fail("this display cannot do OpenGL 3.2 ({}): install a newer graphics driver or Mesa's software one",
                opengl->GetOpenGLSupportMessage());
  }
  const bool has_quad = wants_quad && window->GetStereoCapableWindow() != 0;
  if (settings.stereo == StereoMode::crystal_eyes && !has_quad) {
    return fail(
        "stereo mode crystal_eyes needs a quad-buffered OpenGL visual and this display has none: use --stereo side_by_side or auto");
  }
  mode = settings.stereo;
  if (mode == StereoMode::automatic) mode = has_quad ? StereoMode::crystal_eyes : StereoMode::side_by_side;
  if (const int type = vtk_stereo_type(mode); type != 0) {
    window->SetStereoType(type);
    window->StereoRenderOn();
  }
  return {};
}

void StereoView::Window::add_eye(Eye eye, double from, double to) {
  auto view = std::make_unique<EyeView>();
  view->eye = eye;
  view->composed = vtk_stereo_type(mode) != 0;
  view->framing = settings.framing;
  vtkRenderer* renderer = view->renderer;
  renderer->SetViewport(from, 0.0, to, 1.0);
  renderer->SetActiveCamera(view->camera);
  renderer->AutomaticLightCreationOff();
  if (settings.plain) {
    renderer->SetBackground(0.0, 0.0, 0.0);
  } else {
    renderer->GradientBackgroundOn();
    renderer->SetBackground(0.055, 0.07, 0.095);
    renderer->SetBackground2(0.30, 0.36, 0.44);
  }
  vtkNew<vtkLight> light;
  light->SetLightTypeToSceneLight();
  light->PositionalOff();
  const Vec3 towards = compute_screen(settings.framing, {1, 1}).X_WV.linear() * Vec3(-0.40, 0.62, 0.85);
  light->SetFocalPoint(0.0, 0.0, 0.0);
  light->SetPosition(towards.x(), towards.y(), towards.z());
  renderer->AddLight(light);
  for (const auto& actor : scene) renderer->AddActor(actor);
  probe->add_to(renderer);
  other_probe->add_to(renderer);
  if (!settings.plain) view->hud.dress(renderer);
  vtkNew<vtkCallbackCommand> aim;
  aim->SetCallback(aim_before_drawing);
  aim->SetClientData(view.get());
  renderer->AddObserver(vtkCommand::StartEvent, aim);
  window->AddRenderer(renderer);
  eyes.push_back(std::move(view));
}

void StereoView::Window::listen() {
  // VTK warns that the library with its own mouse styles is not linked; we bring our own.
  vtkObject::GlobalWarningDisplayOff();
  interactor = vtkSmartPointer<vtkRenderWindowInteractor>::New();
  vtkObject::GlobalWarningDisplayOn();
  interactor->SetRenderWindow(window);
  interactor->SetInteractorStyle(nullptr);
  interactor->EnableRenderOff();
  vtkNew<vtkCallbackCommand> hearing;
  hearing->SetClientData(this);
  hearing->SetCallback([](vtkObject*, unsigned long event, void* self, void*) { static_cast<Window*>(self)->hear(event); });
  for (const unsigned long event :
       {vtkCommand::KeyPressEvent, vtkCommand::LeftButtonPressEvent, vtkCommand::LeftButtonReleaseEvent, vtkCommand::MiddleButtonPressEvent,
        vtkCommand::MiddleButtonReleaseEvent, vtkCommand::RightButtonPressEvent, vtkCommand::RightButtonReleaseEvent,
        vtkCommand::MouseMoveEvent, vtkCommand::MouseWheelForwardEvent, vtkCommand::MouseWheelBackwardEvent, vtkCommand::ExitEvent,
        vtkCommand::RenderEvent, vtkCommand::ExposeEvent, vtkCommand::ConfigureEvent}) {
    interactor->AddObserver(event, hearing);
  }
  interactor->Initialize();
}

void StereoView::Window::hear(unsigned long event) {
  using Kind = WindowEvent::Kind;
  using Button = WindowEvent::Button;
  WindowEvent heard;
  const int* at = interactor->GetEventPosition();
  heard.x_px = at[0];
  heard.y_px = at[1];
  heard.shift = interactor->GetShiftKey() != 0;
  switch (event) {
    case vtkCommand::KeyPressEvent:
      heard.kind = Kind::key;
      heard.key = interactor->GetKeyCode();
      break;
    case vtkCommand::LeftButtonPressEvent:
      heard.kind = Kind::press;
      heard.button = Button::left;
      break;
    case vtkCommand::LeftButtonReleaseEvent:
      heard.kind = Kind::release;
      heard.button = Button::left;
      break;
    case vtkCommand::MiddleButtonPressEvent:
      heard.kind = Kind::press;
      heard.button = Button::middle;
      break;
    case vtkCommand::MiddleButtonReleaseEvent:
      heard.kind = Kind::release;
      heard.button = Button::middle;
      break;
    case vtkCommand::RightButtonPressEvent:
      heard.kind = Kind::press;
      heard.button = Button::right;
      break;
    case vtkCommand::RightButtonReleaseEvent:
      heard.kind = Kind::release;
      heard.button = Button::right;
      break;
    case vtkCommand::MouseMoveEvent:
      heard.kind = Kind::move;
      break;
    case vtkCommand::MouseWheelForwardEvent:
      heard.kind = Kind::wheel;
      heard.wheel = 1;
      break;
    case vtkCommand::MouseWheelBackwardEvent:
      heard.kind = Kind::wheel;
      heard.wheel = -1;
      break;
    case vtkCommand::ExitEvent:
      heard.kind = Kind::close;
      break;
    default:
      stale = true;
      return;
  }
  events.push_back(heard);
}

StereoView::StereoView(std::unique_ptr<Window> window) : window_(std::move(window)) {}

StereoView::~StereoView() {
  if (window_->interactor) window_->interactor->RemoveAllObservers();
  for (const auto& eye : window_->eyes) eye->renderer->RemoveAllObservers();
}

Result<std::unique_ptr<StereoView>> StereoView::open(const ViewSettings& settings, const std::vector<ShownObject>& objects) {
  auto display = DisplayConnection::open();
  if (!display) return tl::unexpected(display.error());
  auto window = std::make_unique<Window>(*display);
  window->settings = settings;
  if (auto opened = window->open(); !opened) return tl::unexpected(opened.error());
  for (const ShownObject& object : objects) {
    auto actor = vtkSmartPointer<vtkActor>::New();
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputData(make_poly_data(*object.mesh));
    mapper->ScalarVisibilityOff();
    actor->SetMapper(mapper);
    vtkProperty* look = actor->GetProperty();
    look->SetInterpolationToFlat();
    look->SetColor(object.colour.x(), object.colour.y(), object.colour.z());
    if (settings.plain) {
      look->LightingOff();
    } else {
      look->SetAmbient(0.20);
      look->SetDiffuse(0.88);
      look->SetSpecular(0.22);
      look->SetSpecularPower(18.0);
    }
    look->SetBackfaceCulling(settings.cull);
    window->scene.push_back(actor);
  }
  window->probe = std::make_unique<ProbeFigure>(scale_probe(settings.framing));
  window->other_probe = std::make_unique<ProbeFigure>(scale_probe(settings.framing));
  if (window->mode == StereoMode::side_by_side) {
    window->add_eye(Eye::left, 0.0, 0.5);
    window->add_eye(Eye::right, 0.5, 1.0);
  } else {
    window->add_eye(Eye::centre, 0.0, 1.0);
  }
  if (!settings.offscreen) window->listen();
  return std::unique_ptr<StereoView>(new StereoView(std::move(window)));
}

void StereoView::set_scene_pose(const Pose& X_WS) {
  vtkNew<vtkMatrix4x4> matrix;
  copy_matrix(X_WS.matrix(), matrix);
  for (const auto& actor : window_->scene) actor->SetUserMatrix(matrix);
}

void StereoView::set_probe(const ProbeShown& probe) { window_->probe->set(probe); }
void StereoView::set_other_probe(const ProbeShown& probe) { window_->other_probe->set(probe); }

void StereoView::set_hud(std::string_view facts, std::string_view help) {
  for (const auto& eye : window_->eyes) {
    HudText::set(eye->hud.facts, facts);
    HudText::set(eye->hud.help, help);
  }
}

void StereoView::set_cull(bool cull) {
  for (const auto& actor : window_->scene) actor->GetProperty()->SetBackfaceCulling(cull);
}

void StereoView::draw() {
  if (window_->mode == StereoMode::emulate) {
    Eye& eye = window_->eyes.front()->eye;
    eye = eye == Eye::left ? Eye::right : Eye::left;
  }
  window_->window->Render();
  window_->window->WaitForCompletion();
}

Picture StereoView::read_picture() {
  const int* pixels = window_->window->GetSize();
  Picture picture;
  picture.size = {pixels[0], pixels[1]};
  vtkNew<vtkUnsignedCharArray> rgb;
  window_->window->GetRGBACharPixelData(0, 0, pixels[0] - 1, pixels[1] - 1, 0, rgb);
  picture.rgb.resize(3 * static_cast<std::size_t>(pixels[0]) * pixels[1]);
  const std::uint8_t* rgba = rgb->GetPointer(0);
  for (std::size_t i = 0; i < picture.rgb.size() / 3; ++i) std::copy_n(rgba + 4 * i, 3, &picture.rgb[3 * i]);
  return picture;
}

Result<void> StereoView::save_png(const std::filesystem::path& file) {
  // Tried first, because VTK would write its own lines about it to stderr, and wait for who reads from a pipe.
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> tried(open_file_for(file, FileReaders::everyone), &std::fclose);
  if (!tried) {
    return fail("cannot write the screenshot {}: does its folder exist, may it be written to?", file.string());
  }
  // Once, for a picture that stays, smooth edges are worth their time.
  window_->window->SetMultiSamples(std::max(kScreenshotSamples, window_->settings.msaa));
  window_->window->Render();
  vtkNew<vtkWindowToImageFilter> grab;
  grab->SetInput(window_->window);
  grab->SetInputBufferTypeToRGB();
  grab->ReadFrontBufferOff();
  grab->ShouldRerenderOff();
  vtkNew<vtkPNGWriter> writer;
  writer->SetFileName(file.c_str());
  writer->SetInputConnection(grab->GetOutputPort());
  writer->Write();
  window_->window->SetMultiSamples(window_->settings.msaa);
  if (writer->GetErrorCode() != 0) return fail("cannot write the screenshot {}: is the disk full?", file.string());
  return {};
}

std::vector<WindowEvent> StereoView::poll_events() {
  if (window_->interactor) window_->interactor->ProcessEvents();
  return std::exchange(window_->events, {});
}

bool StereoView::take_stale() { return std::exchange(window_->stale, false); }

StereoMode StereoView::mode() const { return window_->mode; }

PictureSize StereoView::picture_size() const { return window_->eyes.front()->size(); }

StereoScreen StereoView::screen() const { return compute_screen(window_->settings.framing, picture_size()); }

const ProbeSizes& StereoView::probe_sizes() const { return window_->probe->sizes(); }

std::string StereoView::renderer_name() {
  const std::string report = window_->window->ReportCapabilities();
  const auto at = report.find("OpenGL renderer string:");
  if (at == std::string::npos) return "unknown";
  const auto from = report.find_first_not_of(' ', report.find(':', at) + 1);
  return report.substr(from, report.find('\n', from) - from);
}

}  // namespace hapton
