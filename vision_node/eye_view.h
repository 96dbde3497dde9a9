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

// One viewport: the whole window, or one eye's half of it. Threads: the window's. RT: no.
struct EyeView {
  // A renderer for that part of the window. It clears nothing, and draws the scene first.
  // lights: in place of the one that goes with the viewer; frame W.
  explicit EyeView(const Viewport& part, const std::vector<SceneLight>& lights = {});

  Eye eye = Eye::centre;
  bool composed = false;              // both eyes are drawn through this view
  std::optional<Eye> pass;            // the one that is drawn, if it is composed by us; none: the camera's LeftEye says which one
  bool swapped = false;               // the eyes are exchanged
  int squeeze = 1;                    // the display stretches the height of the image by this factor
  bool shows_scale = false;           // a scale bar
  bool has_hud = false;               // text in the corners
  std::optional<StereoScreen> given;  // what the viewport shows, whatever the framing says
  std::function<void()> draw_scene;   // into the bound framebuffer, over the whole viewport
  vtkNew<vtkRenderer> renderer;
  HudFigure hud;
  LabelFigure labels;

  // In pixels, as drawn.
  PictureSize size();
  // The window into the world that the viewport shows.
  StereoScreen screen(const Framing& framing);
  // The eye that is being drawn.
  Eye eye_now() const;
  // Gives the camera that eye's position and projection, moves the viewer's light along, and places the HUD where the viewport was resized.
  void aim(const StereoScreen& screen);

 private:
  vtkNew<vtkCamera> camera_;
  vtkNew<vtkLight> viewers_light_;
  PictureSize placed_;  // of the HUD
};

}  // namespace hapton
