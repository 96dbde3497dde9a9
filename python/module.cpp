// What `import hapton` finds beside hapton/__init__.py.
#include "python/bindings.h"

PYBIND11_MODULE(_hapton, module) {
  module.doc() = "Hapton's libraries for Python; import hapton instead.";
  hapton::python::bind_meshes(module);
  hapton::python::bind_touch(module);
  hapton::python::bind_tools(module);
  hapton::python::bind_deforming(module);
  hapton::python::bind_sessions(module);
  hapton::python::bind_fields(module);
  hapton::python::bind_live(module);
}
