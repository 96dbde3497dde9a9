#pragma once

#include <array>

#include <vtkActor.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include "scene/scene_tool.h"
#include "vision_node/probe_shown.h"

namespace hapton {

// Colours (red, green, blue, 0 to 1) that distinguish the hands.
struct ProbeColours {
  Vec3 tip;
  Vec3 grip;
  Vec3 arrow;
  static ProbeColours first() { return {{1.0, 0.78, 0.10}, {0.16, 0.17, 0.20}, {0.20, 0.90, 0.45}}; }
  static ProbeColours other() { return {{0.25, 0.62, 1.0}, {0.10, 0.22, 0.50}, {0.95, 0.45, 0.85}}; }
};

// The stylus with its spherical tip, and the force arrow, as VTK actors. Hidden until set() is called. The arrow begins beside the tip, has
// a ring for each newton and a red one where it is cut off. Behind other objects, tip and arrow are visible as dots. In contact the device
// point is shown too, below the surface, with a line to the tip: the penetration. Threads: the window's. RT: no.
class ProbeFigure {
 public:
  explicit ProbeFigure(const ProbeSizes& sizes, const ProbeColours& colours = ProbeColours::first());
  void add_to(vtkRenderer* renderer);
  void set(const ProbeShown& probe);
  void hide();
  // Radius of the ball at the tip; 0: the probe is a point, and the ball has the radius in sizes().
  void set_tip_radius(double radius_m);
  // Draws a rigid tool at the pose of the probe from now on.
  // with_stylus: together with stylus and tip, as an object that was picked up; otherwise in place of them.
  void set_tool(const SceneTool& tool, bool with_stylus = false);
  void clear_tool();
  // Whether the tip has a shadow on the ground.
  void set_shadow(bool thrown) { throws_shadow_ = thrown; }
  const ProbeSizes& sizes() const { return sizes_; }

 private:
  static constexpr int kMaxRings = 12;  // one for each newton; a free choice: longer arrows have no more

  void place_arrow(const ProbeShown& probe);
  void place_device_point(const ProbeShown& probe);
  void place_shadow(const ProbeShown& probe);
  vtkPolyData* rings(int newtons);

  ProbeSizes sizes_;
  double tip_radius_m_;
  vtkNew<vtkActor> stylus_;
  vtkNew<vtkActor> grip_;
  vtkNew<vtkActor> tip_;
  vtkNew<vtkActor> arrow_shaft_;
  vtkNew<vtkActor> arrow_head_;
  vtkNew<vtkActor> arrow_rings_;
  vtkNew<vtkActor> arrow_limit_;
  // Drawn over everything, with every other block of pixels left out: the parts of tip and arrow that are behind other objects.
  vtkNew<vtkActor> ghost_tip_;
  vtkNew<vtkActor> ghost_shaft_;
  vtkNew<vtkActor> ghost_head_;
  vtkNew<vtkActor> device_point_;
  vtkNew<vtkActor> penetration_;
  vtkNew<vtkActor> shadow_;
  vtkNew<vtkActor> tool_;
  bool has_tool_ = false;
  bool has_stylus_ = true;
  std::array<vtkSmartPointer<vtkPolyData>, kMaxRings + 1> ring_shapes_;  // by number of newtons
  int rings_shown_ = -1;
  bool throws_shadow_ = false;

  std::array<vtkActor*, 14> actors() {
    return {stylus_,    grip_,        tip_,        arrow_shaft_,  arrow_head_,  arrow_rings_, arrow_limit_,
            ghost_tip_, ghost_shaft_, ghost_head_, device_point_, penetration_, shadow_,      tool_};
  }
};

}  // namespace hapton
