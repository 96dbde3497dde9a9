#include "scene/mesh_counts_json.h"

#include <nlohmann/json.hpp>

namespace hapton {

void append_boundary(nlohmann::ordered_json& json, const BoundaryEdges& edges) {
  json["open_border_edges"] = edges.open;
  json["crack_edges"] = edges.cracks;
  json["widest_crack_m"] = edges.widest_crack;
  json["crack_edges_all_counted"] = !edges.has_given_up;
}

void append_flaws(nlohmann::ordered_json& json, const MeshFlaws& flaws) {
  json["nonmanifold_edges"] = flaws.topology.nonmanifold_edges;
  json["inconsistent_edges"] = flaws.topology.inconsistent_edges;
  json["nonmanifold_vertices"] = flaws.topology.nonmanifold_vertices;
  json["degenerate_triangles"] = flaws.topology.degenerate_triangles;
  json["needle_triangles"] = flaws.topology.needle_triangles;
  json["duplicate_triangles"] = flaws.topology.duplicate_triangles;
  json["double_faces"] = flaws.repair.double_faces;
}

void append_sealing(nlohmann::ordered_json& json, const SealReport& sealed) {
  json["welded_vertices"] = sealed.welded_vertices;
  json["split_triangles"] = sealed.split_triangles;
  json["zipped_edges"] = sealed.zipped_edges;
  json["widest_gap_m"] = sealed.widest_gap;
  json["tolerance_m"] = sealed.tolerance;
}

}  // namespace hapton
