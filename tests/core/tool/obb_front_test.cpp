#include "core/tool/obb_front.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <random>
#include <set>
#include <vector>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/thread_team.h"
#include "tests/support/triangle_gap.h"

namespace hapton {
namespace {

using Corners3 = std::array<Vec3, 3>;

class ObbFrontTest : public testing::Test {
 protected:
  static constexpr unsigned kSeed = 23;
  std::mt19937_64 random{kSeed};
  std::uniform_real_distribution<double> uniform{-1.0, 1.0};
  const TriangleMesh ball = make_bumpy_sphere(0.3, 0.2, 300, 3);
  const TriangleMesh slab = scaled_and_moved(make_box({0.4, 0.2, 0.3}, 3), 1.0, {0.5, 0.0, 0.0});
  const TouchGeometry scene{std::vector<const TriangleMesh*>{&ball, &slab}};
  const ObjectGeometry tool{make_box({0.1, 0.2, 0.15}, 3), {Vec3::Zero(), scene.unit_m()}};
  const ObbTree tool_tree{tool};
  const ObbTree scene_tree{scene};
  const double radius = 0.5 * Vec3(0.1, 0.2, 0.15).norm() / scene.unit_m() * 1.001;
  ObbFront front{tool_tree, scene_tree, radius};
  std::vector<std::uint32_t> scene_ids;

  void SetUp() override {
    for (const ObbTree::Node& node : scene_tree.nodes()) {
      if (node.is_leaf()) scene_ids.push_back(scene_tree.triangle(node));
    }
  }
  Vec3 random_vector() { return {uniform(random), uniform(random), uniform(random)}; }
  Corners3 tool_at(std::uint32_t t, const Placement& at) const {
    return {at.at(tool.corner(t, 0)), at.at(tool.corner(t, 1)), at.at(tool.corner(t, 2))};
  }
  Corners3 scene_at(std::uint32_t id) const { return {scene.corner(id, 0), scene.corner(id, 1), scene.corner(id, 2)}; }
  // The smallest distance at nine times of the motion.
  double distance_over(const RigidMotion& motion, std::uint32_t t, std::uint32_t id) const {
    double least = 1e300;
    for (double time = 0.0; time <= 1.0; time += 0.125) least = std::min(least, triangle_gap(tool_at(t, motion.at(time)), scene_at(id)));
    return least;
  }
};

// Most walks begin at the front of earlier walks. The motions have very different lengths, and a walk may leave out pairs that an earlier
// visit found to be far apart.
TEST_F(ObbFrontTest, VisitsEveryPairThatABruteForceSearchFinds) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::size_t near_pair_count = 0;
  std::size_t visit_count = 0;
  Placement at;
  for (int n = 0; n < 60; ++n) {
    if (n % 15 == 0) at = {random_vector().normalized() * (n % 2 == 0 ? 0.45 : 0.9), turn_by(3.0 * random_vector())};
    const double length = std::pow(10.0, -1.0 - 2.0 * std::abs(uniform(random)));
    const bool is_still = n % 3 == 0;
    const RigidMotion motion{at, is_still ? Vec3::Zero() : Vec3(length * random_vector()),
                             is_still ? Vec3::Zero() : Vec3(length * random_vector())};
    const double distance = 0.03 * std::abs(uniform(random));
    std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
    ASSERT_TRUE(
        front.for_each_near(LinearizedMotion(motion), distance, [&](ObbFront::VisitId, std::uint32_t t, std::uint32_t id, std::uint16_t) {
          pairs.insert({t, id});
          const double gap = triangle_gap(tool_at(t, at), scene_at(id)) * 0.999;
          return ObbFront::Visited{gap, gap, true};
        }));
    visit_count += pairs.size();
    for (std::uint32_t t = 0; t < tool.triangle_count(); ++t) {
      for (const std::uint32_t id : scene_ids) {
        if (pairs.count({t, id}) > 0) continue;
        if (triangle_gap(tool_at(t, at), scene_at(id)) > distance + motion.length(radius)) continue;
        ASSERT_GT(distance_over(motion, t, id), distance) << "case " << n;
      }
    }
    for (const auto& [t, id] : pairs) near_pair_count += distance_over(motion, t, id) <= distance ? 1U : 0U;
    at = motion.at(0.3 + 0.3 * uniform(random));
  }
  EXPECT_GT(near_pair_count, 1000U);
  EXPECT_LT(visit_count, 6 * near_pair_count) << "the walks visit far more pairs than are near";
}

// The visitor returns an infinite distance for pairs that do not matter to it. This must not become the bound of pairs beside them.
// Between two walks that begin at some pairs, there is a walk that begins at none.
TEST_F(ObbFrontTest, PairsThatDoNotMatterHideNoOthers) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto matters = [](std::uint32_t t, std::uint32_t id) { return (t + id) % 5 == 0; };
  std::size_t near_pair_count = 0;
  for (int n = 0; n < 30; ++n) {
    const Placement at{random_vector().normalized() * 0.6, turn_by(3.0 * random_vector())};
    const auto walk = [&](const RigidMotion& motion, double distance) {
      std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
      EXPECT_TRUE(
          front.for_each_near(LinearizedMotion(motion), distance, [&](ObbFront::VisitId, std::uint32_t t, std::uint32_t id, std::uint16_t) {
            pairs.insert({t, id});
            const double gap = matters(t, id) ? triangle_gap(tool_at(t, at), scene_at(id)) * 0.999 : kInfinity;
            return ObbFront::Visited{gap, gap, true};
          }));
      return pairs;
    };
    front.restart();
    const RigidMotion still{at};
    walk(still, 0.3);
    walk(still, 0.0);
    walk(still, 0.0);
    const auto pairs = walk(still, 0.3);
    for (std::uint32_t t = 0; t < tool.triangle_count(); ++t) {
      for (const std::uint32_t id : scene_ids) {
        if (!matters(t, id) || triangle_gap(tool_at(t, at), scene_at(id)) > 0.299) continue;
        ++near_pair_count;
        ASSERT_EQ(pairs.count({t, id}), 1U) << "case " << n;
      }
    }
  }
  EXPECT_GT(near_pair_count, 1000U);
}

// Hundreds of short motions, mostly along the surface, so that bounds from many placements ago decide which pairs a walk visits.
TEST_F(ObbFrontTest, ALongSlideLosesNoPair) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::size_t visit_count = 0;
  for (int slide = 0; slide < 6; ++slide) {
    Placement at{random_vector().normalized() * (0.40 / scene.unit_m()), turn_by(3.0 * random_vector())};
    const double step = std::pow(10.0, -2.0 - 0.4 * slide);
    const Vec3 turn = step / radius * 0.5 * random_vector();
    const Vec3 along_surface = at.position.cross(random_vector()).normalized();
    for (int n = 0; n < 150; ++n) {
      const Vec3 shift = step * (along_surface + 0.3 * random_vector());
      const RigidMotion motion{at, n % 2 == 0 ? Vec3::Zero() : shift, n % 2 == 0 ? Vec3::Zero() : turn};
      const double distance = 0.3 * step * std::abs(uniform(random));
      std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
      ASSERT_TRUE(
          front.for_each_near(LinearizedMotion(motion), distance, [&](ObbFront::VisitId, std::uint32_t t, std::uint32_t id, std::uint16_t) {
            pairs.insert({t, id});
            const double gap = triangle_gap(tool_at(t, at), scene_at(id)) * 0.999;
            return ObbFront::Visited{gap, gap, true};
          }));
      visit_count += pairs.size();
      for (std::uint32_t t = 0; t < tool.triangle_count() && n % 15 == 14; ++t) {
        for (const std::uint32_t id : scene_ids) {
          if (pairs.count({t, id}) > 0) continue;
          if (triangle_gap(tool_at(t, at), scene_at(id)) > distance + motion.length(radius)) continue;
          ASSERT_GT(distance_over(motion, t, id), distance) << "slide " << slide << ", walk " << n;
        }
      }
      at = motion.at(uniform(random));
    }
  }
  EXPECT_GT(visit_count, 1000U);
}

TEST_F(ObbFrontTest, AWalkThatIsEndedIsMadeAgainInFull) {
  const RigidMotion motion{{Vec3(0.0, 0.0, 0.4), Quat::Identity()}, Vec3::Zero(), Vec3::Zero()};
  const auto walk = [&](std::size_t max_visits) {
    std::size_t visits = 0;
    const bool is_complete =
        front.for_each_near(LinearizedMotion(motion), 0.2, [&](ObbFront::VisitId, std::uint32_t, std::uint32_t, std::uint16_t) {
          return ObbFront::Visited{0.0, 0.0, ++visits != max_visits};
        });
    EXPECT_EQ(is_complete, visits < max_visits);
    return visits;
  };
  const std::size_t all_visits = walk(~std::size_t{0});
  ASSERT_GT(all_visits, 10U);
  EXPECT_EQ(walk(5), 5U);
  const std::size_t visits_again = walk(~std::size_t{0});
  EXPECT_EQ(visits_again, all_visits);
}

// A walk leaves out pairs whose features the visitor has found before, until forget() is called.
TEST_F(ObbFrontTest, APairThatIsKnownIsVisitedAgainWhenItIsForgotten) {
  const RigidMotion motion{{Vec3(0.0, 0.0, 0.4), Quat::Identity()}, Vec3::Zero(), Vec3::Zero()};
  const auto walk = [&] {
    std::size_t visits = 0;
    EXPECT_TRUE(front.for_each_near(LinearizedMotion(motion), 0.2, [&](ObbFront::VisitId, std::uint32_t, std::uint32_t, std::uint16_t) {
      ++visits;
      return ObbFront::Visited{0.0, 1.0, true};
    }));
    return visits;
  };
  const std::size_t all_visits = walk();
  ASSERT_GT(all_visits, 10U);
  EXPECT_EQ(walk(), 0U);
  front.forget();
  const std::size_t visits_again = walk();  // less than all: some pairs were found to be too far away
  EXPECT_GT(visits_again, all_visits / 2);
  EXPECT_LE(visits_again, all_visits);
}

// Any number of workers visits the same pairs at the same places (ObbFront::VisitId), also after walks that a visitor has ended.
TEST_F(ObbFrontTest, WorkersFindTogetherWhatOneFindsAlone) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  using Visits = std::vector<std::array<std::uint32_t, 3>>;
  const auto walk = [&](ObbFront& shared, const RigidMotion& motion, double distance, std::size_t max_visits, int workers) {
    std::vector<Visits> by_worker(static_cast<std::size_t>(workers));
    std::atomic<std::size_t> count = 0;
    const bool is_complete = shared.for_each_near(LinearizedMotion(motion), distance,
                                                  [&](ObbFront::VisitId visit, std::uint32_t t, std::uint32_t id, std::uint16_t) {
                                                    by_worker[static_cast<std::size_t>(visit.worker)].push_back({visit.place, t, id});
                                                    const double gap = triangle_gap(tool_at(t, motion.from), scene_at(id)) * 0.999;
                                                    return ObbFront::Visited{gap, gap, ++count <= max_visits};
                                                  });
    Visits all;
    for (const Visits& visits : by_worker) {
      EXPECT_TRUE(std::is_sorted(visits.begin(), visits.end(), [](const auto& a, const auto& b) { return a[0] < b[0]; }));
      all.insert(all.end(), visits.begin(), visits.end());
    }
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a[0] < b[0]; });
    return is_complete ? all : Visits();
  };
  for (const int workers : {2, 3, 8}) {
    made::ThreadTeam team(workers);
    ObbFront front_of_team(tool_tree, scene_tree, radius, team);
    ObbFront front_of_one(tool_tree, scene_tree, radius);
    std::size_t visit_count = 0;
    Placement at;
    for (int n = 0; n < 60; ++n) {
      if (n % 15 == 0) at = {random_vector().normalized() * 0.45, turn_by(3.0 * random_vector())};
      const RigidMotion motion{at, Vec3(0.02 * random_vector()), Vec3(0.02 * random_vector())};
      const std::size_t max_visits = n % 10 == 7 ? 20 : ~std::size_t{0};
      const double distance = 0.1 * std::abs(uniform(random));
      const Visits expected = walk(front_of_one, motion, distance, max_visits, 1);
      ASSERT_EQ(walk(front_of_team, motion, distance, max_visits, workers), expected) << workers << " workers, walk " << n;
      visit_count += expected.size();
      at = motion.at(1.0);
    }
    EXPECT_GT(visit_count, 1000U);
  }
}

// In a fast motion along a surface, most boxes of the tool stay separate from those of the surface.
TEST_F(ObbFrontTest, SlidingAlongAPlaneVisitsWhatIsNearIt) {
  const TriangleMesh grid = make_plane_grid(1.0, 40);
  const TouchGeometry plane(std::vector<const TriangleMesh*>{&grid});
  const ObjectGeometry box(make_box({0.1, 0.1, 0.1}, 2), {Vec3::Zero(), plane.unit_m()});
  const ObbTree box_tree(box);
  const ObbTree plane_tree(plane);
  ObbFront sliding(box_tree, plane_tree, 0.1 / plane.unit_m());
  const Placement above{plane.to_local({0.0, 0.0, 0.06}), Quat::Identity()};
  std::size_t visits = 0;
  const auto count = [&](ObbFront::VisitId, std::uint32_t, std::uint32_t, std::uint16_t) {
    ++visits;
    return ObbFront::Visited{0.0, 0.0, true};
  };
  ASSERT_TRUE(sliding.for_each_near(LinearizedMotion({above, Vec3(0.2, 0.1, 0.0), Vec3::Zero()}), 0x1p-20, count));
  EXPECT_EQ(visits, 0U);
  ASSERT_TRUE(sliding.for_each_near(LinearizedMotion({above, Vec3(0.2, 0.1, -0.02), Vec3::Zero()}), 0x1p-20, count));
  EXPECT_GT(visits, 0U);
}

}  // namespace
}  // namespace hapton
