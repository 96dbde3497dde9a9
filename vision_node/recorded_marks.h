#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "core/base/result.h"
#include "scene/annotations.h"
#include "scene/scene_file.h"
#include "vision_node/annotated_surfaces.h"
#include "vision_node/moved_objects.h"
#include "vision_node/stereo_view.h"

namespace hapton {

// Strokes and measures over a recording. A recording has none, so they come from a file; they are drawn on the objects as these are at the
// moment that is shown. Moments may come in any order. Nothing is written. Threads: the window's. RT: no.
class RecordedMarks {
 public:
  // Pre: all outlive this; the view was opened with the scene's objects. scene_radius_m: as Annotator::open. An empty path: no marks.
  // Error: see read_annotations.
  static Result<std::unique_ptr<RecordedMarks>> open(StereoView& view, const Scene& scene, double scene_radius_m,
                                                     const std::filesystem::path& file, const MovedObjects& moved);

  // Draws the marks where the objects are now. X_WS: the pose of the scene.
  void show(std::int64_t scene_time_ns, const Pose& X_WS);

  // For an export: the marks in the shape, and the objects at the places, that the last show() gave them.
  const Annotations& placed_annotations() const { return placed_annotations_; }
  const ObjectPoses& X_SO() const { return X_SO_; }

 private:
  RecordedMarks(StereoView& view, const Scene& scene, Annotations given, const MovedObjects& moved);

  StereoView& view_;
  const MovedObjects& moved_;
  std::size_t objects_;  // number of the scene's objects
  Annotations annotations_;
  AnnotatedSurfaces surfaces_;
  Annotations placed_annotations_;
  ObjectPoses X_SO_;
  std::uint64_t placed_revision_ = 0;  // revision of the surfaces for which placed_annotations_ was made
};

}  // namespace hapton
