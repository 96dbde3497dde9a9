#include "core/tool/near_features.h"

#include <algorithm>

namespace hapton {
namespace {

using Kind = FeaturePair::Kind;

std::vector<SurfaceFeatures> features_of(const TouchGeometry& scene) {
  std::vector<SurfaceFeatures> features;
  for (std::uint32_t o = 0; o < scene.object_count(); ++o) features.emplace_back(scene.object_geometry(o));
  return features;
}

double radius_of(const ObjectGeometry& tool) {
  double squared = 0.0;
  for (const Vec3& v : tool.vertices()) squared = std::max(squared, v.squaredNorm());
  return std::sqrt(squared) * (1.0 + 0x1p-50);
}

int edge_number(TriangleFeature feature) { return static_cast<int>(feature) - static_cast<int>(TriangleFeature::edge0); }
int vertex_number(TriangleFeature feature) { return static_cast<int>(feature) - static_cast<int>(TriangleFeature::vertex0); }

// The closest feature of a triangle is its own and a top along `outward`; a face always is.
bool is_top_of(const SurfaceFeatures& surface, std::uint32_t t, TriangleFeature feature, const Vec3& outward) {
  if (is_edge(feature)) {
    const int k = edge_number(feature);
    return surface.owns_edge(t, k) && surface.is_top(t, k, outward);
  }
  if (is_vertex(feature)) {
    const int k = vertex_number(feature);
    return surface.owns_vertex(t, k) && surface.is_top(surface.surface().triangle(t)[k], outward);
  }
  return true;
}

}  // namespace

NearFeatures::NearFeatures(const ObjectGeometry& tool, const TouchGeometry& scene)
    : tool_(&tool),
      scene_(&scene),
      tool_features_(tool),
      scene_features_(features_of(scene)),
      pairs_(tool, scene, kMostTrianglePairs),
      radius_(radius_of(tool)),
      features_(kMostFeatures) {}

bool NearFeatures::refresh_pairs(const Placement& placement, double distance) noexcept {
  const double moved = (placement.position - pairs_at_.position).norm() +
                       radius_ * turn_between(pairs_at_.orientation, placement.orientation).norm() + 0x1p-45 * (1.0 + radius_);
  if (distance + moved <= pairs_within_) return true;
  pairs_within_ = -1.0;
  // Pairs from farther away serve several calls; where that is too many, only those of this one.
  for (const double within : {3.0 * distance, distance}) {
    if (!pairs_.collect(placement, within)) continue;
    pairs_within_ = within;
    pairs_at_ = placement;
    return true;
  }
  return false;
}

bool NearFeatures::collect(const Placement& placement, double distance) noexcept {
  count_ = 0;
  fits_ = true;
  if (!refresh_pairs(placement, distance)) return false;
  std::uint32_t last = ~0U;
  Box around;
  for (const TrianglePairIds& ids : pairs_.pairs()) {
    if (ids.tool != last) {
      last = ids.tool;
      around = Box();
      for (int k = 0; k < 3; ++k) around.grow(placement.at(tool_->corner(ids.tool, k)));
      around = around.inflated(distance + 0x1p-45 * (1.0 + radius_));
    }
    const ObjectGeometry::Corners c = scene_->corners(ids.scene);
    if (!around.overlaps({c.a.cwiseMin(c.b).cwiseMin(c.c), c.a.cwiseMax(c.b).cwiseMax(c.c)})) continue;
    add_pair(ids, placement, distance);
    if (!fits_) return false;
  }
  return true;
}

void NearFeatures::add_pair(const TrianglePairIds& ids, const Placement& placement, double distance) noexcept {
  const SurfaceFeatures& scene_features = scene_features_[scene_->mesh_of(ids.scene)];
  const std::uint32_t scene_triangle = scene_->triangle_of(ids.scene);
  const ObjectGeometry::Corners scene = scene_->corners(ids.scene);
  const ObjectGeometry::Corners tool = tool_->corners(ids.tool);
  const std::array<Vec3, 3> s = {scene.a, scene.b, scene.c};
  const std::array<Vec3, 3> t = {tool.a, tool.b, tool.c};
  FeaturePair pair;
  pair.tool_triangle = ids.tool;
  pair.scene_triangle = ids.scene;
  for (int k = 0; k < 3; ++k) {
    pair.tool_corner = pair.scene_corner = k;
    if (tool_features_.owns_vertex(ids.tool, k)) {
      pair.kind = Kind::vertex_face;
      pair.tool[0] = t[k];
      pair.scene = s;
      add(pair, placement, distance);
    }
    if (scene_features.owns_vertex(scene_triangle, k)) {
      pair.kind = Kind::face_vertex;
      pair.tool = t;
      pair.scene[0] = s[k];
      add(pair, placement, distance);
    }
  }
  pair.kind = Kind::edge_edge;
  for (int i = 0; i < 3; ++i) {
    if (!tool_features_.owns_edge(ids.tool, i)) continue;
    pair.tool_corner = i;
    pair.tool = {t[i], t[(i + 1) % 3], Vec3::Zero()};
    for (int k = 0; k < 3; ++k) {
      if (!scene_features.owns_edge(scene_triangle, k)) continue;
      pair.scene_corner = k;
      pair.scene = {s[k], s[(k + 1) % 3], Vec3::Zero()};
      add(pair, placement, distance);
    }
  }
}

void NearFeatures::add(const FeaturePair& pair, const Placement& placement, double distance) noexcept {
  if (is_beyond(pair, placement, distance)) return;
  if (count_ == features_.size()) {
    fits_ = false;
    return;
  }
  NearFeature& near = features_[count_];
  near.pair = pair;
  near.gap = measure_gap(pair, placement);
  if (!(near.gap.distance <= distance)) return;
  near.is_minimum = is_minimum(pair, near.gap, placement);
  ++count_;
}

// A minimum between a vertex and a vertex or an edge is found as vertex_face, one between an edge and a vertex as face_vertex.
bool NearFeatures::is_minimum(const FeaturePair& pair, const FeatureGap& gap, const Placement& placement) const noexcept {
  const SurfaceFeatures& scene = scene_features_[scene_->mesh_of(pair.scene_triangle)];
  const std::uint32_t scene_triangle = scene_->triangle_of(pair.scene_triangle);
  const Vec3 to_tool = gap.normal;                                          // outward from the scene, its frame
  const Vec3 to_scene = -(placement.orientation.conjugate() * gap.normal);  // outward from the tool, its axes
  switch (pair.kind) {
    case Kind::vertex_face:
      return tool_features_.is_top(tool_->triangle(pair.tool_triangle)[pair.tool_corner], to_scene) &&
             is_top_of(scene, scene_triangle, gap.feature, to_tool);
    case Kind::face_vertex:
      return !is_vertex(gap.feature) && scene.is_top(scene.surface().triangle(scene_triangle)[pair.scene_corner], to_tool) &&
             is_top_of(tool_features_, pair.tool_triangle, gap.feature, to_scene);
    case Kind::edge_edge:
      break;
  }
  return gap.feature == TriangleFeature::face && tool_features_.is_top(pair.tool_triangle, pair.tool_corner, to_scene) &&
         scene.is_top(scene_triangle, pair.scene_corner, to_tool);
}

}  // namespace hapton
