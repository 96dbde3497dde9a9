#include "core/tool/separating_planes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/core/tool/random_vector.h"

namespace hapton {
namespace {

using Node = ObbTree::Node;

// The box of a node, placed in the scene, with the axes as the node stores them.
struct BoxInScene {
  Vec3 centre;
  Mat3 axes;
  Vec3 half;

  BoxInScene(const Node& node, const Placement& at) : centre(at.at(node.at())), half(node.half_size()) {
    for (int i = 0; i < 3; ++i) axes.col(i) = at.orientation * node.axis(i);
  }
  // The largest coordinate of the box's corners along a normal.
  double highest(const Vec3& normal) const {
    double most = -std::numeric_limits<double>::infinity();
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 y((corner & 1) != 0 ? half.x() : -half.x(), (corner & 2) != 0 ? half.y() : -half.y(),
                   (corner & 4) != 0 ? half.z() : -half.z());
      most = std::max(most, normal.dot(centre + axes * y));
    }
    return most;
  }
  // As the axes are only nearly orthonormal, this is only nearly the closest point; it is always a point of the box.
  Vec3 point_near(const Vec3& p) const {
    const Vec3 y = axes.inverse() * (p - centre);
    return centre + axes * y.cwiseMax(-half).cwiseMin(half);
  }
};

// Uses alternating projections: the result is never less than the distance, and hardly more.
double find_distance(const BoxInScene& a, const BoxInScene& b) {
  Vec3 p = a.centre;
  for (int i = 0; i < 60; ++i) p = a.point_near(b.point_near(p));
  return (b.point_near(p) - p).norm();
}

class SeparatingPlanesTest : public testing::Test {
 protected:
  static constexpr unsigned kSeed = 61;
  static constexpr std::size_t kPairs = 24;
  std::mt19937_64 random{kSeed};
  std::uniform_real_distribution<double> uniform{-1.0, 1.0};

  Vec3 draw() { return draw_in_cube(random); }
  // 10^-n, with n uniform from 0 to `orders`.
  double draw_size(double orders) { return std::pow(10.0, -0.5 * orders * (1.0 + uniform(random))); }

  Node draw_box(const Vec3& centre, double size) {
    Node node{};
    const Mat3 axes = turn_by(3.0 * draw()).toRotationMatrix();
    for (int k = 0; k < 3; ++k) {
      node.centre[k] = static_cast<float>(centre[k]);
      node.half[k] = static_cast<float>(size * draw_size(3.0));
      for (int i = 0; i < 3; ++i) node.axes[k][i] = static_cast<float>(axes(k, i));
    }
    return node;
  }

  // Pairs of boxes, some of which are near each other if the tool is at `at`.
  struct Pairs {
    std::vector<Node> tool;
    std::vector<Node> scene;
  };
  Pairs draw_pairs(const Placement& at, double scale) {
    Pairs pairs;
    for (std::size_t i = 0; i < kPairs; ++i) {
      const double size = scale * draw_size(4.0);
      pairs.tool.push_back(draw_box(0.5 * scale * draw(), size));
      pairs.scene.push_back(draw_box(at.at(pairs.tool.back().at()) + 4.0 * size * draw(), size * draw_size(1.0)));
    }
    return pairs;
  }

  static void put_plane_along(SeparatingPlanes& planes, std::size_t i, const Vec3& direction, const Node& tool, const Node& scene) {
    const Vec3 normal = SeparatingPlanes::normal_along(direction);
    planes.put(i, normal, planes.gap_along(normal, tool, scene), tool);
  }

  // Puts planes for the pairs that are apart. A normal points along the line between the closest points, turned a little.
  std::vector<bool> put_planes(SeparatingPlanes& planes, const Pairs& pairs, const Placement& at) {
    std::vector<bool> has_plane(kPairs, false);
    for (std::size_t i = 0; i < kPairs; ++i) {
      planes.clear(i);
      const BoxInScene tool(pairs.tool[i], at);
      const BoxInScene scene(pairs.scene[i], {});
      Vec3 p = tool.centre;
      for (int n = 0; n < 60; ++n) p = tool.point_near(scene.point_near(p));
      const Vec3 direction = p - scene.point_near(p);
      if (!(direction.norm() > 1e-9 * tool.half.norm())) continue;
      const Vec3 about = direction + 0.05 * direction.norm() * draw();
      if (i % 2 == 0) {
        put_plane_along(planes, i, about, pairs.tool[i], pairs.scene[i]);
      } else {
        const Vec3 normal = SeparatingPlanes::normal_along(about);
        planes.put(i, normal, -tool.highest(-normal) - scene.highest(normal), pairs.tool[i]);
      }
      has_plane[i] = true;
    }
    return has_plane;
  }

  static float gap_of(const Float8& gaps, std::size_t i) { return gaps[static_cast<int>(i % SeparatingPlanes::kTogether)]; }
};

// This holds after motions and turns of all sizes since the plane was put, in scenes of all sizes.
TEST_F(SeparatingPlanesTest, NoGapIsLargerThanTheDistanceOfTheBoxes) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  int positive_gaps = 0;
  for (const double scale : {1e-6, 1e-3, 1.0, 1e3, 1e6}) {
    for (int n = 0; n < 20; ++n) {
      SeparatingPlanes planes(kPairs, scale);
      Placement at{2.0 * scale * draw(), turn_by(3.0 * draw())};
      planes.restart({at.position + scale * draw_size(6.0) * draw(), turn_by(draw_size(4.0) * draw()) * at.orientation});
      double turned_rad = 7.0;
      const double step = draw_size(5.0);
      Pairs pairs;
      for (int k = 0; k < 12; ++k) {
        const RigidMotion motion{at, scale * step * draw(), step * draw()};
        planes.begin(LinearizedMotion(motion), turned_rad);
        if (k == 0 || k == 6) {
          pairs = draw_pairs(at, scale);
          put_planes(planes, pairs, at);
        }
        for (std::size_t i = 0; i < kPairs; ++i) {
          const SeparatingPlanes::Gaps gaps = planes.find_gaps(i / SeparatingPlanes::kTogether);
          const BoxInScene scene(pairs.scene[i], {});
          const double start = find_distance(BoxInScene(pairs.tool[i], at), scene);
          ASSERT_LE(gap_of(gaps.start, i), start) << "scale " << scale << ", case " << n << ", walk " << k << ", pair " << i;
          positive_gaps += gap_of(gaps.start, i) > 0.0F && k % 6 != 0 ? 1 : 0;
          for (const double time : {0.0, 0.3, 0.5, 0.8, 1.0}) {
            const double distance = find_distance(BoxInScene(pairs.tool[i], motion.at(time)), scene);
            ASSERT_LE(gap_of(gaps.over, i), distance) << "scale " << scale << ", case " << n << ", walk " << k << ", pair " << i;
          }
        }
        const double share = 0.5 + 0.5 * uniform(random);
        const Placement next = motion.at(share);
        turned_rad = turn_between(at.orientation, next.orientation).norm() + 0x1p-45;
        at = next;
      }
    }
  }
  EXPECT_GT(positive_gaps, 5000);
}

// A small box far from the grip point moves on an arc; in the middle of the arc it is nearer to the scene's box than at both ends.
TEST_F(SeparatingPlanesTest, TheGapOfATurnIsNoLargerThanTheDistanceInItsMiddle) {
  for (const double angle : {0.01, 0.1, 0.5}) {
    SCOPED_TRACE(angle);
    SeparatingPlanes planes(kPairs, 1.001);
    const RigidMotion motion{{Vec3::Zero(), turn_by(-0.5 * angle * Vec3::UnitZ())}, Vec3::Zero(), angle * Vec3::UnitZ()};
    planes.restart(motion.from);
    planes.begin(LinearizedMotion(motion), 0.0);
    Node tool = draw_box(Vec3::UnitX(), 0.0);
    for (float& half : tool.half) half = 1e-6F;
    const double sagitta = 1.0 - std::cos(0.5 * angle);
    const Node scene = draw_box((1.2 + 2.0 * sagitta) * Vec3::UnitX(), 0.1);
    put_plane_along(planes, 0, -Vec3::UnitX(), tool, scene);
    const SeparatingPlanes::Gaps gaps = planes.find_gaps(0);
    const double middle = -BoxInScene(scene, {}).highest(-Vec3::UnitX()) - BoxInScene(tool, motion.at(0.5)).highest(Vec3::UnitX());
    EXPECT_LE(gap_of(gaps.over, 0), middle);
    EXPECT_GT(gap_of(gaps.over, 0), 0.0F);
    EXPECT_GT(gap_of(gaps.start, 0), gap_of(gaps.over, 0) + static_cast<float>(0.9 * sagitta)) << "the arc is too flat to matter";
  }
}

// For planes between the closest points, gaps are not much less than the distances, at the start of a small motion and over it.
TEST_F(SeparatingPlanesTest, AGapIsTheDistanceAlongTheNormal) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  int compared_gaps = 0;
  for (int n = 0; n < 50; ++n) {
    SeparatingPlanes planes(kPairs, 1.0);
    const Placement at{draw(), turn_by(3.0 * draw())};
    planes.restart(at);
    planes.begin(LinearizedMotion(RigidMotion{at}), 0.0);
    const Pairs pairs = draw_pairs(at, 1.0);
    const std::vector<bool> has_plane = put_planes(planes, pairs, at);
    // The start differs from `at`, and the motion goes on: by a shift of about 1e-2 and a turn of about 1e-3 at most in total.
    const RigidMotion motion{{at.position + 0.005 * draw(), turn_by(0.0005 * draw()) * at.orientation}, 0.005 * draw(), 0.0005 * draw()};
    planes.begin(LinearizedMotion(motion), turn_between(at.orientation, motion.from.orientation).norm());
    for (std::size_t i = 0; i < kPairs; ++i) {
      if (!has_plane[i]) continue;
      const BoxInScene scene(pairs.scene[i], {});
      const double start = find_distance(BoxInScene(pairs.tool[i], motion.from), scene);
      const double size = pairs.tool[i].half_size().norm() + pairs.scene[i].half_size().norm();
      if (start < 0.5 * size || start < 0.02) continue;
      const SeparatingPlanes::Gaps gaps = planes.find_gaps(i / SeparatingPlanes::kTogether);
      ++compared_gaps;
      EXPECT_GT(gap_of(gaps.start, i), 0.5 * start);
      EXPECT_GT(gap_of(gaps.over, i), gap_of(gaps.start, i) - 1.1 * motion.length(0.9) - 1e-5);
    }
  }
  EXPECT_GT(compared_gaps, 100);
}

TEST_F(SeparatingPlanesTest, APlaneThatIsClearedGivesNoGap) {
  SeparatingPlanes planes(kPairs, 1.0);
  const Placement at;
  planes.restart(at);
  planes.begin(LinearizedMotion(RigidMotion{at}), 0.0);
  const Node tool = draw_box({0.0, 0.0, 1.0}, 0.1);
  const Node scene = draw_box({0.0, 0.0, 0.0}, 0.1);
  EXPECT_LT(gap_of(planes.find_gaps(1).start, 9), -1e30F);
  put_plane_along(planes, 9, Vec3::UnitZ(), tool, scene);
  EXPECT_GT(gap_of(planes.find_gaps(1).start, 9), 0.6F);
  EXPECT_GT(gap_of(planes.find_gaps(1).over, 9), 0.6F);
  EXPECT_LT(gap_of(planes.find_gaps(1).start, 8), -1e30F);
  planes.clear(9);
  EXPECT_LT(gap_of(planes.find_gaps(1).over, 9), -1e30F);
}

}  // namespace
}  // namespace hapton
