#include "vision_node/recorded_marks.h"

#include <utility>

#include "runtime/log.h"
#include "scene/annotations_file.h"
#include "vision_node/annotation_figure.h"
#include "vision_node/annotation_text.h"
#include "vision_node/annotator.h"

namespace hapton {

Result<std::unique_ptr<RecordedMarks>> RecordedMarks::open(StereoView& view, const Scene& scene, double scene_radius_m,
                                                           const std::filesystem::path& file, const MovedObjects& moved) {
  Annotations given;
  given.objects = list_names(scene);
  if (!file.empty()) {
    auto read = read_annotations(file, given.objects, scene.given_hash);
    if (!read) return tl::unexpected(read.error());
    log_info("{}: {}", file.string(), describe_entries(read->annotations));
    if (const std::string misfit = read->describe_misfit(); !misfit.empty()) log_warning("{}: {}", file.string(), misfit);
    given = std::move(read->annotations);
  }
  view.annotation_figure().set_bound(Annotator::kBoundShare * 2.0 * scene_radius_m);
  return std::unique_ptr<RecordedMarks>(new RecordedMarks(view, scene, std::move(given), moved));
}

RecordedMarks::RecordedMarks(StereoView& view, const Scene& scene, Annotations given, const MovedObjects& moved)
    : view_(view), moved_(moved), objects_(scene.objects.size()), annotations_(std::move(given)), surfaces_(scene) {
  surfaces_.set_moved_objects(&moved);
  placed_annotations_ = annotations_;
  view_.annotation_figure().set_entries(placed_annotations_, objects_);
}

void RecordedMarks::show(std::int64_t scene_time_ns, const Pose& X_WS) {
  AnnotationFigure& figure = view_.annotation_figure();
  figure.set_scene_pose(X_WS);
  X_SO_ = moved_.poses();
  if (annotations_.entries.empty()) return;
  figure.set_objects(X_SO_, moved_.held(), moved_.held_pose());
  surfaces_.set_time(scene_time_ns);
  if (!surfaces_.has_deforming() || std::exchange(placed_revision_, surfaces_.revision()) == surfaces_.revision()) return;
  placed_annotations_ = surfaces_.place(annotations_);
  figure.set_entries(placed_annotations_, objects_);
}

}  // namespace hapton
