// Any bytes as a file of annotations.
#include <string>
#include <vector>

#include "scene/annotations_file.h"
#include "tests/fuzz/fuzz_target.h"

FUZZ_TARGET(annotations) {
  using namespace hapton;
  static const std::vector<std::string> names = {"lid", "box"};
  const auto read = parse_annotations({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, names, 1);
  if (!read) {
    fuzz::require(!read.error().what.empty());
    fuzz::require(read.error().what.find('\n') == std::string::npos);
    return;
  }
  const Annotations& annotations = read->annotations;
  fuzz::require(count_points(annotations) <= kMaxAnnotationPoints);
  const auto is_known = [&](std::int32_t object) { return object >= 0 && static_cast<std::size_t>(object) < annotations.objects.size(); };
  for (const Annotation& entry : annotations.entries) {
    if (const auto* stroke = std::get_if<Stroke>(&entry)) {
      fuzz::require(is_known(stroke->object) && !stroke->points_m.empty());
      for (const Vec3& p : stroke->points_m) fuzz::require(p.allFinite());
    } else {
      for (const AnnotationPoint& end : std::get<Measure>(entry).ends) fuzz::require(is_known(end.object) && end.p_O.allFinite());
    }
  }
  fuzz::require(count_carves(annotations.carved) <= kMaxSavedCarves);
  for (const CarvedPress& press : annotations.carved) {
    fuzz::require(is_known(press.object) && press.radius_m > 0.0 && !press.carves.empty());
    for (const Carve& carve : press.carves) fuzz::require(carve == rounded(carve) && carve.radius_m == press.radius_m);
  }
  const auto again = parse_annotations(write_annotations(annotations, 1), names, 1);
  fuzz::require(again.has_value() && again->annotations.carved == annotations.carved);
  (void)write_annotations_obj(annotations, {}, names.size());
  (void)write_annotations_vtp(annotations, {}, names.size());
}
