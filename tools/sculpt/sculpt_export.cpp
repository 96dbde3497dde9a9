#include "tools/sculpt/sculpt_export.h"

#include <vector>

#include <fmt/format.h>

#include "core/sculpt/carved_mesh.h"
#include "runtime/atomic_file.h"
#include "scene/annotations_file.h"
#include "scene/mesh_text.h"
#include "scene/scene_file.h"

namespace hapton {
namespace {

// Adds the carved surface of one body to `merged`. Returns the number of carves of that body.
Result<std::size_t> add_body(const Scene& scene, std::size_t number, const std::vector<CarvedPress>& carved, TriangleMesh& merged) {
  const SceneObject& object = scene.objects[number];
  auto field = CarvedField::make(*object.mesh, object.sculpt->voxel_m);
  if (!field) return fail("object '{}': {}", object.name, field.error().what);
  std::size_t carves = 0;
  for (const CarvedPress& press : carved) {
    if (press.object != static_cast<std::int32_t>(number)) continue;
    for (const Carve& carve : press.carves) field->carve(carve);
    carves += press.carves.size();
  }
  const TriangleMesh mesh = make_carved_mesh(*field);
  const auto first_vertex = static_cast<std::uint32_t>(merged.vertices.size());
  merged.vertices.insert(merged.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
  for (const Triangle& t : mesh.triangles) merged.triangles.push_back({first_vertex + t[0], first_vertex + t[1], first_vertex + t[2]});
  return carves;
}

}  // namespace

Result<std::string> export_carved(const SculptExport& options) {
  const auto format = find_mesh_format(options.out);
  if (!format) return tl::unexpected(format.error());
  const auto scene = load_scene(options.scene);
  if (!scene) return tl::unexpected(scene.error());
  std::vector<std::string> names;
  for (const SceneObject& object : scene->objects) names.push_back(object.name);
  const auto read = read_annotations(options.annotations, names, scene->given_hash);
  if (!read) return tl::unexpected(read.error());
  TriangleMesh mesh;
  std::size_t bodies = 0;
  std::size_t carves = 0;
  for (std::size_t o = 0; o < scene->objects.size(); ++o) {
    if (!scene->objects[o].sculpt || (!options.object.empty() && options.object != names[o])) continue;
    const auto added = add_body(*scene, o, read->annotations.carved, mesh);
    if (!added) return tl::unexpected(added.error());
    carves += *added;
    ++bodies;
  }
  if (bodies == 0) {
    return options.object.empty() ? fail("{}: no object can be carved; give one 'sculpt = true'", options.scene)
                                  : fail("{}: no object '{}' can be carved; name one with 'sculpt = true'", options.scene, options.object);
  }
  if (mesh.triangles.empty()) return fail("nothing is left of what was carved, so there is no surface to write");
  if (const auto written = write_file_atomically(options.out, write_mesh(mesh, *format)); !written) return tl::unexpected(written.error());
  const std::string misfit = read->describe_misfit();
  return fmt::format("{}: {} triangles, {} carves of {}{}\n", options.out.string(), mesh.triangles.size(), carves,
                     bodies == 1 ? "one object" : fmt::format("{} objects", bodies), misfit.empty() ? "" : "; " + misfit);
}

}  // namespace hapton
