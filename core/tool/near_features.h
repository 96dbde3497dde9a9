#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/tool/feature_pair.h"
#include "core/tool/near_pairs.h"
#include "core/tool/surface_features.h"

namespace hapton {

// A pair of features and its distance at the placement of the last collect.
struct NearFeature {
  FeaturePair pair;
  FeatureGap gap;
  // The distance of the surfaces has a local minimum here. Other pairs have a nearer one beside them, which bounds the motion in their
  // place; as constraints they would be walls that are not there.
  bool is_minimum = false;
};

// All pairs of features of tool and scene within a distance. Those within a larger one are kept as candidates from one call to the next,
// while the tool moves little (temporal coherence).
// Work: that of the pairs of triangles near each other, at most kMostTrianglePairs, and their features, at most kMostFeatures. RT: collect
// yes, construction set-up only. Pre: the geometries outlive this; the scene is built at once.
class NearFeatures {
 public:
  static constexpr std::size_t kMostTrianglePairs = 1U << 17;
  static constexpr std::size_t kMostFeatures = 1U << 14;

  NearFeatures(const ObjectGeometry& tool, const TouchGeometry& scene);

  // Finds the pairs that are no farther apart than `distance`. False if there are more than fit: they are then incomplete. What becomes a
  // minimum when the tool turns by `turn` counts as one, if its closest points are inside a face or two edges, whose normal then holds
  // still.
  bool collect(const Placement& placement, double distance, double turn) noexcept;
  std::span<const NearFeature> features() const { return {features_.data(), count_}; }
  // True if triangles of tool and scene intersect at the placement of the last collect (exact signs).
  bool any_intersect(const Placement& placement) const noexcept { return pairs_.any_intersect(placement); }

  // Largest distance of a point of the tool from the grip point.
  double radius() const { return radius_; }

 private:
  // A triangle in the scene's frame, with what tells quickly that something is far from it.
  struct MovedTriangle {
    MovedTriangle() = default;
    MovedTriangle(const Vec3& a, const Vec3& b, const Vec3& c)
        : corner{a, b, c}, normal((b - a).cross(c - a)), length(normal.norm()), box{a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)} {}

    bool is_near_plane(const Vec3& p, double reach) const { return std::fabs(normal.dot(p - corner[0])) <= reach * length; }
    // True if the other is farther than `reach` from this one's plane.
    bool is_apart(const MovedTriangle& other, double reach) const {
      const double a = normal.dot(other.corner[0] - corner[0]);
      const double b = normal.dot(other.corner[1] - corner[0]);
      const double c = normal.dot(other.corner[2] - corner[0]);
      return std::min({a, b, c}) > reach * length || std::max({a, b, c}) < -reach * length;
    }

    std::array<Vec3, 3> corner;
    Vec3 normal;  // not of unit length
    double length = 0.0;
    Box box;
  };

  bool is_covered(const Placement& placement, double distance) const noexcept;
  bool find_candidates(const Placement& placement, double within, std::size_t most_pairs) noexcept;
  bool refresh(const Placement& placement, double distance) noexcept;
  void add_candidates(const TrianglePairIds& ids, const MovedTriangle& tool, const MovedTriangle& scene, double reach) noexcept;
  void add_candidate(const FeaturePair& pair) noexcept;
  bool is_minimum(const FeaturePair& pair, const FeatureGap& gap, const Placement& placement, double turn) const noexcept;

  const ObjectGeometry* tool_;
  const TouchGeometry* scene_;
  SurfaceFeatures tool_features_;
  std::vector<SurfaceFeatures> scene_features_;  // by object
  NearPairs pairs_;
  double radius_ = 0.0;
  std::vector<FeaturePair> candidates_;
  std::size_t candidate_count_ = 0;
  double within_ = -1.0;  // distance of the candidates, at the placement where they were found; below 0: there are none
  Placement found_at_;
  double share_ = 4.0;  // of the distance asked for: what candidates are kept within
  std::vector<NearFeature> features_;
  std::size_t count_ = 0;
  bool fits_ = true;
};

}  // namespace hapton
