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

// NumPy arrays of contiguous doubles; other arrays are converted to that.
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

// Throws Python's ValueError with this line. Threads: with the GIL, for all functions of this header.
[[noreturn]] void raise_value_error(const std::string& what);

template <class T>
T value_or_raise(Result<T>&& result) {
  if (!result) raise_value_error(result.error().what);
  return std::move(*result);
}

// Points from an array of shape (n, 3), or (3,) for one. Error: another shape, or, without `takes_not_finite`, a number that is not finite.
std::vector<Vec3> read_points(const Doubles& array, const char* name, bool takes_not_finite = false);
Vec3 read_point(const Doubles& array, const char* name);
// A pose from an array of shape (4, 4): a rotation, a translation, and (0, 0, 0, 1) as the last row.
Pose read_pose(const Doubles& array, const char* name);
// Poses from an array of shape (n, 4, 4), or (4, 4) for one. A pose with a number that is not finite becomes NaN throughout.
std::vector<Pose> read_poses(const Doubles& array, const char* name);
// Text of a file or a datagram. It may be invalid UTF-8: such bytes are replaced.
py::str make_text(std::string_view text);
py::array_t<double> make_point(const Vec3& point);
py::array_t<double> make_pose(const Pose& pose);
py::array_t<double> make_points(std::size_t count);  // shape (count, 3), not initialised

}  // namespace hapton::python
