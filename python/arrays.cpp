#include "python/arrays.h"

#include <fmt/core.h>

#include <array>

#include "core/math/rigid_pose.h"

namespace hapton::python {
namespace {

std::string shape_of(const Doubles& array) {
  std::string text = "(";
  for (py::ssize_t k = 0; k < array.ndim(); ++k) text += fmt::format("{}{}", k == 0 ? "" : ", ", array.shape(k));
  return text + ")";
}

}  // namespace

void raise_value_error(const std::string& what) { throw py::value_error(what); }

std::vector<Vec3> read_points(const Doubles& array, const char* name, bool takes_not_finite) {
  const bool is_one = array.ndim() == 1 && array.shape(0) == 3;
  if (!is_one && !(array.ndim() == 2 && array.shape(1) == 3)) {
    raise_value_error(fmt::format("{} has shape {}; give (n, 3): x, y, z in metres", name, shape_of(array)));
  }
  std::vector<Vec3> points(is_one ? 1 : static_cast<std::size_t>(array.shape(0)));
  const double* numbers = array.data();
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = Vec3(numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]);
    if (!takes_not_finite && !points[i].allFinite()) raise_value_error(fmt::format("{}[{}] is not finite; give metres", name, i));
  }
  return points;
}

Vec3 read_point(const Doubles& array, const char* name) {
  const std::vector<Vec3> points = read_points(array, name);
  if (points.size() != 1) raise_value_error(fmt::format("{} has shape {}; give (3,)", name, shape_of(array)));
  return points.front();
}

Pose read_pose(const Doubles& array, const char* name) {
  if (array.ndim() != 2 || array.shape(0) != 4 || array.shape(1) != 4) {
    raise_value_error(fmt::format("{} has shape {}; give (4, 4)", name, shape_of(array)));
  }
  std::array<float, 12> rows = {};
  Pose pose = Pose::Identity();
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 4; ++k) pose.matrix()(i, k) = array.at(i, k);
  }
  for (std::size_t k = 0; k < rows.size(); ++k) rows[k] = static_cast<float>(array.data()[k]);
  if (!find_rigid_pose(rows) || pose.matrix().row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    raise_value_error(fmt::format("{} is not a rigid pose; give [R t; 0 0 0 1] with a rotation R and metres", name));
  }
  return pose;
}

py::array_t<double> make_point(const Vec3& point) {
  py::array_t<double> array(3);
  for (int k = 0; k < 3; ++k) array.mutable_at(k) = point[k];
  return array;
}

py::array_t<double> make_pose(const Pose& pose) {
  py::array_t<double> array({4, 4});
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 4; ++k) array.mutable_at(i, k) = pose.matrix()(i, k);
  }
  return array;
}

}  // namespace hapton::python
