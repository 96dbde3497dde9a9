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

// Each of these functions adds its part to the module.
void bind_meshes(py::module_& module);
void bind_touch(py::module_& module);
void bind_tools(py::module_& module);
void bind_deforming(py::module_& module);
void bind_sessions(py::module_& module);
void bind_fields(py::module_& module);
void bind_live(py::module_& module);

// The objects of a Mesh, or of a list of Mesh and (Mesh, Material). material: for a Mesh without one. Error: the list has something else.
TouchScene read_objects(const py::object& objects, const Material& material);
// Gives a Python warning for each effect of the scene that is a plug-in, because Python does not run it.
void warn_of_libraries(const Scene& scene);
// The fields of a Python list. Error: the list has something else.
std::vector<Field> read_fields(const py::iterable& fields);

}  // namespace hapton::python
