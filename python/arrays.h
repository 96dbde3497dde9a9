#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/math/types.h"

namespace hapton::python {

namespace py = pybind11;

// NumPy arrays as they come: contiguous doubles, converted where they are not.
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

// Python's way of failing, with our one line. Threads, here and below: with the GIL.
[[noreturn]] void raise_value_error(const std::string& what);

template <class T>
T value_or_raise(Result<T>&& result) {
  if (!result) raise_value_error(result.error().what);
  return std::move(*result);
}

// (n, 3) or, for one, (3,). Error: another shape, or numbers that are not finite unless `takes_not_finite`.
std::vector<Vec3> read_points(const Doubles& array, const char* name, bool takes_not_finite = false);
Vec3 read_point(const Doubles& array, const char* name);
// (4, 4) with a rotation and (0, 0, 0, 1) below.
Pose read_pose(const Doubles& array, const char* name);
// (n, 4, 4) or, for one, (4, 4). One with a number that is not finite stays so.
std::vector<Pose> read_poses(const Doubles& array, const char* name);
// Text of a file or a datagram, which may be no UTF-8.
py::str make_text(std::string_view text);
py::array_t<double> make_point(const Vec3& point);
py::array_t<double> make_pose(const Pose& pose);
py::array_t<double> make_points(std::size_t count);  // (count, 3), to be written

}  // namespace hapton::python
