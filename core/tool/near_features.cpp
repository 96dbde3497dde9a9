#include "core/tool/near_features.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/geometry/triangle_distance.h"

namespace hapton {
namespace {

using Kind = FeaturePair::Kind;

// A pair of triangles has 15 pairs of features, one bit each: the three vertices of each triangle with the face of the other one, and nine
// pairs of edges.
constexpr std::uint16_t kVertexBits = 0x3F;
std::uint16_t vertex_bit(int corner, bool is_of_tool) { return static_cast<std::uint16_t>(1U << (2 * corner + (is_of_tool ? 0 : 1))); }
std::uint16_t edge_bit(int tool_edge, int scene_edge) { return static_cast<std::uint16_t>(1U << (6 + 3 * tool_edge + scene_edge)); }

// Whether the closest feature belongs to this triangle and is a local maximum of the surface along `outward`; always true for a face.
bool is_local_maximum_of(const SurfaceFeatures& surface, std::uint32_t t, TriangleFeature feature, const Vec3& outward) {
  if (is_edge(feature)) {
    const int k = edge_number(feature);
    return surface.owns_edge(t, k) && surface.is_local_maximum(t, k, outward);
  }
  if (is_vertex(feature)) {
    const int k = vertex_number(feature);
    return surface.owns_vertex(t, k) && surface.is_local_maximum(surface.surface().triangle(t)[k], outward);
  }
  return true;
}

}  // namespace

NearFeatures::NearFeatures(const ObjectGeometry& tool, const TouchGeometry& scene, WorkerTeam& team)
    : NearFeatures(tool, std::make_shared<const ToolSurface>(tool), scene, std::make_shared<const SceneSurface>(scene), team) {}

NearFeatures::NearFeatures(const NearFeatures& other, const TouchGeometry& scene, std::shared_ptr<const SceneSurface> scene_surface,
                           WorkerTeam& team)
    : NearFeatures(*other.tool_, other.tool_surface_, scene, std::move(scene_surface), team) {}

NearFeatures::NearFeatures(const ObjectGeometry& tool, std::shared_ptr<const ToolSurface> tool_surface, const TouchGeometry& scene,
                           std::shared_ptr<const SceneSurface> scene_surface, WorkerTeam& team)
    : tool_(&tool),
      scene_(&scene),
      tool_surface_(std::move(tool_surface)),
      scene_surface_(std::move(scene_surface)),
      tool_features_(*tool_surface_->features),
      pairs_(tool, scene, kMaxTrianglePairs),
      radius_(tool_surface_->radius),
      front_(tool_surface_->tree, scene_surface_->tree, radius_, team),
      features_(kMaxFeatures),
      known_pairs_(kMaxFeatures),
      workers_(static_cast<std::size_t>(team.size())) {
  for (Worker& worker : workers_) {
    worker.swept.resize(kCachedTriangles);
    worker.found.reserve(kMaxFeatures);
  }
}

void NearFeatures::SweptTriangle::place(const ObjectGeometry::Corners& own, const LinearizedMotion& motion, double within) {
  const std::array<Vec3, 3> arm = {motion.orientation * own.a, motion.orientation * own.b, motion.orientation * own.c};
  PlacedTriangle& placed = *this;
  placed = PlacedTriangle(motion.from.position + arm[0], motion.from.position + arm[1], motion.from.position + arm[2]);
  double longest = 0.0;
  max_displacement = 0.0;
  swept = box;
  for (int k = 0; k < 3; ++k) {
    moved[k] = motion.displacement(arm[k]);
    max_displacement = std::max(max_displacement, moved[k].squaredNorm());
    longest = std::max(longest, arm[k].squaredNorm());
    swept.grow(corner[k] + moved[k]);
  }
  max_displacement = std::sqrt(max_displacement);
  longest = std::sqrt(longest);
  normal_error *= 1.0 + longest;
  reach = within * (1.0 + 0x1p-40) + motion.sagitta * longest + 0x1p-45 * (1.0 + longest);
  swept = swept.inflated(reach);
}

bool NearFeatures::any_intersect(const Placement& placement) noexcept {
  return !pairs_.collect(placement, 0.0) || pairs_.any_intersect(placement);
}

bool NearFeatures::collect(const Placement& placement, double distance, double turn) noexcept {
  count_ = 0;
  known_pairs_.clear();
  placement_ = placement;
  turn_ = turn;
  covered_distance_ = 0.0;
  front_.forget();
  if (!extend(RigidMotion{placement}, distance)) return false;
  covered_distance_ = distance;
  return true;
}

void NearFeatures::follow(const Placement& placement, double turn) noexcept {
  placement_ = placement;
  turn_ = turn;
  covered_distance_ = covered_on_path_;
  for (std::size_t i = 0; i < count_; ++i) {
    NearFeature& near = features_[i];
    near.gap = measure_gap(near.pair, placement);
    near.is_minimum = is_minimum(near.pair, near.gap);
  }
}

bool NearFeatures::extend(const RigidMotion& motion, double distance) noexcept {
  const double length = motion.length(radius_);
  covered_on_path_ = std::max(distance, covered_distance_ - length);
  if (length + distance <= covered_distance_) return true;
  const LinearizedMotion path(motion);
  ++walk_;
  for (Worker& worker : workers_) worker.found.clear();
  const bool is_whole =
      front_.for_each_near(path, distance, [&](ObbFront::VisitId visit_id, std::uint32_t own, std::uint32_t id, std::uint16_t features) {
        Worker& worker = workers_[static_cast<std::size_t>(visit_id.worker)];
        const SweptTriangle& tool = swept(worker, own, path, distance);
        const ObjectGeometry::Corners c = scene_->corners(id);
        Visit visit{worker, visit_id.place, tool, {c.a, c.b, c.c}};
        visit.pair.tool_triangle = own;
        visit.pair.scene_triangle = id;
        return find_near(visit, features);
      });
  if (!is_whole || !merge_found()) {
    front_.restart();
    return false;
  }
  return true;
}

ObbFront::Visited NearFeatures::find_near(Visit& visit, std::uint16_t features) const noexcept {
  double gap = 0.0;
  // Over a motion a separating plane may exclude a pair that the distances of its features do not exclude.
  if (features != ObbFront::kAllFeatures && visit.tool.max_displacement == 0.0) add_features(features, visit);
  if (visit.near == 0) {
    const PlacedTriangle scene(visit.scene[0], visit.scene[1], visit.scene[2]);
    const PlaneGap plane = find_plane_gap(visit.tool, scene);
    if (plane.is_separated) return separated_by(plane, visit.tool, scene);
    gap = plane.gap;
    add_features(ObbFront::kAllFeatures, visit);
  }
  return {std::max(gap, std::sqrt(visit.all_squared)), std::max(gap, std::sqrt(visit.new_squared)), visit.fits, visit.near};
}

void NearFeatures::add_features(std::uint16_t features, Visit& visit) const noexcept {
  if ((features & kVertexBits) != 0) add_vertices(features, visit);
  if ((features & ~kVertexBits) != 0) add_edges(features, visit);
}

bool NearFeatures::merge_found() noexcept {
  std::size_t found = 0;
  for (const Worker& worker : workers_) found += worker.found.size();
  if (count_ + found > features_.size()) return false;
  ObbFront::for_each_by_place(
      workers_, [](const Worker& worker) -> const std::vector<Found>& { return worker.found; },
      [&](const Found& one) {
        if (known_pairs_.insert(one.near.pair)) features_[count_++] = one.near;
      });
  return true;
}

const NearFeatures::SweptTriangle& NearFeatures::swept(Worker& worker, std::uint32_t triangle, const LinearizedMotion& motion,
                                                       double distance) const noexcept {
  SweptTriangle& tool = worker.swept[triangle % kCachedTriangles];
  if (tool.walk != walk_ || tool.triangle != triangle) {
    tool.place(tool_->corners(triangle), motion, distance);
    tool.walk = walk_;
    tool.triangle = triangle;
  }
  return tool;
}

NearFeatures::PlaneGap NearFeatures::find_plane_gap(const SweptTriangle& tool, const PlacedTriangle& scene) noexcept {
  struct Range {
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();
    void grow(double a) {
      low = std::min(low, a);
      high = std::max(high, a);
    }
    double from_zero() const { return std::max(low, -high); }
  };
  Range still;  // heights of the tool's corners above the scene triangle's plane, times the length of its normal
  Range moved;  // the same over the whole motion
  Range end;    // displacements of the tool's corners along the tool's normal; 0 at the start
  end.grow(0.0);
  for (int k = 0; k < 3; ++k) {
    const double at = scene.normal.dot(tool.corner[k] - scene.corner[0]);
    still.grow(at);
    moved.grow(at);
    moved.grow(at + scene.normal.dot(tool.moved[k]));
    end.grow(tool.normal.dot(tool.moved[k]));
  }
  Range other;  // heights of the scene's corners above the tool triangle's plane, times the length of its normal
  for (const Vec3& p : scene.corner) other.grow(tool.normal.dot(p - tool.corner[0]));
  const double span = (tool.corner[0] - scene.corner[0]).cwiseAbs().sum() + tool.box.diagonal() + scene.box.diagonal();
  const double scene_error = scene.normal_error * span;
  const double tool_error = tool.normal_error * span;
  PlaneGap found;
  if (moved.from_zero() > tool.reach * scene.length + scene_error) {
    found = {0.0, true, moved.low > 0.0 ? scene.normal : -scene.normal};
  } else if (std::max(other.low - end.high, end.low - other.high) > tool.reach * tool.length + tool_error) {
    found = {0.0, true, other.low > 0.0 ? -tool.normal : tool.normal};
  } else {
    found = find_box_gap(tool, scene);
  }
  if (scene.length > 0.0) found.gap = std::max(found.gap, (still.from_zero() - scene_error) / scene.length);
  if (tool.length > 0.0) found.gap = std::max(found.gap, (other.from_zero() - tool_error) / tool.length);
  return found;
}

// Triangles side by side in one plane are not separated by their own planes, but often by a plane perpendicular to an axis.
NearFeatures::PlaneGap NearFeatures::find_box_gap(const SweptTriangle& tool, const PlacedTriangle& scene) noexcept {
  const Vec3 above = tool.swept.low - scene.box.high;
  const Vec3 below = scene.box.low - tool.swept.high;
  int axis = 0;
  PlaneGap found;
  found.is_separated = above.cwiseMax(below).maxCoeff(&axis) > 0.0;
  if (!found.is_separated) return found;
  found.direction[axis] = std::copysign(1.0, above[axis]);
  found.gap = (tool.box.low - scene.box.high).cwiseMax(scene.box.low - tool.box.high).cwiseMax(0.0).norm();
  return found;
}

ObbFront::Visited NearFeatures::separated_by(const PlaneGap& plane, const SweptTriangle& tool, const PlacedTriangle& scene) noexcept {
  ObbFront::Visited visited{plane.gap, plane.gap, true};
  // The length of a shorter direction would be inexact (denormal numbers).
  visited.has_plane = plane.direction.squaredNorm() > 0x1p-900;
  if (!visited.has_plane) return visited;
  visited.normal = SeparatingPlanes::normal_along(plane.direction);
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (int k = 0; k < 3; ++k) {
    low = std::min(low, visited.normal.dot(tool.corner[k]));
    high = std::max(high, visited.normal.dot(scene.corner[k]));
  }
  visited.along_normal = low - high;
  return visited;
}

void NearFeatures::add_vertices(std::uint16_t features, Visit& visit) const noexcept {
  FeaturePair& pair = visit.pair;
  const SweptTriangle& tool = visit.tool;
  const SurfaceFeatures& scene_features = features_at(pair.scene_triangle);
  const std::uint32_t scene_triangle = scene_->triangle_of(pair.scene_triangle);
  const ObjectGeometry::Corners t = tool_->corners(pair.tool_triangle);
  const std::array<Vec3, 3> tool_points = {t.a, t.b, t.c};
  const std::array<Vec3, 3>& s = visit.scene;
  for (int k = 0; k < 3; ++k) {
    pair.tool_corner = pair.scene_corner = k;
    const std::uint16_t of_tool = vertex_bit(k, true);
    if ((features & of_tool) != 0 && tool_features_.owns_vertex(pair.tool_triangle, k)) {
      const double squared = triangle_distance_squared(tool.corner[k], s[0], s[1], s[2]);
      pair.kind = Kind::vertex_face;
      pair.tool[0] = tool_points[k];
      pair.scene = s;
      add(squared, of_tool, visit);
    }
    const std::uint16_t of_scene = vertex_bit(k, false);
    if ((features & of_scene) != 0 && scene_features.owns_vertex(scene_triangle, k)) {
      const double squared = triangle_distance_squared(s[k], tool.corner[0], tool.corner[1], tool.corner[2]);
      pair.kind = Kind::face_vertex;
      pair.tool = tool_points;
      pair.scene[0] = s[k];
      add(squared, of_scene, visit);
    }
  }
}

void NearFeatures::add_edges(std::uint16_t features, Visit& visit) const noexcept {
  FeaturePair& pair = visit.pair;
  const SweptTriangle& tool = visit.tool;
  const SurfaceFeatures& scene_features = features_at(pair.scene_triangle);
  const std::uint32_t scene_triangle = scene_->triangle_of(pair.scene_triangle);
  const ObjectGeometry::Corners t = tool_->corners(pair.tool_triangle);
  const std::array<Vec3, 3> tool_points = {t.a, t.b, t.c};
  pair.kind = Kind::edge_edge;
  for (int i = 0; i < 3; ++i) {
    const std::uint16_t of_edge = edge_bit(i, 0) | edge_bit(i, 1) | edge_bit(i, 2);
    if ((features & of_edge) == 0 || !tool_features_.owns_edge(pair.tool_triangle, i)) continue;
    const Vec3& a = tool.corner[i];
    const Vec3 d = tool.corner[(i + 1) % 3] - a;
    pair.tool_corner = i;
    pair.tool = {tool_points[i], tool_points[(i + 1) % 3], Vec3::Zero()};
    for (int k = 0; k < 3; ++k) {
      const std::uint16_t feature = edge_bit(i, k);
      if ((features & feature) == 0 || !scene_features.owns_edge(scene_triangle, k)) continue;
      const Vec3& b = visit.scene[k];
      const Vec3& b_end = visit.scene[(k + 1) % 3];
      const double squared = detail::segment_segment_distance_squared(of3(a), of3(d), of3(b), of3(Vec3(b_end - b)));
      pair.scene_corner = k;
      pair.scene = {b, b_end, Vec3::Zero()};
      add(squared, feature, visit);
    }
  }
}

void NearFeatures::add(double distance_squared, std::uint16_t feature, Visit& visit) const noexcept {
  visit.all_squared = std::min(visit.all_squared, distance_squared);
  const double reach = visit.tool.reach + visit.tool.max_displacement;
  if (distance_squared <= reach * reach && add_if_near(visit)) {
    visit.near = static_cast<std::uint16_t>(visit.near | feature);
  } else {
    visit.new_squared = std::min(visit.new_squared, distance_squared);
  }
}

// Adds the pair, unless it stays apart over the motion because a fixed plane between its closest points separates it.
bool NearFeatures::add_if_near(Visit& visit) const noexcept {
  const FeaturePair& pair = visit.pair;
  if (known_pairs_.has(pair)) return true;
  const SweptTriangle& tool = visit.tool;
  const FeatureGap gap = measure_gap(pair, placement_);
  double approach = 0.0;
  if (pair.kind == Kind::face_vertex) {
    for (const Vec3& moved : tool.moved) approach = std::min(approach, gap.normal.dot(moved));
  } else {
    approach = std::min(approach, gap.normal.dot(tool.moved[pair.tool_corner]));
    if (pair.kind == Kind::edge_edge) approach = std::min(approach, gap.normal.dot(tool.moved[(pair.tool_corner + 1) % 3]));
  }
  if (gap.distance + approach > tool.reach) return false;
  std::vector<Found>& found = visit.worker.found;
  visit.fits = visit.fits && count_ + found.size() < features_.size();
  if (!visit.fits) return false;
  found.push_back({{pair, gap, is_minimum(pair, gap)}, visit.place});
  return true;
}

// Minima of a tool vertex with a scene vertex or edge are found as vertex_face, those of a tool edge with a scene vertex as face_vertex.
bool NearFeatures::is_minimum(const FeaturePair& pair, const FeatureGap& gap) const noexcept {
  const SurfaceFeatures& scene = features_at(pair.scene_triangle);
  const std::uint32_t scene_triangle = scene_->triangle_of(pair.scene_triangle);
  const Vec3 to_tool = gap.normal;                                           // outward from the scene, in the scene's frame
  const Vec3 to_scene = -(placement_.orientation.conjugate() * gap.normal);  // outward from the tool, along the tool's axes
  const double slope = SurfaceFeatures::kFlat + (gap.feature == TriangleFeature::face ? turn_ : 0.0);
  switch (pair.kind) {
    case Kind::vertex_face:
      return tool_features_.is_local_maximum(tool_->triangle(pair.tool_triangle)[pair.tool_corner], to_scene, slope) &&
             is_local_maximum_of(scene, scene_triangle, gap.feature, to_tool);
    case Kind::face_vertex:
      return !is_vertex(gap.feature) &&
             scene.is_local_maximum(scene.surface().triangle(scene_triangle)[pair.scene_corner], to_tool, slope) &&
             is_local_maximum_of(tool_features_, pair.tool_triangle, gap.feature, to_scene);
    case Kind::edge_edge:
      break;
  }
  return gap.feature == TriangleFeature::face && tool_features_.is_local_maximum(pair.tool_triangle, pair.tool_corner, to_scene, slope) &&
         scene.is_local_maximum(scene_triangle, pair.scene_corner, to_tool, slope);
}

}  // namespace hapton
