#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "core/tool/contact_surface.h"
#include "core/tool/feature_pair.h"
#include "core/tool/feature_set.h"
#include "core/tool/near_pairs.h"
#include "core/tool/obb_front.h"

namespace hapton {

// A pair of features, one of the tool and one of the scene, and its distance at the placement of the last collect or follow.
struct NearFeature {
  FeaturePair pair;
  FeatureGap gap;
  // The distance of the surfaces has a local minimum at this pair. Next to a pair that is not a minimum there is a nearer pair, which
  // bounds the motion instead; as a constraint, the pair itself would act as a wall that does not exist.
  bool is_minimum = false;
};

// The pairs of features of tool and scene that matter for a motion of the tool: all within a distance, and those that come within it during
// the motion. A pair that only slides tangentially is left out, however fast it is, so only a few of the near pairs remain (constraint
// generation: the caller finds a motion from few pairs, and adds those that this motion brings together).
// The workers of a team share the work; the result does not depend on their number. Frame and units: TouchGeometry's local ones. Work of
// collect and extend: at most ObbFront::kMaxTests pairs of boxes, and kMaxFeatures pairs of features. RT: collect, extend, follow and
// any_intersect yes with one worker, construction set-up only. Pre: geometries and team outlive this; scene not built on_approach.
class NearFeatures {
 public:
  static constexpr std::size_t kMaxTrianglePairs = 1U << 17;  // of any_intersect; a choice
  static constexpr std::size_t kMaxFeatures = 1U << 14;       // pairs of features; a choice

  NearFeatures(const ObjectGeometry& tool, const TouchGeometry& scene, WorkerTeam& team = calling_thread());
  // The same, with surfaces that were made before. Pre: they belong to this tool and this scene.
  NearFeatures(const ObjectGeometry& tool, std::shared_ptr<const ToolSurface> tool_surface, const TouchGeometry& scene,
               std::shared_ptr<const SceneSurface> scene_surface, WorkerTeam& team = calling_thread());
  // The same tool and another scene; the tool's surface is shared.
  NearFeatures(const NearFeatures& other, const TouchGeometry& scene, std::shared_ptr<const SceneSurface> scene_surface, WorkerTeam& team);
  NearFeatures(const NearFeatures&) = delete;  // front_ points to the trees
  NearFeatures& operator=(const NearFeatures&) = delete;

  // Finds the pairs with at most this distance. False: a limit of the work was exceeded, and features() is incomplete.
  // turn, rad: a pair that becomes a minimum if the tool turns by this angle counts as a minimum, if its closest points are inside a face
  // or inside two edges, so that its normal does not change.
  bool collect(const Placement& placement, double distance, double turn) noexcept;
  // Adds all pairs that come as near as `distance` during a motion, and some that do not. Their gaps are those at its start. False: as for
  // collect. Pre: motion.from is the placement of the last collect or follow.
  bool extend(const RigidMotion& motion, double distance) noexcept;
  // In place of collect(), after the tool has made the motion of the last extend() or a part of it and is at `placement`: updates the gaps
  // and minima of all known pairs. All pairs that are no farther apart than the distance of that extend() are among them. Pre: the last
  // call of collect or extend returned true, and was extend.
  void follow(const Placement& placement, double turn) noexcept;
  // The next traversal starts at the roots of the trees (ObbFront::restart).
  void restart() noexcept { front_.restart(); }
  // The pairs of the last collect, then those that each extend has added; their gaps are those at the last collect or follow.
  std::span<const NearFeature> features() const { return {features_.data(), count_}; }
  // True if triangles of tool and scene intersect (exact predicates), or if the boxes of more than kMaxTrianglePairs pairs overlap.
  bool any_intersect(const Placement& placement) noexcept;

  // The object of the scene to which the pair belongs.
  std::uint32_t object_of(const FeaturePair& pair) const { return scene_->mesh_of(pair.scene_triangle); }

  // Largest distance of a point of the tool from the grip point.
  double radius() const { return radius_; }

 private:
  static constexpr std::size_t kCachedTriangles = 128;  // triangles of the tool that a worker caches; a power of two

  // A triangle in the scene's frame.
  struct PlacedTriangle {
    PlacedTriangle() = default;
    PlacedTriangle(const Vec3& a, const Vec3& b, const Vec3& c)
        : corner{a, b, c},
          normal((b - a).cross(c - a)),
          length(normal.norm()),
          box(Box::around(a, b, c)),
          normal_error(0x1p-48 * box.diagonal()) {}

    std::array<Vec3, 3> corner;
    Vec3 normal;  // not of unit length
    double length = 0.0;
    Box box;
    double normal_error = 0.0;  // bound of the rounding error of the normal
  };
  // A triangle of the tool at the start of a motion, and the box that it sweeps.
  struct SweptTriangle : PlacedTriangle {
    void place(const ObjectGeometry::Corners& own, const LinearizedMotion& motion, double within);

    std::uint64_t walk = 0;  // the traversal that it was made for
    std::uint32_t triangle = 0;

    std::array<Vec3, 3> moved;  // displacement of each corner over the motion
    double max_displacement = 0.0;
    double reach = 0.0;  // if the straight lines from start to end are farther apart than this, the paths stay farther than `within`
    Box swept;           // box of the straight lines of its corners, inflated by the reach
  };

  struct Found {
    NearFeature near;
    std::uint32_t place;  // position of the visit in the traversal (ObbFront::VisitId)
  };
  // Data of one worker in a call.
  struct Worker {
    std::vector<SweptTriangle> swept;  // cache, by triangle number modulo kCachedTriangles
    std::vector<Found> found;          // pairs that are not in features_
  };
  // A visited pair of triangles, and the least squared distance of all its features, and of those that are not known yet.
  struct Visit {
    Worker& worker;
    std::uint32_t place;
    const SweptTriangle& tool;
    std::array<Vec3, 3> scene;  // corners
    FeaturePair pair = {};
    std::uint16_t near = 0;  // bits of the features that are near: found now, or known before
    bool fits = true;        // false: no room for more pairs of features
    double all_squared = std::numeric_limits<double>::infinity();
    double new_squared = std::numeric_limits<double>::infinity();
  };

  const SweptTriangle& swept(Worker& worker, std::uint32_t triangle, const LinearizedMotion& motion, double distance) const noexcept;
  // Lower bound of the distance of two triangles at the start of the motion; `is_separated`: a fixed plane separates them over the whole
  // motion.
  struct PlaneGap {
    double gap = 0.0;
    bool is_separated = false;
    Vec3 direction = Vec3::Zero();  // normal of that plane, from the scene to the tool, of any length; zero: no plane
  };
  static PlaneGap find_plane_gap(const SweptTriangle& tool, const PlacedTriangle& scene) noexcept;
  static PlaneGap find_box_gap(const SweptTriangle& tool, const PlacedTriangle& scene) noexcept;
  static ObbFront::Visited separated_by(const PlaneGap& plane, const SweptTriangle& tool, const PlacedTriangle& scene) noexcept;
  // features: bits of the features to consider.
  ObbFront::Visited find_near(Visit& visit, std::uint16_t features) const noexcept;
  // These add the features that matter for the motion to Worker::found.
  void add_features(std::uint16_t features, Visit& visit) const noexcept;
  void add_vertices(std::uint16_t features, Visit& visit) const noexcept;
  void add_edges(std::uint16_t features, Visit& visit) const noexcept;
  void add(double distance_squared, std::uint16_t feature, Visit& visit) const noexcept;
  bool add_if_near(Visit& visit) const noexcept;  // false: the pair was not added
  bool is_minimum(const FeaturePair& pair, const FeatureGap& gap) const noexcept;
  const SurfaceFeatures& features_at(std::uint32_t scene_triangle) const noexcept {
    return *scene_surface_->features[scene_->mesh_of(scene_triangle)];
  }
  bool merge_found() noexcept;  // moves what the workers have found to features_. False: it does not fit

  const ObjectGeometry* tool_;
  const TouchGeometry* scene_;
  std::shared_ptr<const ToolSurface> tool_surface_;
  std::shared_ptr<const SceneSurface> scene_surface_;
  const SurfaceFeatures& tool_features_;  // of tool_surface_
  NearPairs pairs_;
  double radius_ = 0.0;
  ObbFront front_;
  Placement placement_;  // of the last collect or follow
  double turn_ = 0.0;
  double covered_distance_ = 0.0;  // all pairs with at most this distance at placement_ are known
  double covered_on_path_ = 0.0;   // the same at every placement on the motion of the last extend
  std::vector<NearFeature> features_;
  std::size_t count_ = 0;
  FeatureSet known_pairs_;  // the pairs in features_
  std::vector<Worker> workers_;
  std::uint64_t walk_ = 0;  // number of the present traversal
};

}  // namespace hapton
