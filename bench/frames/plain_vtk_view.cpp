#include "bench/frames/plain_vtk_view.h"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include "vision_node/display.h"
#include "vision_node/vtk_shapes.h"

namespace hapton {

struct PlainVtkView::Window {
  vtkNew<vtkRenderWindow> window;
  std::array<vtkNew<vtkRenderer>, 2> renderers;
  vtkNew<vtkActor> actor;
  vtkNew<vtkMatrix4x4> pose;
};

PlainVtkView::PlainVtkView(std::unique_ptr<Window> window) : window_(std::move(window)) {}
PlainVtkView::~PlainVtkView() = default;

Result<std::unique_ptr<PlainVtkView>> PlainVtkView::open(const TriangleMesh& mesh, const Framing& framing, PictureSize window,
                                                         bool offscreen) {
  const auto display = DisplayConnection::open();
  if (!display) return tl::unexpected(display.error());
  auto made = std::make_unique<Window>();
  made->window->SetDisplayId(display->id());
  made->window->SetSize(window.width_px, window.height_px);
  made->window->SetMultiSamples(0);
  if (offscreen) {
    made->window->ShowWindowOff();
    made->window->UseOffScreenBuffersOn();
  }
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(make_poly_data(mesh));
  made->actor->SetMapper(mapper);
  made->actor->GetProperty()->SetInterpolationToFlat();
  made->actor->SetUserMatrix(made->pose);
  const StereoScreen screen = compute_screen(framing, {window.width_px / 2, window.height_px});
  constexpr std::array kEyes = {Eye::left, Eye::right};
  for (std::size_t i = 0; i < kEyes.size(); ++i) {
    vtkRenderer* renderer = made->renderers[i];
    renderer->SetViewport(0.5 * static_cast<double>(i), 0.0, 0.5 * static_cast<double>(i + 1), 1.0);
    renderer->AddActor(made->actor);
    vtkCamera* camera = renderer->GetActiveCamera();
    const Vec3 p_WE = compute_eye_position(screen, kEyes[i]);
    camera->SetPosition(p_WE.data());
    camera->SetFocalPoint(framing.p_WC.data());
    const Vec3 up = screen.X_WV.linear().col(1);
    camera->SetViewUp(up.data());
    camera->SetViewAngle(2.0 * std::atan(0.5 * screen.height_m / screen.distance_m) * 180.0 / std::numbers::pi);
    camera->SetClippingRange(screen.near_m, screen.far_m);
    made->window->AddRenderer(renderer);
  }
  return std::unique_ptr<PlainVtkView>(new PlainVtkView(std::move(made)));
}

void PlainVtkView::set_scene_pose(const Pose& X_WS) {
  copy_matrix(X_WS.matrix(), window_->pose);
  window_->pose->Modified();
}

void PlainVtkView::draw() {
  window_->window->Render();
  window_->window->WaitForCompletion();
}

}  // namespace hapton
