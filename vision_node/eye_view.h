#pragma once

#include <functional>
#include <optional>
#include <vector>

#include <vtkCamera.h>
#include <vtkLight.h>
#include <vtkNew.h>
#include <vtkRenderer.h>

#include "scene/scene_view.h"
#include "vision_node/hud_figure.h"
#include "vision_node/label_figure.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// A part of the window, as shares of it from the lower left corner.
struct Viewport {
  double from_x = 0.0;
  double from_y = 0.0;
  double to_x = 1.0;
  double to_y = 1.0;
};

// A viewport: the whole window, or the half of it for one eye. Its address must not change. Threads: the window's. RT: no.
struct EyeView {
  // Makes a renderer for that part of the window, which clears nothing and draws the scene first. lights: the scene's, frame W; empty: one
  // light that moves with the viewer.
  explicit EyeView(const Viewport& part, const std::vector<SceneLight>& lights = {});

  Eye eye = Eye::centre;
  bool is_composed = false;      // both eyes are drawn through this view
  std::optional<Eye> drawn_eye;  // the eye that is drawn, if Hapton composes the image; none: VTK does, and the camera's LeftEye says which
  bool are_eyes_swapped = false;             // the eyes are exchanged
  int squeeze = 1;                           // the display stretches the height of the image by this factor
  bool shows_scale = false;                  // shows a scale bar
  bool has_hud = false;                      // shows text in the corners
  std::optional<StereoScreen> given_screen;  // the screen of this viewport, in place of the one that follows from the framing
  std::function<void()> draw_scene;          // draws into the bound framebuffer, over the whole viewport
  vtkNew<vtkRenderer> renderer;
  HudFigure hud;
  LabelFigure labels;

  // The size of the viewport in pixels.
  PictureSize size();
  // The window into the world that this viewport is: `given_screen`, or else computed from the framing.
  StereoScreen screen(const Framing& framing);
  // The eye that is being drawn.
  Eye current_eye() const;
  // Gives the camera the position and projection of current_eye(), moves the viewer's light, and fits scale bar and HUD to the present
  // size.
  void aim(const StereoScreen& screen);

 private:
  vtkNew<vtkCamera> camera_;
  vtkNew<vtkLight> viewers_light_;
  PictureSize hud_size_;  // size for which the HUD was placed
};

}  // namespace hapton
