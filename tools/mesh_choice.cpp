#include "tools/mesh_choice.h"

#include <array>
#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "scene/touch_mesh.h"
#include "scene/unit.h"

namespace hapton {
namespace {

struct Shape {
  std::string_view name;
  TriangleMesh (*make)();
};

// All shapes are about 100 mm long.
constexpr std::array kShapes = {
    Shape{"sphere", [] { return make_icosphere(0.05, 5); }},
    Shape{"box", [] { return make_box(Vec3::Constant(0.1), 4); }},
    Shape{"cylinder", [] { return make_cylinder(0.03, 0.1, 96, 12); }},
    Shape{"torus", [] { return make_torus(0.035, 0.015, 128, 48); }},
    Shape{"plane", [] { return make_plane_grid(0.1, 32); }},
    Shape{"bumpy", [] { return make_bumpy_sphere(0.045, 0.25, 20000, 1); }},
    Shape{"bumpy1M3", [] { return make_bumpy_sphere(0.045, 0.25, 1000000, 1); }},
    Shape{"wall", [] { return make_thin_wall(0.1, 1e-4, 16); }},
    Shape{"gutter", [] { return make_gutter(0.1, 0.03, 0.6, 8); }},
    Shape{"staircase", [] { return make_staircase(0.1, 10, 8); }},
    Shape{"pit", [] { return make_pit(0.1, 0.05); }},
};

std::string shape_names() {
  std::string names;
  for (const Shape& shape : kShapes) {
    if (!names.empty()) names += ", ";
    names += shape.name;
  }
  return names;
}

}  // namespace

void add_mesh_options(CommandLine command, MeshChoice& choice) {
  const CommandLine source = command.add_group("what is touched").require_options(1, 1);
  source.add_option("--mesh", choice.file, "OBJ, STL, PLY, glTF or GLB file");
  source.add_option("--shape", choice.shape, "Generated shape, about 100 mm: " + shape_names()).one_of_names(shape_names());
  command.add_option("--unit", choice.unit, "Unit of the mesh file: m (default), cm, mm or in").one_of_names(kUnitNames);
  command.add_flag("--no-seal", choice.no_seal, "Do not seal cracks: by default those up to 1e-4 of the longest side are closed");
  command.add_option("--scale-to", choice.scale_to_m, "Scale the mesh about the origin so that its longest side has this length, metres")
      .positive();
}

Result<TriangleMesh> make_mesh(const MeshChoice& choice) {
  TriangleMesh mesh;
  if (choice.file.empty()) {
    for (const Shape& shape : kShapes) {
      if (shape.name == choice.shape) mesh = shape.make();
    }
    if (mesh.triangles.empty()) return fail("shape '{}' is not known; choose one of: {}", choice.shape, shape_names());
  } else {
    std::optional<Unit> unit;
    if (!choice.unit.empty()) {
      const auto parsed = parse_unit(choice.unit);
      if (!parsed) return tl::unexpected(parsed.error());
      unit = *parsed;
    }
    auto loaded = load_touch_mesh(choice.file, unit, choice.no_seal ? CrackSealing::off : CrackSealing::on);
    if (!loaded) return tl::unexpected(loaded.error());
    mesh = std::move(loaded->mesh);
  }
  if (choice.scale_to_m > 0.0) {
    if (!(compute_bounds(mesh).extent() > 0.0)) return fail("{}: the mesh has no extent; it cannot be scaled", name_of(choice));
    mesh = scaled_to(std::move(mesh), choice.scale_to_m);
  }
  return mesh;
}

std::string name_of(const MeshChoice& choice) {
  return choice.file.empty() ? choice.shape : std::filesystem::path(choice.file).stem().string();
}

TriangleMesh scaled_to(TriangleMesh mesh, double extent_m) {
  const double scale = extent_m / compute_bounds(mesh).extent();
  return scaled_and_moved(std::move(mesh), scale, Vec3::Zero());
}

}  // namespace hapton
