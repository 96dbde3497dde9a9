#pragma once

#include <memory>

#include "core/geometry/triangle_mesh.h"
#include "python/arrays.h"
#include "python/fields.h"

namespace hapton::python {

// A mesh as Python holds it: shared with the steps that touch it, and never changed.
struct PythonMesh {
  std::shared_ptr<const TriangleMesh> mesh;
};

// Each adds its part to the module.
void bind_meshes(py::module_& module);
void bind_touch(py::module_& module);
void bind_sessions(py::module_& module);
void bind_fields(py::module_& module);
void bind_live(py::module_& module);

// Of Python's fields. Error: something else among them.
std::vector<Field> read_fields(const py::iterable& fields);

}  // namespace hapton::python
