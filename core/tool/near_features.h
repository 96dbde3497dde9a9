#pragma once

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

// All pairs of features of tool and scene within a distance. Pairs of triangles are kept from one call to the next while the tool moves
// little (temporal coherence).
// Work: that of the pairs of triangles near each other, at most kMostTrianglePairs, and their features, at most kMostFeatures. RT: collect
// yes, construction set-up only. Pre: the geometries outlive this; the scene is built at once.
class NearFeatures {
 public:
  static constexpr std::size_t kMostTrianglePairs = 1U << 17;
  static constexpr std::size_t kMostFeatures = 1U << 14;

  NearFeatures(const ObjectGeometry& tool, const TouchGeometry& scene);

  // Finds the pairs that are no farther apart than `distance`. False if there are more than fit: they are then incomplete.
  bool collect(const Placement& placement, double distance) noexcept;
  std::span<const NearFeature> features() const { return {features_.data(), count_}; }
  // Pairs of triangles with boxes near each other: those of the last collect, and some from farther away.
  std::span<const TrianglePairIds> triangle_pairs() const { return pairs_.pairs(); }

  // Largest distance of a point of the tool from the grip point.
  double radius() const { return radius_; }

 private:
  bool refresh_pairs(const Placement& placement, double distance) noexcept;
  void add_pair(const TrianglePairIds& ids, const Placement& placement, double distance) noexcept;
  void add(const FeaturePair& pair, const Placement& placement, double distance) noexcept;
  bool is_minimum(const FeaturePair& pair, const FeatureGap& gap, const Placement& placement) const noexcept;

  const ObjectGeometry* tool_;
  const TouchGeometry* scene_;
  SurfaceFeatures tool_features_;
  std::vector<SurfaceFeatures> scene_features_;  // by object
  NearPairs pairs_;
  double radius_ = 0.0;
  double pairs_within_ = -1.0;  // of the pairs kept, and the placement they were found at; below 0: none are kept
  Placement pairs_at_;
  std::vector<NearFeature> features_;
  std::size_t count_ = 0;
  bool fits_ = true;
};

}  // namespace hapton
