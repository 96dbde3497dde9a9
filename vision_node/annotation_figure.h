#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <vtkActor.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkRenderer.h>

#include "scene/annotations.h"
#include "vision_node/probe_shown.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// A text at a point of the world.
struct WorldLabel {
  Vec3 p_W = Vec3::Zero();
  std::string text;
};

// A length as text for a person, with its unit: "42.31 mm".
std::string describe_length(double length_m);

// Strokes and measures as VTK actors. Hidden parts of strokes are not drawn; hidden parts of measures are drawn dotted. Lines are moved
// towards the eye along the line of sight, by twice the bound of StrokeThinner and one pixel's width at their depth, but at most by half of
// their depth, so that neither the depth buffer nor the levels of detail hide them. Frames: scene/annotations.h; W. Metres. RT: no.
class AnnotationFigure {
 public:
  AnnotationFigure();
  void add_to(vtkRenderer* renderer);

  // bound_m: that of StrokeThinner, the largest distance of strokes from the surface.
  void set_bound(double bound_m) { bound_m_ = bound_m; }
  void set_scene_pose(const Pose& X_WS);
  // X_SO of all objects. held: the object that the stylus holds, placed by X_TO in the tool's frame T (as drawn: p_WP, q_WP); -1: none.
  void set_objects(ObjectPoses X_SO, std::int32_t held, const Pose& X_TO);
  // Pre: annotations outlive this, or stay until the next call. Entries on objects that the scene does not have are not drawn.
  void set_entries(const Annotations& annotations, std::size_t scene_objects);
  // Sets the stroke that is being drawn, at the X_SO of set_objects(); null: none.
  void set_current_stroke(std::int32_t object, const std::vector<Vec3>* points_m);
  // Sets the first end of a measure, from which a line goes to the tip; none: no measure is in progress.
  void set_first_end(const std::optional<AnnotationPoint>& first);
  void set_probe(const ProbeShown& probe);

  // To be called before each eye's picture is drawn: sets the lift and the width of lines for it.
  void aim(const StereoScreen& screen, Eye eye, PictureSize size);
  // The lengths of the measure in progress and of the newest measures, at most 12 in all, at the middle of their lines.
  std::vector<WorldLabel> labels() const;

 private:
  bool is_shown(std::int32_t object) const { return object >= 0 && static_cast<std::size_t>(object) < scene_objects_; }
  const std::vector<Annotation>& entries() const;
  Vec3 find_in_world(const AnnotationPoint& point) const;
  void build_strokes();
  void build_measures();
  std::array<vtkActor*, 5> actors() { return {strokes_, held_strokes_, current_stroke_, measures_, hidden_measures_}; }

  double bound_m_ = 0.0;
  Pose X_WS_ = Pose::Identity();
  Pose X_WT_ = Pose::Identity();
  ObjectPoses X_SO_;
  std::int32_t held_object_ = -1;
  Pose X_TO_ = Pose::Identity();
  const Annotations* annotations_ = nullptr;
  std::size_t scene_objects_ = 0;
  std::optional<AnnotationPoint> first_end_;
  std::optional<Vec3> p_WP_;
  vtkNew<vtkActor> strokes_;         // frame S
  vtkNew<vtkActor> held_strokes_;    // frame T
  vtkNew<vtkActor> current_stroke_;  // frame S, as strokes_
  vtkNew<vtkActor> measures_;        // frame W
  vtkNew<vtkActor> hidden_measures_;
};

}  // namespace hapton
