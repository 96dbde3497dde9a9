#include "core/geometry/simplify_small.h"

#include <fmt/core.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <queue>
#include <span>
#include <utility>
#include <vector>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/triangle_distance.h"

namespace hapton {
namespace {

constexpr int kTries = 16;            // the last one uses 0.5 % of the bound: quadrics were off by a factor of six at most (decision 3)
constexpr double kErrorFactor = 0.7;  // factor of the quadrics' error bound from one attempt to the next
constexpr int kMaxIdle = 64;          // triangles visited in a row without coming nearer
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

// The triangles at each vertex.
class Fans {
 public:
  Fans(std::span<const Triangle> triangles, std::size_t vertices) : first_(vertices + 1, 0), triangles_(3 * triangles.size()) {
    for (const Triangle& t : triangles) {
      for (const std::uint32_t v : t) ++first_[v + 1];
    }
    for (std::size_t v = 0; v < vertices; ++v) first_[v + 1] += first_[v];
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t i = 0; i < triangles.size(); ++i) {
      for (const std::uint32_t v : triangles[i]) triangles_[next[v]++] = i;
    }
  }
  std::span<const std::uint32_t> operator[](std::uint32_t vertex) const {
    return {triangles_.data() + first_[vertex], first_[vertex + 1] - first_[vertex]};
  }

 private:
  std::vector<std::size_t> first_;
  std::vector<std::uint32_t> triangles_;
};

// For every vertex, the vertex still in use that is the fewest edges away; kNone if a whole piece was removed.
std::vector<std::uint32_t> find_nearest_kept(std::span<const Triangle> before, const Fans& fans_before, const Fans& fans_after,
                                             std::size_t vertices) {
  std::vector<std::uint32_t> nearest_kept(vertices, kNone);
  std::vector<std::uint32_t> queue;
  for (std::uint32_t v = 0; v < vertices; ++v) {
    if (fans_after[v].empty()) continue;
    nearest_kept[v] = v;
    queue.push_back(v);
  }
  for (std::size_t i = 0; i < queue.size(); ++i) {
    for (const std::uint32_t t : fans_before[queue[i]]) {
      for (const std::uint32_t v : before[t]) {
        if (nearest_kept[v] != kNone) continue;
        nearest_kept[v] = nearest_kept[queue[i]];
        queue.push_back(v);
      }
    }
  }
  return nearest_kept;
}

// Finds the triangle closest to a point: goes from triangle to triangle over common vertices, always from the closest one known. In a row
// of triangles without area each is as near as the one before it, so some steps may gain nothing.
class Descent {
 public:
  explicit Descent(const TriangleMesh& mesh)
      : mesh_(mesh), fans_(mesh.triangles, mesh.vertices.size()), last_search_(mesh.triangles.size(), 0) {}

  const Fans& fans() const { return fans_; }

  // The distance of p from the closest triangle found, in a search that starts at a vertex.
  double find_distance(std::uint32_t from, const Vec3& p) {
    ++search_;
    queue_ = {};
    visit_around(from, p);
    double least = queue_.top().first;
    for (int idle = 0; idle < kMaxIdle && !queue_.empty() && least > 0.0; ++idle) {
      const auto [distance, triangle] = queue_.top();
      queue_.pop();
      if (distance < least) least = distance, idle = 0;
      for (const std::uint32_t v : mesh_.triangles[triangle]) visit_around(v, p);
    }
    return std::sqrt(least);
  }

 private:
  void visit_around(std::uint32_t vertex, const Vec3& p) {
    for (const std::uint32_t t : fans_[vertex]) {
      if (last_search_[t] == search_) continue;
      last_search_[t] = search_;
      queue_.emplace(triangle_distance_squared(p, mesh_.corner(t, 0), mesh_.corner(t, 1), mesh_.corner(t, 2)), t);
    }
  }

  const TriangleMesh& mesh_;
  Fans fans_;
  std::vector<std::uint32_t> last_search_;
  std::uint32_t search_ = 0;
  using Visit = std::pair<double, std::uint32_t>;                         // squared distance, triangle
  std::priority_queue<Visit, std::vector<Visit>, std::greater<>> queue_;  // the nearest first
};

// The largest distance of a vertex of `before` from `mesh`, which has the same vertices.
double measure_deviation(std::span<const Triangle> before, const TriangleMesh& mesh) {
  const Fans fans_before(before, mesh.vertices.size());
  Descent descent(mesh);
  const auto nearest_kept = find_nearest_kept(before, fans_before, descent.fans(), mesh.vertices.size());
  double farthest = 0.0;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    if (fans_before[v].empty() || nearest_kept[v] == v) continue;
    if (nearest_kept[v] == kNone) return std::numeric_limits<double>::infinity();
    farthest = std::max(farthest, descent.find_distance(nearest_kept[v], mesh.vertices[v]));
  }
  return farthest;
}

// Single precision is enough to choose the vertices to remove; the others keep their double precision.
std::vector<float> positions_in_unit_box(const TriangleMesh& mesh, const Vec3& low, double side) {
  std::vector<float> positions;
  positions.reserve(3 * mesh.vertices.size());
  for (const Vec3& v : mesh.vertices) {
    for (int k = 0; k < 3; ++k) positions.push_back(static_cast<float>((v[k] - low[k]) / side));
  }
  return positions;
}

std::vector<Triangle> simplify_by_quadrics(std::span<const Triangle> triangles, std::span<const float> positions, double error) {
  std::vector<unsigned int> indices;
  indices.reserve(3 * triangles.size());
  for (const Triangle& t : triangles) indices.insert(indices.end(), t.begin(), t.end());
  const std::size_t kept = meshopt_simplify(indices.data(), indices.data(), indices.size(), positions.data(), positions.size() / 3,
                                            3 * sizeof(float), 0, static_cast<float>(error), meshopt_SimplifyLockBorder, nullptr);
  std::vector<Triangle> fewer(kept / 3);
  for (std::size_t t = 0; t < fewer.size(); ++t) fewer[t] = {indices[3 * t], indices[3 * t + 1], indices[3 * t + 2]};
  return fewer;
}

}  // namespace

Result<SimplifyReport> simplify_small(TriangleMesh& mesh, double max_error_m) {
  const MeshBounds bounds = compute_bounds(mesh);
  const double side = mesh.vertices.empty() ? 0.0 : bounds.extent();
  if (!(max_error_m == 0.0 || (max_error_m > 0.0 && max_error_m < side))) {
    return fail("simplification: the error bound {:g} m is not from 0 to below the mesh's longest side, {:g} m", max_error_m, side);
  }
  SimplifyReport report;
  report.bound_m = max_error_m;
  report.before = report.after = mesh.triangles.size();
  if (max_error_m == 0.0 || mesh.triangles.empty()) return report;

  mesh.authored_normals.clear();  // they belong to the old triangles, which may be replaced now
  const std::vector<Triangle> before = std::move(mesh.triangles);
  const std::vector<float> positions = positions_in_unit_box(mesh, bounds.low, side);
  double error = max_error_m / side;
  for (int i = 0; i < kTries; ++i, error *= kErrorFactor) {
    mesh.triangles = simplify_by_quadrics(before, positions, error);
    report.error_m = measure_deviation(before, mesh);
    report.after = mesh.triangles.size();
    if (report.error_m <= max_error_m) return report;
  }
  mesh.triangles = before;
  report.after = report.before;
  report.error_m = 0.0;
  return report;
}

std::string SimplifyReport::describe() const {
  if (bound_m == 0.0) return fmt::format("simplify: off, {} triangles", before);
  if (before == after) return fmt::format("simplify: {} triangles, none merged within {:g} m", before, bound_m);
  return fmt::format("simplify: {} triangles made {}, no vertex moved farther than {:g} m of {:g} m allowed", before, after, error_m,
                     bound_m);
}

}  // namespace hapton
