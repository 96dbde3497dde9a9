#pragma once

#include <string>
#include <vector>

#include "core/force/force_method.h"
#include "python/arrays.h"

namespace hapton::python {

// Settings of a method from Python's keywords, which have the names in MethodSettings. Error (TypeError): an unknown keyword, with a list
// of the known ones, or a value of another type; (ValueError): not three numbers for grid_division.
MethodSettings read_method(const std::string& name, const py::kwargs& keywords);

std::vector<std::string> list_methods();

}  // namespace hapton::python
