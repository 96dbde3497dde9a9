#include "core/tool/near_features.h"

#include <algorithm>
#include <limits>

#include "core/geometry/triangle_distance.h"

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
      tool_tree_(tool),
      scene_tree_(scene),
      pairs_(tool, scene, kMostTrianglePairs),
      radius_(radius_of(tool)),
      front_(tool_tree_, scene_tree_, radius_),
      features_(kMostFeatures),
      known_(kMostFeatures),
      swept_(kSwept) {}

void NearFeatures::SweptTriangle::place(const ObjectGeometry::Corners& own, const SweptMotion& motion, double within) {
  const std::array<Vec3, 3> arm = {motion.orientation * own.a, motion.orientation * own.b, motion.orientation * own.c};
  PlacedTriangle& placed = *this;
  placed = PlacedTriangle(motion.from.position + arm[0], motion.from.position + arm[1], motion.from.position + arm[2]);
  double longest = 0.0;
  most_moved = 0.0;
  swept = box;
  for (int k = 0; k < 3; ++k) {
    moved[k] = motion.displacement(arm[k]);
    most_moved = std::max(most_moved, moved[k].squaredNorm());
    longest = std::max(longest, arm[k].squaredNorm());
    swept.grow(corner[k] + moved[k]);
  }
  most_moved = std::sqrt(most_moved);
  longest = std::sqrt(longest);
  reach = within * (1.0 + 0x1p-40) + motion.sagitta * longest + 0x1p-45 * (1.0 + longest);
  swept = swept.inflated(reach);
}

bool NearFeatures::any_intersect(const Placement& placement) noexcept {
  return !pairs_.collect(placement, 0.0, kMostTrianglePairs) || pairs_.any_intersect(placement);
}

bool NearFeatures::collect(const Placement& placement, double distance, double turn) noexcept {
  count_ = 0;
  known_.clear();
  placement_ = placement;
  turn_ = turn;
  within_ = 0.0;
  if (!extend(RigidMotion{placement}, distance)) return false;
  within_ = distance;
  return true;
}

bool NearFeatures::extend(const RigidMotion& motion, double distance) noexcept {
  if (motion.length(radius_) + distance <= within_) return true;
  const SweptMotion path(motion);
  fits_ = true;
  ++walk_;
  ++g_walks;
  return front_.for_each_near(path, distance, [&](std::uint32_t own, std::uint32_t id) {
    const SweptTriangle& tool = swept(own, path, distance);
    const ObjectGeometry::Corners c = scene_->corners(id);
    const PlacedTriangle scene(c.a, c.b, c.c);
    if (++g_tris, !are_apart(tool, scene)) add_triangles({own, id}, tool, scene);
    return fits_;
  });
}

const NearFeatures::SweptTriangle& NearFeatures::swept(std::uint32_t triangle, const SweptMotion& motion, double distance) noexcept {
  SweptTriangle& tool = swept_[triangle % kSwept];
  if (tool.walk != walk_ || tool.triangle != triangle) {
    tool.place(tool_->corners(triangle), motion, distance);
    tool.walk = walk_;
    tool.triangle = triangle;
  }
  return tool;
}

// True if the plane of either triangle, held fixed, separates them over the motion by more than the reach.
bool NearFeatures::are_apart(const SweptTriangle& tool, const PlacedTriangle& scene) noexcept {
  if (!tool.swept.overlaps(scene.box)) return true;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  double falls = 0.0;
  double rises = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double at = scene.normal.dot(tool.corner[k] - scene.corner[0]);
    const double by = scene.normal.dot(tool.moved[k]);
    low = std::min(low, at + std::min(0.0, by));
    high = std::max(high, at + std::max(0.0, by));
    const double own = tool.normal.dot(tool.moved[k]);
    falls = std::min(falls, own);
    rises = std::max(rises, own);
  }
  if (low > tool.reach * scene.length || high < -tool.reach * scene.length) return true;
  low = std::numeric_limits<double>::infinity();
  high = -low;
  for (const Vec3& p : scene.corner) {
    const double at = tool.normal.dot(p - tool.corner[0]);
    low = std::min(low, at);
    high = std::max(high, at);
  }
  return low - rises > tool.reach * tool.length || high - falls < -tool.reach * tool.length;
}

void NearFeatures::add_triangles(const TrianglePairIds& ids, const SweptTriangle& tool, const PlacedTriangle& scene) noexcept {
  const SurfaceFeatures& scene_features = scene_features_[scene_->mesh_of(ids.scene)];
  const std::uint32_t scene_triangle = scene_->triangle_of(ids.scene);
  const ObjectGeometry::Corners t = tool_->corners(ids.tool);
  const std::array<Vec3, 3>& s = scene.corner;
  const double reach = tool.reach + tool.most_moved;
  const double squared = reach * reach;
  FeaturePair pair;
  pair.tool_triangle = ids.tool;
  pair.scene_triangle = ids.scene;
  const std::array<Vec3, 3> own = {t.a, t.b, t.c};
  for (int k = 0; k < 3; ++k) {
    pair.tool_corner = pair.scene_corner = k;
    const double height = scene.normal.dot(tool.corner[k] - s[0]);
    const double end = height + scene.normal.dot(tool.moved[k]);
    const double limit = tool.reach * scene.length;
    if (tool_features_.owns_vertex(ids.tool, k) && std::min(height, end) <= limit && std::max(height, end) >= -limit &&
        triangle_distance_squared(tool.corner[k], s[0], s[1], s[2]) <= squared) {
      pair.kind = Kind::vertex_face;
      pair.tool[0] = own[k];
      pair.scene = s;
      add(pair, tool);
    }
    if (scene_features.owns_vertex(scene_triangle, k) &&
        std::fabs(tool.normal.dot(s[k] - tool.corner[0])) <= reach * tool.length &&
        triangle_distance_squared(s[k], tool.corner[0], tool.corner[1], tool.corner[2]) <= squared) {
      pair.kind = Kind::face_vertex;
      pair.tool = own;
      pair.scene[0] = s[k];
      add(pair, tool);
    }
  }
  add_edges(pair, tool, scene);
}

void NearFeatures::add_edges(FeaturePair& pair, const SweptTriangle& tool, const PlacedTriangle& scene) noexcept {
  const SurfaceFeatures& scene_features = scene_features_[scene_->mesh_of(pair.scene_triangle)];
  const std::uint32_t scene_triangle = scene_->triangle_of(pair.scene_triangle);
  const ObjectGeometry::Corners t = tool_->corners(pair.tool_triangle);
  const std::array<Vec3, 3> own = {t.a, t.b, t.c};
  const double reach = tool.reach + tool.most_moved;
  pair.kind = Kind::edge_edge;
  for (int i = 0; i < 3; ++i) {
    if (!tool_features_.owns_edge(pair.tool_triangle, i)) continue;
    const int next = (i + 1) % 3;
    const Vec3& a = tool.corner[i];
    const Vec3& a_end = tool.corner[next];
    Box around = Box::around(a, a_end);
    around.grow(Box::around(a + tool.moved[i], a_end + tool.moved[next]));
    around = around.inflated(tool.reach);
    pair.tool_corner = i;
    pair.tool = {own[i], own[next], Vec3::Zero()};
    for (int k = 0; k < 3; ++k) {
      const Vec3& b = scene.corner[k];
      const Vec3& b_end = scene.corner[(k + 1) % 3];
      if (!scene_features.owns_edge(scene_triangle, k) || !around.overlaps(Box::around(b, b_end))) continue;
      if (detail::segment_segment_distance_squared(of3(a), of3(Vec3(a_end - a)), of3(b), of3(Vec3(b_end - b))) > reach * reach) continue;
      pair.scene_corner = k;
      pair.scene = {b, b_end, Vec3::Zero()};
      add(pair, tool);
    }
  }
}

// Skips a pair that a plane between its closest points, held fixed, separates over the motion.
void NearFeatures::add(const FeaturePair& pair, const SweptTriangle& tool) noexcept {
  if (known_.has(pair)) return;
  const FeatureGap gap = measure_gap(pair, placement_);
  double approach = 0.0;
  if (pair.kind == Kind::face_vertex) {
    for (const Vec3& moved : tool.moved) approach = std::min(approach, gap.normal.dot(moved));
  } else {
    approach = std::min(approach, gap.normal.dot(tool.moved[pair.tool_corner]));
    if (pair.kind == Kind::edge_edge) approach = std::min(approach, gap.normal.dot(tool.moved[(pair.tool_corner + 1) % 3]));
  }
  if (gap.distance + approach > tool.reach) return;
  fits_ = fits_ && count_ < features_.size();
  if (!fits_) return;
  known_.insert(pair);
  ++g_added;
  features_[count_++] = {pair, gap, is_minimum(pair, gap)};
}

// A minimum between a vertex and a vertex or an edge is found as vertex_face, one between an edge and a vertex as face_vertex.
bool NearFeatures::is_minimum(const FeaturePair& pair, const FeatureGap& gap) const noexcept {
  const SurfaceFeatures& scene = scene_features_[scene_->mesh_of(pair.scene_triangle)];
  const std::uint32_t scene_triangle = scene_->triangle_of(pair.scene_triangle);
  const Vec3 to_tool = gap.normal;                                          // outward from the scene, its frame
  const Vec3 to_scene = -(placement_.orientation.conjugate() * gap.normal);  // outward from the tool, its axes
  const double slope = SurfaceFeatures::kFlat + (gap.feature == TriangleFeature::face ? turn_ : 0.0);
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
