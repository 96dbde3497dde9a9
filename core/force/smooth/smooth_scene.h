#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/collision/box.h"
#include "core/collision/fdh_scene.h"
#include "core/force/smooth/local_set.h"
#include "core/force/touch_scene.h"
#include "core/geometry/smooth_surface.h"

namespace hapton {

struct SmoothSceneSettings {
  SmoothSurfaceSettings surface;
  int directions = 14;  // of the Fixed Direction Hulls: 6, 14, 18 or 26
};

// The scene, prepared for the two tasks of the FDH paper: smooth surfaces, two levels of Fixed Direction Hulls. Frame S, metres.
// Threads: const calls from any number of threads, none while move_vertices runs. RT: select, for_each_near, triangle_at, getters yes.
class SmoothScene {
 public:
  // Error: see make_smooth_surface and FdhScene::build; directions other than 6, 14, 18 or 26.
  static Result<SmoothScene> build(const TouchScene& scene, const SmoothSceneSettings& settings);

  SmoothScene(const SmoothScene&) = delete;
  SmoothScene& operator=(const SmoothScene&) = delete;
  SmoothScene(SmoothScene&&) = default;
  SmoothScene& operator=(SmoothScene&&) = default;

  // The slow task: the `count` triangles nearest to the path from request.from to request.to. The old content of `set` bounds the search
  // and makes it faster; it never changes the result. Pre: 1 <= count <= LocalSet::kCapacity.
  FdhVisits select(const LocalSetRequest& request, std::uint32_t count, LocalSet& set) const noexcept;

  // Calls visit(SetTriangle) for every triangle that meets a ball (FdhBall) or a moving ball (FdhSweep), and perhaps for others.
  template <class Query, class Visit>
  void for_each_near(const Query& query, Visit&& visit) const noexcept {
    std::visit(
        [&](const auto& tree) {
          tree.for_each_overlapping(query, [&](std::uint32_t object, std::uint32_t triangle) { visit(triangle_at(object, triangle)); });
        },
        tree_);
  }
  // Calls visit(SetTriangle) for every triangle of the scene, degenerate ones included: the brute-force twin of the queries.
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (std::uint32_t o = 0; o < objects_.size(); ++o) {
      for (std::uint32_t t = 0; t < objects_[o].surface.mesh.triangles.size(); ++t) visit(triangle_at(o, t));
    }
  }

  // Calls visit(object, hull, triangles) for every hull at depth `level` of the objects' trees; hull: FdhHull<directions>. RT: no.
  template <class Visit>
  void for_each_hull(int level, Visit&& visit) const {
    std::visit(
        [&](const auto& tree) {
          for (std::size_t o = 0; o < tree.object_count(); ++o) {
            tree.tree(o).for_each_hull(level, [&](const auto& hull, std::span<const std::uint32_t> triangles) {
              visit(static_cast<std::uint32_t>(o), hull, triangles);
            });
          }
        },
        tree_);
  }

  SetTriangle triangle_at(std::uint32_t object, std::uint32_t triangle) const noexcept;

  // Moves one object's vertices, in the order of its mesh, and updates surface, normals and hulls. All local sets become invalid. RT: no.
  // Error: no such object; another number of vertices; coordinates that are not finite; an extent beyond the limits of FdhTree::build,
  // after which the surface has moved and the hulls have not: build the scene again.
  Result<void> move_vertices(std::uint32_t object, std::span<const Vec3> vertices);

  std::uint64_t version() const { return version_; }
  double diagonal() const { return diagonal_; }
  const Vec3& centre() const { return centre_; }
  // Far above the rounding of positions in this scene, far below what can be felt.
  double tolerance() const { return tolerance_; }
  std::size_t object_count() const { return objects_.size(); }
  const SmoothSurface& surface(std::size_t object) const { return objects_[object].surface; }
  FdhStats tree_stats() const;

  // A radius within which at most about `count` triangles lie around nearly every point of the surface: over about 256 evenly chosen faces,
  // the second percentile of the distance from a face's middle to the count-th nearest triangle. RT: set-up only.
  double compute_typical_radius(std::uint32_t count) const;

  std::string describe() const;

 private:
  double bound_search_radius(const LocalSetRequest& request, std::uint32_t count, const LocalSet& old_set) const noexcept;

  struct Object {
    SmoothSurface surface;
    SmoothSurfaceReport report;
    Material material;
    std::size_t vertex_count = 0;  // of the original mesh
    Box bounds;
  };

  SmoothScene() = default;
  void measure(Object& object);
  void measure_all();

  std::vector<Object> objects_;
  std::variant<FdhScene<6>, FdhScene<14>, FdhScene<18>, FdhScene<26>> tree_;
  int directions_ = 14;
  std::uint64_t version_ = 1;
  double diagonal_ = 0.0;
  Vec3 centre_ = Vec3::Zero();
  double tolerance_ = 0.0;
};

}  // namespace hapton
