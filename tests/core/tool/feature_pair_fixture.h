#pragma once

#include <gtest/gtest.h>

#include <array>
#include <random>

#include "core/tool/feature_pair.h"

namespace hapton {

// Random pairs of features, placements and vectors.
class FeaturePairTest : public testing::Test {
 protected:
  using Kind = FeaturePair::Kind;

  static constexpr unsigned kSeed = 1996;
  static constexpr std::array kKinds = {Kind::vertex_face, Kind::face_vertex, Kind::edge_edge};
  std::mt19937_64 random{kSeed};
  std::uniform_real_distribution<double> uniform{-1.0, 1.0};

  Vec3 draw(double size) { return size * Vec3(uniform(random), uniform(random), uniform(random)); }
  FeaturePair draw_pair(Kind kind) {
    FeaturePair pair;
    pair.kind = kind;
    for (int k = 0; k < 3; ++k) {
      pair.tool[k] = draw(0.3);
      pair.scene[k] = draw(0.3);
    }
    return pair;
  }
  Placement draw_placement() { return {draw(0.2), turn_by(draw(2.0))}; }
};

}  // namespace hapton
