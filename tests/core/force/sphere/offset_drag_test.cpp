#include "core/force/sphere/offset_drag.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <random>

#include "core/force/sliding_friction.h"

namespace hapton {
namespace {

constexpr double kDragOffset = 0.1;
constexpr FrictionCoefficients kRough{.static_mu = 0.5, .dynamic_mu = 0.3};
const ContactTriangle kFlat(Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(0, 2, 0));
const ContactTriangle kUpright(Vec3(-1, 0.2, -1), Vec3(1, 0.2, -1), Vec3(0, 0.2, 2));

// The drag on a single contact.
struct SingleContactDrag {
  explicit SingleContactDrag(const OffsetContact& of, const FrictionCoefficients& friction = kRough)
      : contacts{of}, coefficients{friction}, drag(contacts, coefficients, kDragOffset) {}
  std::array<OffsetContact, 1> contacts;
  std::array<FrictionCoefficients, 1> coefficients;
  OffsetDrag drag;
};

// Finds the centre at which the pull of a device is on the cone, going from the foot back along `direction`.
Vec3 find_centre_on_cone(const OffsetDrag& drag, const Vec3& foot, const Vec3& direction, const Vec3& device) {
  Vec3 c = foot;
  OffsetDrag::Pull pull;
  for (double off = 0.0, step = 0.02; step > 1e-17 && off < kDragOffset;) {
    Vec3 there = foot - (off + step) * direction;
    EXPECT_TRUE(drag.restore(there) && drag.find_pull(there, device, pull));
    if (pull.excess() <= 0.0) {
      off += step;
      c = there;
    } else {
      step *= 0.5;
    }
  }
  return c;
}

// Quasi-static friction in small steps: the device moves a little; then the centre moves along the pull by the excess over the cone,
// and back to the offset, until no excess is left. Of first order in the step; results with two numbers of steps together are of second.
Vec3 drag_in_small_steps(const OffsetDrag& drag, const Vec3& from, const Vec3& to, Vec3 c, int steps) {
  for (int i = 1; i <= steps; ++i) {
    const Vec3 device = from + (static_cast<double>(i) / steps) * (to - from);
    for (int round = 0; round < 60; ++round) {
      OffsetDrag::Pull pull;
      EXPECT_TRUE(drag.find_pull(c, device, pull));
      if (!(pull.excess() > 1e-16)) break;
      c += pull.excess() / drag.find_stability(pull) * pull.tangential / pull.length;
      EXPECT_TRUE(drag.restore(c));
    }
  }
  return c;
}

Vec3 drag_in_small_steps_to_second_order(const OffsetDrag& drag, const Vec3& from, const Vec3& to, const Vec3& c, int steps) {
  return 2.0 * drag_in_small_steps(drag, from, to, c, 2 * steps) - drag_in_small_steps(drag, from, to, c, steps);
}

TEST(OffsetDrag, OverAFaceItIsTheTractrix) {
  const SingleContactDrag single(OffsetContact::on_face(0, kFlat, Vec3::UnitZ()));
  const Vec3 from(0.1, 0.05, -0.1);
  const Vec3 to(0.16, 0.1, -0.15);
  const Vec3 start_pull = 0.3 * 0.2 * Vec3(0.8, -0.6, 0.0);
  const FrictionDrag expected = drag_by_friction({.pull = start_pull,
                                                  .motion = Vec3(0.06, 0.05, 0.0),
                                                  .pressure_start = 0.2,
                                                  .pressure_end = 0.25,
                                                  .friction_static = 0.3,
                                                  .friction_dynamic = 0.3,
                                                  .sliding = true});
  Vec3 c = Vec3(0.1, 0.05, kDragOffset) - start_pull;
  int tests = 0;
  OffsetDrag::Pull pull;
  ASSERT_TRUE(single.drag.find_pull(c, from, pull));
  EXPECT_NEAR(pull.depth, 0.2, 1e-15);
  EXPECT_NEAR(pull.excess(), 0.0, 1e-15);
  EXPECT_DOUBLE_EQ(single.drag.find_stability(pull), 1.0);
  // The motion along the pull, less the growth of the cone.
  EXPECT_NEAR(single.drag.find_excess_rate(pull, to - from), (0.06 * 0.8 - 0.05 * 0.6) - 0.3 * 0.05, 1e-15);
  ASSERT_TRUE(single.drag.follow(from, to, c, tests));
  EXPECT_LT((Vec3(to.x(), to.y(), kDragOffset) - c - expected.pull).norm(), 1e-14);
}

class RoundAnEdgeOrVertex : public testing::TestWithParam<std::uint64_t> {};

TEST_P(RoundAnEdgeOrVertex, ItIsTheLimitOfSmallSteps) {
  SCOPED_TRACE(testing::Message() << "seed " << GetParam());
  std::mt19937_64 random(GetParam());
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto vector = [&] {
    const double x = unit(random);
    const double y = unit(random);
    return Vec3(x, y, unit(random));
  };
  int followed_cases = 0;
  for (const bool is_edge : {true, false}) {
    for (const double mu : {0.05, 0.2, 0.4}) {
      const SingleContactDrag single(is_edge ? OffsetContact::on_edge(0, kFlat, 0) : OffsetContact::on_vertex(0, kFlat, 0), {mu, mu});
      const Vec3 out = Vec3(is_edge ? 0.0 : 0.2 * unit(random), -1.0, 1.0).normalized();
      const Vec3 origin(is_edge ? 0.1 : -1.0, -1.0, 0.0);
      // The depth is small enough for the place on the cone to be stable.
      const Vec3 from = origin + 0.06 * out;
      const Vec3 to = from + 0.006 * vector();
      Vec3 foot = origin + kDragOffset * out;
      ASSERT_TRUE(single.drag.restore(foot));
      Vec3 c = find_centre_on_cone(single.drag, foot, (to - from - out * out.dot(to - from) + 0.002 * vector()).normalized(), from);
      const Vec3 expected = drag_in_small_steps_to_second_order(single.drag, from, to, c, 2000);
      OffsetDrag::Flow at{.centre = c};
      int tests = 0;
      // Follows the flow to the end of the device's motion.
      OffsetDrag::Pull pull;
      ASSERT_TRUE(single.drag.find_pull(c, from, pull));
      if (!(single.drag.find_excess_rate(pull, to - from) > 0.0)) continue;
      ++followed_cases;
      for (int i = 0; i < 20; ++i) {
        ASSERT_TRUE(single.drag.find_pull(at.centre, from + at.time * (to - from), pull));
        const OffsetDrag::Flow before{.centre = at.centre, .time = at.time};
        double length = (1.0 - at.time) / single.drag.find_stability(pull);
        // Where the whole length takes too many steps, a part of it is followed.
        while (!single.drag.flow(from, to, length, at, tests)) {
          ASSERT_GT(at.followed, 0.0);
          length = 0.75 * at.followed;
          at = before;
        }
      }
      ASSERT_NEAR(at.time, 1.0, 1e-15);
      ASSERT_TRUE(single.drag.find_pull(at.centre, to, pull));
      EXPECT_LE(std::fabs(pull.excess()), 1e-14);
      EXPECT_LT((at.centre - expected).norm(), 2e-9) << "edge " << is_edge << " mu " << mu;
      EXPECT_GT(tests, 0);
    }
  }
  EXPECT_GT(followed_cases, 0);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RoundAnEdgeOrVertex, testing::Values(1, 2, 3, 4, 5, 6));

// The device is so near to the edge or vertex that the cone hardly depends on the position of the centre. The flow is on the
// cone there as well: it corrects the time.
TEST(OffsetDrag, TheFlowStaysOnTheConeWhereThatHardlyDependsOnThePosition) {
  for (const bool is_edge : {true, false}) {
    const SingleContactDrag single(is_edge ? OffsetContact::on_edge(0, kFlat, 0) : OffsetContact::on_vertex(0, kFlat, 0));
    const Vec3 origin(is_edge ? 0.1 : -1.0, -1.0, 0.0);
    const Vec3 out = Vec3(0.0, -1.0, 1.0).normalized();
    const Vec3 along = Vec3(0.0, -1.0, -1.0).normalized();
    const double mu = kRough.dynamic_mu;
    const double depth = 1.05 * kDragOffset / (1.0 + mu * mu);
    Vec3 start = origin + kDragOffset * out;
    ASSERT_TRUE(single.drag.restore(start));
    const Vec3 from = start + depth * (mu * along - out);
    const Vec3 to = from + 0.1 * (along - 0.2 * out) + Vec3(0.05, 0.0, 0.0);
    OffsetDrag::Pull pull;
    ASSERT_TRUE(single.drag.find_pull(start, from, pull));
    ASSERT_NEAR(single.drag.find_stability(pull), -0.05, 1e-12);
    for (const double length : {0.1, 0.2, 0.3, 0.4, 0.5}) {
      OffsetDrag::Flow at{.centre = start};
      int tests = 0;
      ASSERT_TRUE(single.drag.flow(from, to, length, at, tests));
      ASSERT_TRUE(single.drag.find_pull(at.centre, from + at.time * (to - from), pull));
      EXPECT_LT(std::fabs(single.drag.find_stability(pull)), 0.125);
      EXPECT_LE(std::fabs(pull.excess()), 0x1p-49) << "edge " << is_edge << ", length " << length;
      EXPECT_NEAR(single.contacts[0].proximity(at.centre).distance, kDragOffset, 0x1p-49);
    }
  }
}

// On the line where two offset planes meet, the centre is mu times the depth behind the device's projection.
TEST(OffsetDrag, AlongTheCurveOfTwoContactsThePullIsOnTheCone) {
  const std::array<OffsetContact, 2> contacts{OffsetContact::on_face(0, kFlat, Vec3::UnitZ()),
                                              OffsetContact::on_face(1, kUpright, -Vec3::UnitY())};
  const std::array<FrictionCoefficients, 2> friction{kRough, kRough};
  const OffsetDrag drag(contacts, friction, kDragOffset);
  EXPECT_TRUE(drag.is_flat());
  const Vec3 from(0.0, 0.14, -0.03);
  const Vec3 to(0.05, 0.2, -0.05);
  const double lag_at_start = 0.3 * std::hypot(0.04, 0.13);
  const double lag_at_end = 0.3 * std::hypot(0.1, 0.15);
  Vec3 c(-lag_at_start, 0.1, kDragOffset);
  int tests = 0;
  OffsetDrag::Pull pull;
  ASSERT_TRUE(drag.find_pull(c, from, pull));
  EXPECT_NEAR(pull.multiplier[0], 0.13, 1e-14);
  EXPECT_NEAR(pull.multiplier[1], 0.04, 1e-14);
  EXPECT_NEAR(pull.excess(), 0.0, 1e-14);
  ASSERT_TRUE(drag.follow(from, to, c, tests));
  EXPECT_LT((c - Vec3(0.05 - lag_at_end, 0.1, kDragOffset)).norm(), 1e-14);
}

// The coefficients are means, weighted by the multipliers, as those of the material are.
TEST(OffsetDrag, TwoMaterialsShareACone) {
  const std::array<OffsetContact, 2> contacts{OffsetContact::on_face(0, kFlat, Vec3::UnitZ()),
                                              OffsetContact::on_face(1, kUpright, -Vec3::UnitY())};
  const std::array<FrictionCoefficients, 2> friction{FrictionCoefficients{0.4, 0.2}, FrictionCoefficients{0.8, 0.6}};
  const OffsetDrag drag(contacts, friction, kDragOffset);
  OffsetDrag::Pull pull;
  ASSERT_TRUE(drag.find_pull(Vec3(0.0, 0.1, kDragOffset), Vec3(0.02, 0.2, -0.2), pull));  // multipliers 0.3 and 0.1
  EXPECT_NEAR(pull.friction.static_mu, 0.5, 1e-14);
  EXPECT_NEAR(pull.friction.dynamic_mu, 0.3, 1e-14);
}

// Round an edge or a vertex, the device at rest: the path begins with unit slope along the pull, stays along it, and at the offset.
class DescentAroundAnEdgeOrVertex : public testing::TestWithParam<std::uint64_t> {};

TEST_P(DescentAroundAnEdgeOrVertex, FollowsThePullEverywhere) {
  SCOPED_TRACE(testing::Message() << "seed " << GetParam());
  std::mt19937_64 random(GetParam());
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto vector = [&] {
    const double x = unit(random);
    const double y = unit(random);
    return Vec3(x, y, unit(random));
  };
  int compared_lengths = 0;
  for (int i = 0; i < 200; ++i) {
    const bool is_edge = i % 2 == 0;
    const SingleContactDrag single(is_edge ? OffsetContact::on_edge(0, kFlat, 0) : OffsetContact::on_vertex(0, kFlat, 0));
    const Vec3 origin(is_edge ? 0.1 : -1.0, -1.0, 0.0);
    Vec3 start = origin + vector().normalized() * kDragOffset;
    ASSERT_TRUE(single.drag.restore(start));
    const double reach = i % 3 == 0 ? 1e-3 : 0.9;  // near the axis, and up to the surface
    const Vec3 device =
        origin + reach * kDragOffset * vector() + (is_edge && i % 5 == 0 ? Vec3(0.3 * unit(random), 0.0, 0.0) : Vec3(0.0, 0.0, 0.0));
    OffsetDrag::Pull pull;
    ASSERT_TRUE(single.drag.find_pull(start, device, pull));
    if (!(pull.length > 1e-6)) continue;
    const Vec3 along = pull.tangential / pull.length;
    int tests = 0;
    const auto descend_by = [&](double length) {
      OffsetDrag::Descent at{.centre = start};
      EXPECT_TRUE(single.drag.descend(device, along, length, at, tests));
      return at;
    };
    constexpr double kStep = 1e-7;
    EXPECT_LT((descend_by(1e-9).centre - start - 1e-9 * along).norm(), 1e-13);
    for (const double length : {0.001, 0.004, 0.0125, 0.03}) {
      const OffsetDrag::Descent at = descend_by(length);
      EXPECT_NEAR(single.contacts[0].proximity(at.centre).distance, kDragOffset, 1e-15);
      ASSERT_TRUE(single.drag.find_pull(at.centre, device, pull));
      if (!(pull.length > 1e-3)) continue;  // at the end of the line
      const Vec3 direction = pull.tangential / pull.length;
      EXPECT_GT(at.slope.dot(direction), 0.0);
      EXPECT_LT((at.slope - at.slope.dot(direction) * direction).norm(), 1e-9 * at.slope.norm()) << i << ' ' << length;
      const Vec3 measured = (descend_by(length + kStep).centre - descend_by(length - kStep).centre) / (2.0 * kStep);
      EXPECT_LT((measured - at.slope).norm(), 1e-6 * at.slope.squaredNorm()) << i << ' ' << length;
      ++compared_lengths;
    }
  }
  EXPECT_GT(compared_lengths, 200);
}

// A descent that is longer than the line ends at the place nearest to the device.
TEST_P(DescentAroundAnEdgeOrVertex, EndsNearestToTheDevice) {
  SCOPED_TRACE(testing::Message() << "seed " << GetParam());
  std::mt19937_64 random(GetParam());
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const bool is_edge : {true, false}) {
    const SingleContactDrag single(is_edge ? OffsetContact::on_edge(0, kFlat, 0) : OffsetContact::on_vertex(0, kFlat, 0));
    const Vec3 origin(is_edge ? 0.1 : -1.0, -1.0, 0.0);
    Vec3 start = origin + kDragOffset * Vec3(is_edge ? 0.0 : 0.1 * unit(random), -0.5, 1.0).normalized();
    ASSERT_TRUE(single.drag.restore(start));
    const Vec3 device = origin + 0.5 * kDragOffset * Vec3(0.0, unit(random), 1.0);
    OffsetDrag::Pull pull;
    ASSERT_TRUE(single.drag.find_pull(start, device, pull));
    int tests = 0;
    OffsetDrag::Descent at{.centre = start};
    ASSERT_TRUE(single.drag.descend(device, pull.tangential / pull.length, 0.25, at, tests));
    const Vec3 off = device - origin;
    EXPECT_LT((at.centre - origin - kDragOffset * off.normalized()).norm(), 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, DescentAroundAnEdgeOrVertex, testing::Values(1, 2, 3, 4));

TEST(OffsetDrag, ADeviceComesOutOnTheSideOfTheCentre) {
  const SingleContactDrag single(OffsetContact::on_edge(0, kFlat, 0));
  const Vec3 c(0.0, -1.0, kDragOffset);
  OffsetDrag::Pull pull;
  const Vec3 from(0.0, -1.0, 0.05);
  ASSERT_TRUE(single.drag.find_pull(c, from, pull));
  EXPECT_NEAR(single.drag.time_of_release(from, {0.1, -1.0, 0.15}, pull), 0.5, 1e-15);
  EXPECT_GT(single.drag.time_of_release(from, {0.1, -1.0, 0.09}, pull), 1.0);
  EXPECT_GT(single.drag.time_of_release(from, {0.1, -1.0, -0.2}, pull), 1.0) << "out on the other side";
  const Vec3 beyond(0.0, -1.0, -0.15);
  ASSERT_TRUE(single.drag.find_pull(c, beyond, pull));
  EXPECT_GT(single.drag.time_of_release(beyond, {0.0, -1.0, -0.3}, pull), 1.0);
  EXPECT_NEAR(single.drag.time_of_release(beyond, {0.0, -1.0, 0.15}, pull), 0.25 / 0.3, 1e-14);
}

}  // namespace
}  // namespace hapton
