#include "python/arrays.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/math/rigid_pose.h"

namespace hapton::python {
namespace {

std::string shape_of(const Doubles& array) {
  std::string text = "(";
  for (py::ssize_t k = 0; k < array.ndim(); ++k) text += fmt::format("{}{}", k == 0 ? "" : ", ", array.shape(k));
  return text + ")";
}

// numbers: a matrix of 4 x 4, row by row. Nullopt: it is not a rigid pose.
std::optional<Pose> pose_of(const double* numbers) {
  std::array<float, 12> rows = {};
  for (std::size_t k = 0; k < rows.size(); ++k) rows[k] = static_cast<float>(numbers[k]);
  Pose pose = Pose::Identity();
  pose.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers);
  if (!find_rigid_pose(rows) || pose.matrix().row(3) != Eigen::RowVector4d(0, 0, 0, 1)) return std::nullopt;
  return pose;
}

}  // namespace

void raise_value_error(const std::string& what) { throw py::value_error(what); }

std::vector<Vec3> read_points(const Doubles& array, const char* name, bool takes_not_finite) {
  const bool is_one = array.ndim() == 1 && array.shape(0) == 3;
  if (!is_one && !(array.ndim() == 2 && array.shape(1) == 3)) {
    raise_value_error(fmt::format("{} has shape {}; give (n, 3): x, y, z", name, shape_of(array)));
  }
  std::vector<Vec3> points(is_one ? 1 : static_cast<std::size_t>(array.shape(0)));
  const double* numbers = array.data();
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = Vec3(numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]);
    if (!takes_not_finite && !points[i].allFinite()) raise_value_error(fmt::format("{}[{}] is not finite", name, i));
  }
  return points;
}

Vec3 read_point(const Doubles& array, const char* name) {
  const bool is_one = array.size() == 3 && (array.ndim() == 1 || (array.ndim() == 2 && array.shape(0) == 1));
  if (!is_one) raise_value_error(fmt::format("{} has shape {}; give (3,): x, y, z", name, shape_of(array)));
  const Vec3 point(array.data()[0], array.data()[1], array.data()[2]);
  if (!point.allFinite()) raise_value_error(fmt::format("{} is not finite", name));
  return point;
}

Pose read_pose(const Doubles& array, const char* name) {
  if (array.ndim() != 2 || array.shape(0) != 4 || array.shape(1) != 4) {
    raise_value_error(fmt::format("{} has shape {}; give (4, 4)", name, shape_of(array)));
  }
  const std::optional<Pose> pose = pose_of(array.data());
  if (!pose) raise_value_error(fmt::format("{} is not a rigid pose; give [R t; 0 0 0 1] with a rotation R and metres", name));
  return *pose;
}

std::vector<Pose> read_poses(const Doubles& array, const char* name) {
  const py::ssize_t first = array.ndim() - 2;
  if (first < 0 || first > 1 || array.shape(first) != 4 || array.shape(first + 1) != 4) {
    raise_value_error(fmt::format("{} has shape {}; give (n, 4, 4)", name, shape_of(array)));
  }
  std::vector<Pose> poses(first == 0 ? 1 : static_cast<std::size_t>(array.shape(0)));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double* numbers = array.data() + 16 * i;
    if (!std::all_of(numbers, numbers + 16, [](double number) { return std::isfinite(number); })) {
      poses[i].matrix().setConstant(std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    const std::optional<Pose> pose = pose_of(numbers);
    if (!pose) raise_value_error(fmt::format("{}[{}] is not a rigid pose; give [R t; 0 0 0 1] with a rotation R and metres", name, i));
    poses[i] = *pose;
  }
  return poses;
}

py::str make_text(std::string_view text) {
  return py::reinterpret_steal<py::str>(PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "replace"));
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

py::array_t<double> make_points(std::size_t count) { return py::array_t<double>({static_cast<py::ssize_t>(count), py::ssize_t{3}}); }

}  // namespace hapton::python
