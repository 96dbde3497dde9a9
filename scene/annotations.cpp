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

std::size_t count_carves(const std::vector<CarvedPress>& carved) {
  std::size_t carves = 0;
  for (const CarvedPress& press : carved) carves += press.carves.size();
  return carves;
}

std::vector<CarvedPress> group_carves(const CarveList& list, std::vector<std::uint32_t>* first_serials) {
  std::vector<CarvedPress> carved;
  bool begins = true;
  list.for_each({}, [&](const MadeCarve& made) {
    begins = begins || made.begins;
    if (!list.is_active(made.serial)) return;
    const bool is_same = !carved.empty() && carved.back().object == made.object && carved.back().radius_m == made.carve.radius_m;
    if (begins || !is_same) {
      carved.push_back({.object = made.object, .radius_m = made.carve.radius_m, .carves = {}});
      if (first_serials != nullptr) first_serials->push_back(made.serial);
    }
    begins = false;
    carved.back().carves.push_back(made.carve);
  });
  return carved;
}

double compute_length_m(const Stroke& stroke) {
  double length_m = 0.0;
  for (std::size_t i = 1; i < stroke.points_m.size(); ++i) length_m += (stroke.points_m[i] - stroke.points_m[i - 1]).norm();
  return length_m;
}

Vec3 place(const AnnotationPoint& point, const ObjectPoses& X_SO) {
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
