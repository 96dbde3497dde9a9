#include <fmt/core.h>

#include <cmath>
#include <optional>

#include "python/bindings.h"
#include "scene/mesh_report.h"
#include "scene/touch_mesh.h"

namespace hapton::python {
namespace {

std::optional<Unit> read_unit(const std::optional<std::string>& unit) {
  if (!unit) return std::nullopt;
  return value_or_raise(parse_unit(*unit));
}

// Indices are read as doubles, which hold each of them exactly. As integers, 0.9 and 1e30 would be converted without an error.
PythonMesh make_mesh(const Doubles& vertices, const Doubles& triangles) {
  auto mesh = std::make_shared<TriangleMesh>();
  mesh->vertices = read_points(vertices, "vertices");
  if (triangles.ndim() != 2 || triangles.shape(1) != 3) raise_value_error("triangles must have the shape (m, 3); give three indices each");
  const auto count = static_cast<double>(mesh->vertices.size());
  for (py::ssize_t t = 0; t < triangles.shape(0); ++t) {
    Triangle triangle = {};
    for (py::ssize_t k = 0; k < 3; ++k) {
      const double index = triangles.at(t, k);
      if (!(index >= 0.0 && index < count && index == std::floor(index)))
        raise_value_error(fmt::format("triangles[{}] names vertex {}; there are {}, numbered from 0", t, index, mesh->vertices.size()));
      triangle[static_cast<std::size_t>(k)] = static_cast<std::uint32_t>(index);
    }
    mesh->triangles.push_back(triangle);
  }
  if (mesh->triangles.empty()) raise_value_error("triangles is empty; a mesh needs a surface");
  return {mesh};
}

PythonMesh load_mesh(const std::string& path, const std::optional<std::string>& unit_name, bool seal) {
  const std::optional<Unit> unit = read_unit(unit_name);
  Result<TouchMesh> loaded = fail("not loaded");
  {
    const py::gil_scoped_release gil_released;
    loaded = load_touch_mesh(path, unit, seal ? CrackSealing::on : CrackSealing::off);
  }
  return {std::make_shared<TriangleMesh>(value_or_raise(std::move(loaded)).mesh)};
}

std::string report_mesh(const std::string& path, const std::optional<std::string>& unit_name) {
  const std::optional<Unit> unit = read_unit(unit_name);
  Result<MeshReport> report = fail("not made");
  {
    const py::gil_scoped_release gil_released;
    report = make_mesh_report(path, unit);
  }
  return to_json(value_or_raise(std::move(report)));
}

py::array_t<double> copy_vertices(const PythonMesh& self) {
  const auto count = static_cast<py::ssize_t>(self.mesh->vertices.size());
  py::array_t<double> array({count, py::ssize_t{3}});
  for (py::ssize_t i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k) array.mutable_at(i, k) = self.mesh->vertices[static_cast<std::size_t>(i)][k];
  }
  return array;
}

py::array_t<std::uint32_t> copy_triangles(const PythonMesh& self) {
  const auto count = static_cast<py::ssize_t>(self.mesh->triangles.size());
  py::array_t<std::uint32_t> array({count, py::ssize_t{3}});
  for (py::ssize_t i = 0; i < count; ++i) {
    for (py::ssize_t k = 0; k < 3; ++k)
      array.mutable_at(i, k) = self.mesh->triangles[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
  }
  return array;
}

std::string describe_mesh(const PythonMesh& self) {
  return fmt::format("<hapton.Mesh: {} vertices, {} triangles>", self.mesh->vertices.size(), self.mesh->triangles.size());
}

}  // namespace

void bind_meshes(py::module_& module) {
  py::class_<PythonMesh>(module, "Mesh", "Triangles with shared vertices, in metres. It does not change.")
      .def(py::init(&make_mesh), py::arg("vertices"), py::arg("triangles"),
           "From (n, 3) vertices in metres and (m, 3) indices, counter-clockwise seen from outside.")
      .def_property_readonly("vertices", &copy_vertices, "A copy: (n, 3), metres.")
      .def_property_readonly("triangles", &copy_triangles, "A copy: (m, 3) indices of vertices.")
      .def("__repr__", &describe_mesh);
  module.def("load_mesh", &load_mesh, py::arg("path"), py::arg("unit") = py::none(), py::kw_only(), py::arg("seal") = true,
             "Reads an OBJ, STL, PLY, glTF or GLB file. unit: m, cm, mm or in, of the numbers in the file (None: m).\n"
             "seal: cracks up to 1e-4 of the longest side are closed, as haptics_node does.");
  module.def("_report_mesh", &report_mesh, py::arg("path"), py::arg("unit") = py::none());
}

}  // namespace hapton::python
