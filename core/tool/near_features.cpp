#include "core/tool/near_features.h"

#include <algorithm>

#include "core/geometry/triangle_distance.h"

namespace hapton {
namespace {

using Kind = FeaturePair::Kind;

// Candidates are kept within a share of the distance asked for: few are cheap to keep, and those from farther away serve more calls.
constexpr std::size_t kFew = 256;  // pairs of triangles
constexpr std::size_t kMany = 2048;
constexpr double kLeastShare = 1.25;
constexpr double kMostShare = 16.0;

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
      candidates_(kMostFeatures),
      features_(kMostFeatures) {}

bool NearFeatures::is_covered(const Placement& placement, double distance) const noexcept {
  const double moved = (placement.position - found_at_.position).norm() +
                       radius_ * turn_between(found_at_.orientation, placement.orientation).norm() + 0x1p-45 * (1.0 + radius_);
  // Many that are far away cost each call more than a new search.
  const bool is_wide = candidate_count_ > kFew && within_ > 2.0 * share_ * distance;
  return distance + moved <= within_ && !is_wide;
}

bool NearFeatures::find_candidates(const Placement& placement, double within, std::size_t most_pairs) noexcept {
  candidate_count_ = 0;
  fits_ = pairs_.collect(placement, within, most_pairs);
  const double reach = within * (1.0 + 0x1p-40) + 0x1p-45 * (1.0 + radius_);
  std::uint32_t last = ~0U;
  MovedTriangle tool;
  for (const TrianglePairIds& ids : pairs_.pairs()) {
    if (!fits_) break;
    if (ids.tool != last) {
      last = ids.tool;
      tool = MovedTriangle(placement.at(tool_->corner(ids.tool, 0)), placement.at(tool_->corner(ids.tool, 1)),
                           placement.at(tool_->corner(ids.tool, 2)));
    }
    const ObjectGeometry::Corners c = scene_->corners(ids.scene);
    const MovedTriangle scene(c.a, c.b, c.c);
    if (!tool.box.inflated(reach).overlaps(scene.box) || scene.is_apart(tool, reach) || tool.is_apart(scene, reach)) continue;
    add_candidates(ids, tool, scene, reach);
  }
  within_ = fits_ ? within : -1.0;
  found_at_ = placement;
  return fits_;
}

bool NearFeatures::refresh(const Placement& placement, double distance) noexcept {
  if (share_ > kLeastShare && find_candidates(placement, share_ * distance, kMany)) {
    if (pairs_.pairs().size() < kFew) share_ = std::min(1.5 * share_, kMostShare);
    return true;
  }
  share_ = std::max(0.5 * share_, kLeastShare);
  return find_candidates(placement, kLeastShare * distance, kMostTrianglePairs) ||
         find_candidates(placement, distance * (1.0 + 0x1p-40), kMostTrianglePairs);
}

bool NearFeatures::collect(const Placement& placement, double distance, double turn) noexcept {
  count_ = 0;
  if (!is_covered(placement, distance) && !refresh(placement, distance)) return false;
  for (std::size_t i = 0; i < candidate_count_; ++i) {
    const FeaturePair& pair = candidates_[i];
    if (is_beyond(pair, placement, distance)) continue;
    NearFeature& near = features_[count_];
    near.gap = measure_gap(pair, placement);
    if (!(near.gap.distance <= distance)) continue;
    near.pair = pair;
    near.is_minimum = is_minimum(pair, near.gap, placement, turn);
    ++count_;
  }
  return true;
}

void NearFeatures::add_candidates(const TrianglePairIds& ids, const MovedTriangle& tool, const MovedTriangle& scene,
                                  double reach) noexcept {
  const SurfaceFeatures& scene_features = scene_features_[scene_->mesh_of(ids.scene)];
  const std::uint32_t scene_triangle = scene_->triangle_of(ids.scene);
  const ObjectGeometry::Corners t = tool_->corners(ids.tool);
  const std::array<Vec3, 3> own = {t.a, t.b, t.c};
  const std::array<Vec3, 3>& s = scene.corner;
  const double squared = reach * reach;
  FeaturePair pair;
  pair.tool_triangle = ids.tool;
  pair.scene_triangle = ids.scene;
  for (int k = 0; k < 3; ++k) {
    pair.tool_corner = pair.scene_corner = k;
    if (tool_features_.owns_vertex(ids.tool, k) && scene.is_near_plane(tool.corner[k], reach) &&
        triangle_distance_squared(tool.corner[k], s[0], s[1], s[2]) <= squared) {
      pair.kind = Kind::vertex_face;
      pair.tool[0] = own[k];
      pair.scene = s;
      add_candidate(pair);
    }
    if (scene_features.owns_vertex(scene_triangle, k) && tool.is_near_plane(s[k], reach) &&
        triangle_distance_squared(s[k], tool.corner[0], tool.corner[1], tool.corner[2]) <= squared) {
      pair.kind = Kind::face_vertex;
      pair.tool = own;
      pair.scene[0] = s[k];
      add_candidate(pair);
    }
  }
  pair.kind = Kind::edge_edge;
  for (int i = 0; i < 3; ++i) {
    if (!tool_features_.owns_edge(ids.tool, i)) continue;
    const Vec3& a = tool.corner[i];
    const Vec3& a_end = tool.corner[(i + 1) % 3];
    const Box around = Box::around(a, a_end).inflated(reach);
    for (int k = 0; k < 3; ++k) {
      const Vec3& b = s[k];
      const Vec3& b_end = s[(k + 1) % 3];
      if (!scene_features.owns_edge(scene_triangle, k) || !around.overlaps(Box::around(b, b_end))) continue;
      if (detail::segment_segment_distance_squared(of3(a), of3(Vec3(a_end - a)), of3(b), of3(Vec3(b_end - b))) > squared) continue;
      pair.tool_corner = i;
      pair.tool = {own[i], own[(i + 1) % 3], Vec3::Zero()};
      pair.scene_corner = k;
      pair.scene = {b, b_end, Vec3::Zero()};
      add_candidate(pair);
    }
  }
}

void NearFeatures::add_candidate(const FeaturePair& pair) noexcept {
  fits_ = fits_ && candidate_count_ < candidates_.size();
  if (fits_) candidates_[candidate_count_++] = pair;
}

// A minimum between a vertex and a vertex or an edge is found as vertex_face, one between an edge and a vertex as face_vertex.
bool NearFeatures::is_minimum(const FeaturePair& pair, const FeatureGap& gap, const Placement& placement, double turn) const noexcept {
  const SurfaceFeatures& scene = scene_features_[scene_->mesh_of(pair.scene_triangle)];
  const std::uint32_t scene_triangle = scene_->triangle_of(pair.scene_triangle);
  const Vec3 to_tool = gap.normal;                                          // outward from the scene, its frame
  const Vec3 to_scene = -(placement.orientation.conjugate() * gap.normal);  // outward from the tool, its axes
  const double slope = SurfaceFeatures::kFlat + (gap.feature == TriangleFeature::face ? turn : 0.0);
  switch (pair.kind) {
    case Kind::vertex_face:
      return tool_features_.is_top(tool_->triangle(pair.tool_triangle)[pair.tool_corner], to_scene, slope) &&
             is_top_of(scene, scene_triangle, gap.feature, to_tool);
    case Kind::face_vertex:
      return !is_vertex(gap.feature) && scene.is_top(scene.surface().triangle(scene_triangle)[pair.scene_corner], to_tool, slope) &&
             is_top_of(tool_features_, pair.tool_triangle, gap.feature, to_scene);
    case Kind::edge_edge:
      break;
  }
  return gap.feature == TriangleFeature::face && tool_features_.is_top(pair.tool_triangle, pair.tool_corner, to_scene, slope) &&
         scene.is_top(scene_triangle, pair.scene_corner, to_tool, slope);
}

}  // namespace hapton
