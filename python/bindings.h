#pragma once

#include <memory>

#include "core/force/touch_scene.h"
#include "core/geometry/triangle_mesh.h"
#include "python/arrays.h"
#include "python/fields.h"
#include "scene/scene_file.h"

namespace hapton::python {

// A mesh as Python holds it: shared with the steps that touch it, and never changed.
struct PythonMesh {
  std::shared_ptr<const TriangleMesh> mesh;
};

// Each adds its part to the module.
void bind_meshes(py::module_& module);
void bind_touch(py::module_& module);
void bind_tools(py::module_& module);
void bind_deforming(py::module_& module);
void bind_sessions(py::module_& module);
void bind_fields(py::module_& module);
void bind_live(py::module_& module);

// A Mesh, or a list of Mesh and (Mesh, Material): the rest gets `material`. Error: something else among them.
TouchScene read_objects(const py::object& objects, const Material& material);
// A warning for each effect that is a plug-in, which is not run here.
void warn_of_libraries(const Scene& scene);
// Of Python's fields. Error: something else among them.
std::vector<Field> read_fields(const py::iterable& fields);

}  // namespace hapton::python
