#include "vision_node/eye_view.h"

#include <vtkCullerCollection.h>
#include <vtkMatrix4x4.h>
#include <vtkObjectFactory.h>
#include <vtkProp.h>

#include "vision_node/depth_cues.h"
#include "vision_node/vtk_shapes.h"

namespace hapton {
namespace {

// Lets VTK draw the static scene as the first prop of a renderer that clears nothing. clang-format is off because VTK's macros
// have no semicolon.
// clang-format off
class SceneProp : public vtkProp {
 public:
  static SceneProp* New();
  vtkTypeMacro(SceneProp, vtkProp)
  EyeView* view = nullptr;
  int RenderOpaqueGeometry(vtkViewport*) override {
    view->draw_scene();
    return 1;
  }
};
vtkStandardNewMacro(SceneProp)
    // clang-format on

    void add_light(vtkLight* light, const SceneLight& given, vtkRenderer& renderer) {
  light->SetLightTypeToSceneLight();
  light->SetPositional(given.has_position);
  light->SetConeAngle(180.0);  // in all directions
  light->SetFocalPoint(0.0, 0.0, 0.0);
  light->SetPosition(given.towards_or_p_W.x(), given.towards_or_p_W.y(), given.towards_or_p_W.z());
  light->SetColor(given.colour.x(), given.colour.y(), given.colour.z());
  renderer.AddLight(light);
}

}  // namespace

EyeView::EyeView(const Viewport& part, const std::vector<SceneLight>& lights) {
  renderer->SetViewport(part.from_x, part.from_y, part.to_x, part.to_y);
  renderer->SetActiveCamera(camera_);
  renderer->AutomaticLightCreationOff();
  renderer->GetCullers()->RemoveAllItems();
  renderer->EraseOff();
  if (lights.empty()) add_light(viewers_light_, {}, *renderer);
  for (const SceneLight& light : lights) add_light(vtkNew<vtkLight>(), light, *renderer);
  vtkNew<SceneProp> scene;
  scene->view = this;
  renderer->AddViewProp(scene);
}

PictureSize EyeView::size() {
  const int* pixels = renderer->GetSize();
  return {pixels[0], pixels[1]};
}

StereoScreen EyeView::screen(const Framing& framing) {
  if (given_screen) return *given_screen;
  const PictureSize drawn = size();
  return compute_screen(framing, {drawn.width_px, squeeze * drawn.height_px});
}

Eye EyeView::current_eye() const {
  if (!is_composed) return eye;
  if (drawn_eye) return *drawn_eye;
  return (camera_->GetLeftEye() != 0) != are_eyes_swapped ? Eye::left : Eye::right;
}

// The view matrix that VTK computes from position, focal point and up is exactly ours. VTK's projection is replaced: ours is off-axis.
void EyeView::aim(const StereoScreen& screen) {
  const Eye now = current_eye();
  const Vec3 p_WE = compute_eye_position(screen, now);
  const EyeDepths depths = compute_eye_depths(screen, now);
  const Vec3 ahead = p_WE - depths.eye_m * screen.X_WV.linear().col(2);
  const Vec3 up = screen.X_WV.linear().col(1);
  camera_->SetPosition(p_WE.data());
  camera_->SetFocalPoint(ahead.data());
  camera_->SetViewUp(up.data());
  camera_->SetClippingRange(depths.near_m, depths.far_m);
  vtkNew<vtkMatrix4x4> projection;
  copy_matrix(compute_projection_matrix(screen, now), projection);
  camera_->SetExplicitProjectionTransformMatrix(projection);
  camera_->UseExplicitProjectionTransformMatrixOn();
  const Vec3 towards = screen.X_WV.linear() * screen.light_V;
  viewers_light_->SetPosition(towards.x(), towards.y(), towards.z());
  if (size() != hud_size_) {
    hud_size_ = size();
    hud.place(hud_size_);
  }
  hud.set_scale_bar(shows_scale ? choose_scale_bar(screen, size()) : ScaleBar{}, size());
}

}  // namespace hapton
