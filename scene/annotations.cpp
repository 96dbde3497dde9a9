#include "scene/annotations.h"

namespace hapton {

Pose PutDown::pose() const {
  Pose X_SO = Pose::Identity();
  X_SO.translation() = p_m;
  X_SO.linear() = q.normalized().toRotationMatrix();
  return X_SO;
}

std::size_t count_points(const Annotations& annotations) {
  std::size_t points = 0;
  for (const Annotation& entry : annotations.entries) {
    const auto* stroke = std::get_if<Stroke>(&entry);
    points += stroke != nullptr ? stroke->points_m.size() : 2;
  }
  return points;
}

double compute_length_m(const Stroke& stroke) {
  double length_m = 0.0;
  for (std::size_t i = 1; i < stroke.points_m.size(); ++i) length_m += (stroke.points_m[i] - stroke.points_m[i - 1]).norm();
  return length_m;
}

Vec3 place(const SurfacePoint& point, const ObjectPoses& X_SO) {
  const auto object = static_cast<std::size_t>(point.object);
  return point.object >= 0 && object < X_SO.size() ? Vec3(X_SO[object] * point.p_O) : point.p_O;
}

// If both ends are on one object, its own frame is used: the length is then the same to the last bit at any pose of the object.
double compute_length_m(const Measure& measure, const ObjectPoses& X_SO) {
  const auto& [from, to] = measure.ends;
  if (from.object == to.object) return (to.p_O - from.p_O).norm();
  return (place(to, X_SO) - place(from, X_SO)).norm();
}

}  // namespace hapton
