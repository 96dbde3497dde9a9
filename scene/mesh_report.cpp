#include "scene/mesh_report.h"

#include <fmt/core.h>

#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "scene/material_reader.h"
#include "scene/mesh_counts_json.h"
#include "scene/text_cursor.h"

namespace hapton {
namespace {

constexpr double kCrackShare = 1e-3;  // of the mesh's longest side

// For example "tissue: stiffness, friction from an image".
std::string describe(const HapticMaterial& material) {
  std::string text = material.name.empty() ? "(no name)" : printable(material.name, kLongestShownName);
  const char* before = ": ";
  for (const auto& [image, name] : {std::pair(material.height, "bumps"),
                                    {material.stiffness, "stiffness"},
                                    {material.friction, "friction"},
                                    {material.viscosity, "viscosity"}}) {
    if (!image) continue;
    text += fmt::format("{}{}", std::exchange(before, ", "), name);
  }
  return text + (material.has_maps() ? " from an image" : "");
}

// The haptic materials that triangles use.
std::vector<const HapticMaterial*> haptic_materials_of(const MeshFile& file) {
  std::vector<const HapticMaterial*> found;
  for (const std::uint32_t index : list_haptic_materials(file.haptics.maps)) {
    if (index != TriangleAppearance::kNoMaterial) found.push_back(&file.haptics.materials[index]);
  }
  return found;
}

}  // namespace

double crack_width(const MeshTopology& topology) { return kCrackShare * (topology.highest - topology.lowest).maxCoeff(); }

MeshFlaws find_flaws(const TriangleMesh& mesh) {
  MeshFlaws flaws{.topology = compute_mesh_topology(mesh),
                  .borders = {},
                  .repair = {},
                  .bodies = count_closed_bodies(mesh),
                  .normals = count_authored_normals(mesh)};
  flaws.borders = count_boundary_edges(mesh, crack_width(flaws.topology));
  repair_mesh(mesh, flaws.repair);
  return flaws;
}

std::string to_text(const MeshFlaws& flaws) {
  const MeshTopology& t = flaws.topology;
  const std::pair<std::size_t, const char*> counts[] = {{flaws.borders.open, "open boundary edges"},
                                                        {flaws.borders.cracks, "crack edges"},
                                                        {t.nonmanifold_edges, "non-manifold edges"},
                                                        {t.inconsistent_edges, "inconsistent edges"},
                                                        {t.nonmanifold_vertices, "non-manifold vertices"},
                                                        {t.degenerate_triangles, "degenerate triangles"},
                                                        {t.needle_triangles, "needles"},
                                                        {flaws.repair.dropped_duplicates, "duplicates"},
                                                        {flaws.repair.double_faces, "double faces"},
                                                        {flaws.bodies.inside_out, "bodies inside out"}};
  std::string text;
  for (const auto& [count, name] : counts) {
    if (count > 0) text += fmt::format("{}{} {}", text.empty() ? ": " : ", ", name, count);
  }
  if (flaws.borders.has_given_up) text += ", not all cracks looked for";
  return (t.is_closed() ? "closed" : "not closed") + text;
}

std::string describe_inside_out(const ClosedBodies& bodies) {
  if (bodies.inside_out == 0) return {};
  return fmt::format(
      "{} of {} closed bod{} inside out: with two_sided = false only the inner side can be touched; flip the normals (\"recalculate "
      "outside\") and export again",
      bodies.inside_out, bodies.count, bodies.count == 1 ? "y is" : "ies are");
}

Result<MeshReport> make_mesh_report(const std::filesystem::path& path, std::optional<Unit> unit) {
  Result<MeshFile> file = load_mesh_file(path, unit);
  if (!file) return tl::unexpected(file.error());
  MeshReport report{.path = path.string(), .file = std::move(*file), .flaws = {}, .sealed = {}, .borders_left = {}, .touch_topology = {}};
  report.flaws = find_flaws(report.file.mesh);
  const TriangleMesh touched = seal_cracks(report.file.mesh, report.sealed);
  report.borders_left =
      report.sealed.has_sealed() ? count_boundary_edges(touched, crack_width(report.flaws.topology)) : report.flaws.borders;
  for (const HapticMaterial* material : haptic_materials_of(report.file)) {
    const auto read = read_material(*material, report.file.haptics.maps, report.path);
    if (!read) report.file.notes.push_back(fmt::format("cannot be touched before this is corrected: {}", read.error().what));
  }
  report.touch_topology = compute_mesh_topology(touched);
  return report;
}

namespace {

// The flaws, other than boundary edges, that prevent a surface from being closed.
std::string describe_flaws(const MeshTopology& t) {
  std::string text;
  if (t.nonmanifold_edges > 0) text += fmt::format("; {} non-manifold edges", t.nonmanifold_edges);
  if (t.inconsistent_edges > 0) text += fmt::format("; {} inconsistent edges", t.inconsistent_edges);
  if (t.nonmanifold_vertices > 0) text += fmt::format("; {} non-manifold vertices", t.nonmanifold_vertices);
  if (t.degenerate_triangles > 0) text += fmt::format("; {} degenerate triangles", t.degenerate_triangles);
  return text;
}

std::string describe_widest(const BoundaryEdges& edges) {
  return edges.cracks == 0 ? std::string() : fmt::format("; the widest {:.3g} m", edges.widest_crack);
}

}  // namespace

std::string to_text(const MeshReport& report) {
  const MeshTopology& t = report.flaws.topology;
  const Vec3 size = t.highest - t.lowest;
  std::string text;
  const auto line = [&]<class... Args>(std::string_view name, fmt::format_string<Args...> format, Args&&... args) {
    text += fmt::format("{:<22}{}\n", name, fmt::format(format, std::forward<Args>(args)...));
  };
  line("file", "{}", report.path);
  line("format", "{}, numbers read as {}", report.file.format, name_of(report.file.unit));
  line("triangles", "{}", t.triangles);
  line("vertices", "{} ({} in the file)", t.vertices, report.file.file_vertices);
  line("size", "{:.6g} x {:.6g} x {:.6g} m", size.x(), size.y(), size.z());
  line("from, to", "({:.6g}, {:.6g}, {:.6g}), ({:.6g}, {:.6g}, {:.6g}) m", t.lowest.x(), t.lowest.y(), t.lowest.z(), t.highest.x(),
       t.highest.y(), t.highest.z());
  line("signed volume", "{:.6g} m^3", t.signed_volume);
  line("edges", "{:.4g} / {:.4g} / {:.4g} m (shortest / median / longest)", t.shortest_edge, t.median_edge, t.longest_edge);
  line("closed", "{}", t.is_closed() ? "yes" : "no");
  line("boundary edges", "{} ({} open, {} of cracks up to {:g} of the longest side wide{})", t.boundary_edges, report.flaws.borders.open,
       report.flaws.borders.cracks, kCrackShare, describe_widest(report.flaws.borders));
  if (report.flaws.borders.has_given_up) {
    line("", "not all cracks were looked for: too many boundary edges lie across each other; these triangles do not form a surface");
  }
  line("non-manifold edges", "{}", t.nonmanifold_edges);
  line("inconsistent edges", "{}", t.inconsistent_edges);
  line("non-manifold vertices", "{}", t.nonmanifold_vertices);
  line("degenerate triangles", "{}", t.degenerate_triangles);
  line("needle triangles", "{}", t.needle_triangles);
  line("duplicate triangles", "{}", report.flaws.repair.dropped_duplicates);
  line("double faces", "{} (the same corners the other way round)", report.flaws.repair.double_faces);
  line("authored normals", "{}", report.flaws.normals.describe());
  if (report.flaws.bodies.inside_out > 0) line("inside out", "{}", describe_inside_out(report.flaws.bodies));
  line("components", "{}", t.components);
  line("parts", "{}", report.file.parts.size());
  for (const MeshPart& part : report.file.parts)
    line("", "{:>9} triangles  {}", part.triangle_count, part.name.empty() ? "(no name)" : printable(full_name(part), kLongestShownName));
  for (const HapticMaterial* material : haptic_materials_of(report.file)) line("haptic material", "{}", describe(*material));
  line("for touch", "{}", report.sealed.boundary_edges == 0 ? "nothing to seal" : report.sealed.describe());
  line("closed for touch", "{} ({} boundary edges: {} open, {} of cracks{}{})", report.is_closed_for_touch() ? "yes" : "no",
       report.borders_left.open + report.borders_left.cracks, report.borders_left.open, report.borders_left.cracks,
       describe_widest(report.borders_left), report.is_closed_for_touch() ? "" : describe_flaws(report.touch_topology));
  line("method smooth would", "{}", report.flaws.repair.describe());
  for (const std::string& note : report.file.notes) line("note", "{}", note);
  return text;
}

namespace {

using MeshJson = nlohmann::ordered_json;

// What sealing changed, and what is still open after it.
MeshJson sealed_to_json(const MeshReport& report) {
  MeshJson json;
  append_sealing(json, report.sealed);
  json["boundary_edges_left"] = report.sealed.boundary_edges_left;
  json["open_border_edges_left"] = report.borders_left.open;
  json["crack_edges_left"] = report.borders_left.cracks;
  json["widest_crack_left_m"] = report.borders_left.widest_crack;
  json["unsealed_edges"] = report.sealed.unsealed_edges;
  json["widest_unsealed_m"] = report.sealed.widest_unsealed;
  json["closed"] = report.is_closed_for_touch();
  return json;
}

MeshJson repair_to_json(const RepairReport& repair) {
  return {{"welded_vertices", repair.welded_vertices},
          {"dropped_empty", repair.dropped_empty},
          {"dropped_duplicates", repair.dropped_duplicates},
          {"turned", repair.turned},
          {"unorientable_pieces", repair.unorientable_pieces}};
}

MeshJson parts_to_json(const MeshFile& file) {
  MeshJson parts = MeshJson::array();
  for (const MeshPart& part : file.parts) {
    parts.push_back({{"name", part.name}, {"triangles", part.triangle_count}});
    if (!part.object.empty()) parts.back()["object"] = part.object;
  }
  return parts;
}

}  // namespace

std::string to_json(const MeshReport& report) {
  const MeshTopology& t = report.flaws.topology;
  MeshJson haptic_materials = MeshJson::array();
  for (const HapticMaterial* material : haptic_materials_of(report.file)) haptic_materials.push_back(describe(*material));
  const auto corner = [](const Vec3& p) { return MeshJson::array({p.x(), p.y(), p.z()}); };
  MeshJson json = {{"schema", "hapton.mesh_info/3"},
                   {"file", report.path},
                   {"format", report.file.format},
                   {"unit", name_of(report.file.unit)},
                   {"triangles", t.triangles},
                   {"vertices", t.vertices},
                   {"file_vertices", report.file.file_vertices},
                   {"lowest_m", corner(t.lowest)},
                   {"highest_m", corner(t.highest)},
                   {"signed_volume_m3", t.signed_volume},
                   {"shortest_edge_m", t.shortest_edge},
                   {"median_edge_m", t.median_edge},
                   {"longest_edge_m", t.longest_edge},
                   {"closed", t.is_closed()},
                   {"boundary_edges", t.boundary_edges}};
  append_boundary(json, report.flaws.borders);
  append_flaws(json, report.flaws);
  json.update(MeshJson{
      {"repair", repair_to_json(report.flaws.repair)},
      {"sealed", sealed_to_json(report)},
      {"authored_normals", {{"corners", report.flaws.normals.given}, {"used_by_shading", report.flaws.normals.used}}},
      {"components", t.components},
      {"closed_bodies", report.flaws.bodies.count},
      {"bodies_inside_out", report.flaws.bodies.inside_out},
      {"parts", parts_to_json(report.file)},
      {"haptic_materials", haptic_materials},
      {"notes", report.file.notes},
  });
  // Names come from the file and need not be UTF-8.
  return json.dump(2, ' ', false, MeshJson::error_handler_t::replace) + "\n";
}

}  // namespace hapton
