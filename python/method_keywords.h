#pragma once

#include <string>
#include <vector>

#include "core/force/force_method.h"
#include "python/arrays.h"

namespace hapton::python {

// Settings of a method from Python's keywords, by the names of MethodSettings. Error (TypeError): an unknown one, with those there are, or
// a value of another type.
MethodSettings read_method(const std::string& name, const py::kwargs& keywords);

std::vector<std::string> list_methods();

}  // namespace hapton::python
