#include "core/force/common_proxy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr double kExtent = 0.1;  // m
constexpr double kLiftM = CommonProxy::kLift * kExtent;

// The half space normal . p >= height, in the frame of the part.
struct MadeHalfSpace {
  Vec3 normal = Vec3::UnitZ();
  double height = 0.0;
  double stiffness = 1000.0;
  bool resumes = true;
  Pose X_SO = Pose::Identity();

  MadeHalfSpace in_scene() const {
    MadeHalfSpace space = *this;
    space.normal = X_SO.linear() * normal;
    space.height = height + space.normal.dot(X_SO.translation());
    return space;
  }
};

// Half spaces without friction. A step cannot end below the surface that it started from, so feel() needs no state of earlier steps.
class MadeParts final : public FeltParts {
 public:
  explicit MadeParts(std::vector<MadeHalfSpace> made)
      : spaces(std::move(made)), resumed_at(spaces.size()), reset_at(spaces.size()), felt_at(spaces.size()) {}

  Pose pose(std::size_t part) const noexcept override { return spaces[part].X_SO; }
  void reset(std::size_t part, const Pose& /*X_SO*/, const Vec3& p_S) noexcept override { reset_at[part] = p_S; }
  bool resume(std::size_t part, const Pose& /*X_SO*/, const Vec3& p_S) noexcept override {
    resumed_at[part] = p_S;
    ++resumes;
    return spaces[part].resumes;
  }
  MethodOutput feel(std::size_t part, const Pose& /*X_SO*/, const Vec3& p_S, const Turn& turn) noexcept override {
    ++feels;
    felt_at[part] = p_S;
    is_shared = turn.is_shared;
    const MadeHalfSpace space = spaces[part].in_scene();
    const double depth = space.height - space.normal.dot(p_S);
    if (!(depth > 0.0)) return {.force_n = Vec3::Zero(), .p_SP = p_S};
    return {.force_n = space.stiffness * depth * space.normal,
            .p_SP = p_S + depth * space.normal,
            .contact = true,
            .object = static_cast<int>(part)};
  }

  StiffnessRange stiffness(std::size_t part) const noexcept override { return {spaces[part].stiffness, spaces[part].stiffness}; }

  bool is_frictionless(std::size_t) const noexcept override { return are_frictionless; }

  std::vector<MadeHalfSpace> spaces;
  bool are_frictionless = false;
  std::vector<Vec3> resumed_at;  // p_S of the last resume() of each part
  std::vector<Vec3> reset_at;    // p_S of its last reset()
  std::vector<Vec3> felt_at;     // p_S of its last feel()
  int feels = 0;
  int resumes = 0;
  bool is_shared = false;
};

// By enumeration of all sets of up to three planes: the point of all planes of the set nearest to p_SD, if it violates no other plane.
Vec3 project(const std::vector<MadeHalfSpace>& parts, const Vec3& p_SD) {
  std::vector<MadeHalfSpace> spaces;
  for (const MadeHalfSpace& part : parts) spaces.push_back(part.in_scene());
  const int count = static_cast<int>(spaces.size());
  Vec3 best = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  double least = std::numeric_limits<double>::infinity();
  for (int set = 0; set < 1 << count; ++set) {
    Eigen::MatrixXd normals(0, 3);
    Eigen::VectorXd heights(0);
    for (int i = 0; i < count; ++i) {
      if ((set >> i & 1) == 0) continue;
      normals.conservativeResize(normals.rows() + 1, 3);
      heights.conservativeResize(normals.rows());
      normals.bottomRows(1) = spaces[static_cast<std::size_t>(i)].normal.transpose();
      heights[normals.rows() - 1] = spaces[static_cast<std::size_t>(i)].height;
    }
    if (normals.rows() > 3) continue;
    Vec3 p = p_SD;
    if (normals.rows() > 0) p += normals.completeOrthogonalDecomposition().solve(heights - normals * p_SD);
    const bool is_allowed = std::ranges::all_of(spaces, [&](const MadeHalfSpace& s) { return s.normal.dot(p) >= s.height - 1e-12; });
    if (is_allowed && (p - p_SD).norm() < least) {
      least = (p - p_SD).norm();
      best = p;
    }
  }
  return best;
}

// A smooth closed path around a centre: a sum of waves.
struct WavyLoop {
  WavyLoop(std::mt19937_64& random, const Vec3& about, double size) : centre(about) {
    std::normal_distribution<double> normal(0.0, size);
    for (auto& wave : waves)
      wave = {Vec3(normal(random), normal(random), normal(random)), Vec3(normal(random), normal(random), normal(random))};
  }
  Vec3 at(double turn) const {
    Vec3 p = centre;
    for (std::size_t k = 0; k < waves.size(); ++k) {
      const double angle = 2.0 * std::numbers::pi * static_cast<double>(k + 1) * turn;
      p += std::cos(angle) * waves[k].first + std::sin(angle) * waves[k].second;
    }
    return p;
  }

  Vec3 centre;
  std::array<std::pair<Vec3, Vec3>, 2> waves;
};

Mat3 random_rotation(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Quat(normal(random), normal(random), normal(random), normal(random)).normalized().toRotationMatrix();
}

// Follows a loop twice and compares all steps with the projection. bound: largest error, in multiples of kLiftM. Returns the energy that
// the hand receives in the second round, as a share of the largest energy stored.
double follow_loop(MadeParts& parts, const WavyLoop& loop, double bound) {
  CommonProxy proxy(parts.spaces.size(), kExtent);
  const int steps = 1500;
  Vec3 last_p_SD = loop.at(0.0);
  Vec3 last_force = Vec3::Zero();
  double received_j = 0.0;
  double most_stored_j = 0.0;
  int contact_steps = 0;
  for (int i = 0; i <= 2 * steps; ++i) {
    const Vec3 p_SD = loop.at(static_cast<double>(i) / steps);
    const MethodOutput felt = proxy.step(parts, parts.spaces.size(), true, p_SD);
    const Vec3 nearest = project(parts.spaces, p_SD);
    EXPECT_LT((felt.force_n - 1000.0 * (nearest - p_SD)).norm(), 1000.0 * bound * kLiftM + 1e-9) << "step " << i;
    EXPECT_LT((felt.p_SP - nearest).norm(), bound * kLiftM) << "step " << i;
    EXPECT_FALSE(proxy.is_squeezed()) << "step " << i;
    if (testing::Test::HasFailure()) return 0.0;
    if (i > steps) received_j += 0.5 * (last_force + felt.force_n).dot(p_SD - last_p_SD);
    most_stored_j = std::max(most_stored_j, 500.0 * (nearest - p_SD).squaredNorm());
    contact_steps += felt.contact ? 1 : 0;
    last_p_SD = p_SD;
    last_force = felt.force_n;
  }
  EXPECT_GT(contact_steps, steps / 4);
  return received_j / most_stored_j;
}

TEST(CommonProxy, TwoPlanesAtAnyAngleGiveTheNearestPoint) {
  const std::uint64_t seed = 24511;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  for (int degrees = 15; degrees <= 165; degrees += 10) {
    SCOPED_TRACE(testing::Message() << degrees << " degrees of free space");
    const double angle = degrees * std::numbers::pi / 180.0;
    for (int run = 0; run < 4; ++run) {
      const Mat3 turn = random_rotation(random);
      const Vec3 corner = 0.01 * random_rotation(random).col(0);
      const Vec3 a = turn * Vec3(0, 1, 0);
      const Vec3 b = turn * Vec3(std::sin(angle), -std::cos(angle), 0);
      MadeParts parts({{.normal = a, .height = a.dot(corner)}, {.normal = b, .height = b.dot(corner)}});
      const WavyLoop loop(random, corner, 0.003);
      EXPECT_LT(std::fabs(follow_loop(parts, loop, 4.0 / std::sin(angle))), 1e-4);
    }
  }
}

TEST(CommonProxy, ThreePlanesGiveTheNearestPoint) {
  const std::uint64_t seed = 24512;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  int runs = 0;
  while (runs < 40) {
    const Mat3 normals =
        (Mat3() << random_rotation(random).col(0), random_rotation(random).col(0), random_rotation(random).col(0)).finished();
    const double volume = std::fabs(normals.determinant());
    if (volume < 0.2) continue;
    SCOPED_TRACE(testing::Message() << "run " << runs << ": normals\n" << normals);
    const Vec3 corner = 0.01 * random_rotation(random).col(0);
    std::vector<MadeHalfSpace> spaces;
    for (int k = 0; k < 3; ++k) spaces.push_back({.normal = normals.col(k), .height = normals.col(k).dot(corner)});
    MadeParts parts(spaces);
    const WavyLoop loop(random, corner, 0.003);
    EXPECT_LT(std::fabs(follow_loop(parts, loop, 8.0 / volume)), 1e-4);
    if (HasFailure()) return;
    ++runs;
  }
}

// Parts whose frames turn and shift are felt like the same geometry in the scene's frame.
TEST(CommonProxy, EachPartIsInItsOwnFrame) {
  const std::uint64_t seed = 24513;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  MadeParts parts({{.normal = Vec3(0.8, 0, 0.6)}, {.normal = Vec3(-0.6, 0, 0.8)}, {.normal = Vec3(0, 0.6, 0.8)}});
  std::vector<Vec3> axes;
  for (int k = 0; k < 3; ++k) axes.push_back(random_rotation(random).col(0));
  const WavyLoop loop(random, Vec3::Zero(), 0.003);
  CommonProxy proxy(3, kExtent);
  int shared_steps = 0;
  for (int i = 0; i < 5000; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      parts.spaces[k].X_SO.linear() = Eigen::AngleAxisd(0.3 * std::sin(1e-3 * i), axes[k]).toRotationMatrix();
      parts.spaces[k].X_SO.translation() = 0.002 * std::sin(2e-3 * i) * axes[k];
    }
    const Vec3 p_SD = loop.at(0.0004 * i);
    const MethodOutput felt = proxy.step(parts, 3, true, p_SD);
    const Vec3 nearest = project(parts.spaces, p_SD);
    ASSERT_LT((felt.force_n - 1000.0 * (nearest - p_SD)).norm(), 1e-3 * felt.force_n.norm() + 2e4 * kLiftM) << i;
    shared_steps += parts.is_shared ? 1 : 0;
  }
  EXPECT_GT(shared_steps, 500);
}

// The hand jumps into two or three parts at once: the proxy is at the nearest point in that same sample.
TEST(CommonProxy, PartsThatComeIntoContactInOneSampleHaveTheNearestPointInIt) {
  const std::uint64_t seed = 24514;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  for (int run = 0; run < 300; ++run) {
    const std::size_t count = 2 + static_cast<std::size_t>(run % 2);
    const Mat3 normals = random_rotation(random) + 0.3 * random_rotation(random);
    std::vector<MadeHalfSpace> spaces;
    for (std::size_t k = 0; k < count; ++k) spaces.push_back({.normal = normals.col(static_cast<int>(k)).normalized()});
    MadeParts parts(spaces);
    CommonProxy proxy(count, kExtent);
    const Vec3 inside = normals.transpose().inverse() * Vec3::Ones();  // a direction into all half spaces
    const Vec3 above = 0.01 * inside / inside.norm();
    EXPECT_FALSE(proxy.step(parts, count, true, above).contact);
    const Vec3 p_SD = WavyLoop(random, Vec3(-0.3 * above), 0.002).at(0.0);
    const MethodOutput felt = proxy.step(parts, count, true, p_SD);
    ASSERT_LT((felt.p_SP - project(parts.spaces, p_SD)).norm(), 100.0 * kLiftM) << "run " << run << ", " << parts.feels << " feels";
  }
}

// Each part resumes at the position that the proxy had before the sample, in the frame of the part.
TEST(CommonProxy, PartsResumeAtTheProxyBeforeTheSampleWhenASecondPartIsTouched) {
  MadeParts parts({{.normal = Vec3::UnitZ()}, {.normal = Vec3::UnitX(), .height = -0.01}});
  CommonProxy proxy(2, kExtent);
  (void)proxy.step(parts, 2, true, Vec3(0, 0, -0.001));
  EXPECT_EQ(parts.resumes, 0);
  (void)proxy.step(parts, 2, true, Vec3(0.003, 0, -0.001));
  EXPECT_EQ(parts.resumes, 0);
  parts.spaces[1].X_SO.translation() = Vec3(0.02, 0, 0);  // the wall is now at x = 10 mm
  const MethodOutput felt = proxy.step(parts, 2, true, Vec3(0.003, 0, -0.001));
  EXPECT_EQ(parts.resumes, 2);
  EXPECT_LT((parts.resumed_at[0] - Vec3(0.003, 0, 0)).norm(), 2 * kLiftM);
  EXPECT_LT((parts.resumed_at[1] - Vec3(0.023, 0, 0)).norm(), 2 * kLiftM) << "ahead of the wall";
  EXPECT_LT((felt.force_n - Vec3(7, 0, 1)).norm(), 1e-3);
  EXPECT_LT((felt.p_SP - Vec3(0.01, 0, 0)).norm(), 2 * kLiftM);
  parts.resumes = 0;
  (void)proxy.step(parts, 2, true, Vec3(0.0031, 0, -0.001));
  EXPECT_EQ(parts.resumes, 0) << "both parts are already followed";
}

TEST(CommonProxy, APartThatCannotResumeGoesOnFromWhereItIs) {
  for (const bool first_resumes : {false, true}) {
    MadeParts parts({{.normal = Vec3::UnitZ(), .resumes = first_resumes}, {.normal = Vec3(0.6, 0, 0.8), .resumes = !first_resumes}});
    CommonProxy proxy(2, kExtent);
    (void)proxy.step(parts, 2, true, Vec3(0.02, 0, -0.001));
    for (int i = 0; i <= 30; ++i) {
      const Vec3 p_SD(0.02 - 1e-3 * i, 0, -0.001);
      const MethodOutput felt = proxy.step(parts, 2, true, p_SD);
      ASSERT_LT((felt.p_SP - project(parts.spaces, p_SD)).norm(), 20 * kLiftM) << i;
    }
    EXPECT_EQ(parts.resumes, 2);
  }
}

TEST(CommonProxy, ResetPutsAllPartsAtThePointAndForgetsWhatHeldTheProxy) {
  MadeParts parts({{.normal = Vec3::UnitZ()}, {.normal = Vec3::UnitX()}});
  CommonProxy proxy(2, kExtent);
  (void)proxy.step(parts, 2, true, Vec3(-0.001, 0, -0.001));
  proxy.reset(Vec3(0.01, 0.02, 0.03));
  EXPECT_FALSE(proxy.step(parts, 2, true, Vec3(0.01, 0.02, 0.02)).contact);
  for (const Vec3& p_S : parts.reset_at) EXPECT_EQ(p_S, Vec3(0.01, 0.02, 0.03));
  proxy.go_on_from(Vec3(0.01, 0.02, 0.025));
  parts.reset_at[0].setZero();
  EXPECT_FALSE(proxy.step(parts, 2, true, Vec3(0.01, 0.02, 0.02)).contact);
  EXPECT_TRUE(parts.reset_at[0].isZero(0.0)) << "the parts are there already, no reset";
  (void)proxy.step(parts, 2, true, Vec3(0.01, 0.02, -0.001));
  // Another number of parts, in another order.
  std::swap(parts.spaces[0], parts.spaces[1]);
  proxy.go_on_from(Vec3(0.01, 0.02, 0.0));
  EXPECT_LT((proxy.step(parts, 1, false, Vec3(-0.002, 0.02, -0.001)).force_n - Vec3(2, 0, 0)).norm(), 1e-3);
}

// feel() is called at most twelve times for each part, and once more for the part that stands still: six rounds, and a restart for each
// part that comes into contact. Without friction there are twice as many rounds.
TEST(CommonProxy, TheWorkOfAStepIsBounded) {
  const std::uint64_t seed = 24515;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  int most_feels_per_part = 0;
  for (int run = 0; run < 60; ++run) {
    const std::size_t count = 1 + static_cast<std::size_t>(run % 6);
    std::vector<MadeHalfSpace> spaces(count);
    for (MadeHalfSpace& space : spaces) space.normal = random_rotation(random).col(0);
    MadeParts parts(spaces);
    parts.are_frictionless = run % 2 == 0;
    CommonProxy proxy(count, kExtent);
    for (int i = 0; i < 500; ++i) {
      for (MadeHalfSpace& space : parts.spaces) space.X_SO.translation() = 0.002 * random_rotation(random).col(0);
      parts.feels = 0;
      const MethodOutput felt = proxy.step(parts, count, i % 2 == 0, 0.003 * random_rotation(random).col(0));
      ASSERT_TRUE(felt.force_n.allFinite());
      ASSERT_LE(parts.feels, (parts.are_frictionless ? 24 : 12) * static_cast<int>(count) + 1);
      ASSERT_GE(parts.feels, static_cast<int>(count));
      most_feels_per_part = std::max(most_feels_per_part, parts.feels / static_cast<int>(count));
    }
  }
  EXPECT_GE(most_feels_per_part, 6);
}

TEST(CommonProxy, StepsWithoutHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  MadeParts parts({{.normal = Vec3::UnitZ()}, {.normal = Vec3::UnitX()}, {.normal = Vec3(0.6, 0.8, 0)}});
  CommonProxy proxy(3, kExtent);
  const AllocationGuard guard;
  proxy.reset(Vec3::Constant(0.003));
  bool has_been_squeezed = false;
  for (int i = 0; i < 400; ++i) {
    parts.spaces[2].normal = i < 200 ? Vec3(0.6, 0.8, 0) : Vec3(0, 0, -1);
    parts.spaces[2].height = i < 300 ? 0.0 : 0.002;
    (void)proxy.step(parts, 3, true, Vec3::Constant(0.003 * std::cos(0.1 * i)));
    has_been_squeezed |= proxy.is_squeezed();
  }
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_TRUE(has_been_squeezed);
}

// The hand is at a first plane. A second plane comes down onto the hand until no free space is left between the planes, and goes up
// again, three times. The planes face each other, or are at a small angle, so that the nearest point of both half spaces is far away.
struct Squeeze {
  double tilt = 0.0;
  bool has_still = true;
  double stiffness = 1000.0;        // of the first plane
  double other_stiffness = 1000.0;  // of the plane that moves
  double hand_m = 0.0;              // mean height of the hand above the first plane

  struct Worst {
    double jump_n = 0.0;     // largest change of the force in one step
    double stiffness = 0.0;  // largest force over the distance from device to proxy
    double depth_m = 0.0;    // largest depth of the proxy below the first plane
    int squeezed_steps = 0;
  };
  Worst follow() const {
    MadeParts parts({{.normal = Vec3::UnitZ(), .stiffness = stiffness},
                     {.normal = Vec3(std::sin(tilt), 0, -std::cos(tilt)), .stiffness = other_stiffness}});
    CommonProxy proxy(2, kExtent);
    Worst worst;
    Vec3 last_force = Vec3::Zero();
    for (int i = 0; i <= 8000; ++i) {
      parts.spaces[1].X_SO.translation().z() = 0.002 + 0.004 * std::cos(6.0 * std::numbers::pi * i / 8000.0);
      const Vec3 hand(0, 0, hand_m + 0.001 * std::sin(0.003 * i));
      const MethodOutput felt = proxy.step(parts, 2, has_still, hand);
      if (i > 0) worst.jump_n = std::max(worst.jump_n, (felt.force_n - last_force).norm());
      const double length = (felt.p_SP - hand).norm();
      if (length > 64.0 * kLiftM) worst.stiffness = std::max(worst.stiffness, felt.force_n.norm() / length);
      worst.depth_m = std::max(worst.depth_m, -felt.p_SP.z());
      worst.squeezed_steps += proxy.is_squeezed() ? 1 : 0;
      last_force = felt.force_n;
    }
    return worst;
  }
};

TEST(CommonProxy, WithoutRoomTheForceIsContinuousAndWhatStandsStillHoldsTheProxy) {
  for (const double tilt : {0.0, 0.02, 0.1}) {
    for (const bool has_still : {true, false}) {
      for (const double hand_m : {-0.002, 0.0005, 0.004}) {
        SCOPED_TRACE(testing::Message() << "tilt " << tilt << " has_still " << has_still << " hand " << hand_m);
        const Squeeze::Worst worst = Squeeze{.tilt = tilt, .has_still = has_still, .hand_m = hand_m}.follow();
        // The plane moves by 9.4 um in a step, and the proxy by a multiple where the angle is small.
        EXPECT_LT(worst.jump_n, 0.45);
        EXPECT_LT(worst.stiffness, 1001.0);
        EXPECT_LT(worst.depth_m, has_still ? kLiftM : 3e-4);
        EXPECT_GT(worst.squeezed_steps, 2000);
      }
    }
  }
}

TEST(CommonProxy, NoForceIsLargerThanTheStiffestAllows) {
  for (const double tilt : {0.0, 0.02, 0.1, 0.2, 0.5, 1.0, 2.0}) {
    for (const auto& [first, other] : {std::pair(100.0, 10000.0), std::pair(10000.0, 100.0)}) {
      for (const double hand_m : {-0.002, 0.0005, 0.004}) {
        SCOPED_TRACE(testing::Message() << "tilt " << tilt << " stiffness " << first << ' ' << other << " hand " << hand_m);
        const Squeeze::Worst worst = Squeeze{tilt, true, first, other, hand_m}.follow();
        EXPECT_LT(worst.stiffness, 10010.0);
        EXPECT_LT(worst.depth_m, kLiftM);
      }
    }
  }
}

// The mean stiffness, weighted by the shares, as between objects of one method.
TEST(CommonProxy, PartsOfDifferentStiffnessHaveTheirMean) {
  MadeParts parts({{.normal = Vec3::UnitZ(), .stiffness = 100.0}, {.normal = Vec3::UnitX(), .stiffness = 1000.0}});
  CommonProxy proxy(2, kExtent);
  const MethodOutput felt = proxy.step(parts, 2, true, Vec3(-0.001, 0, -0.003));
  EXPECT_LT((felt.force_n - 325.0 * Vec3(0.001, 0, 0.003)).norm(), 1e-6);
  EXPECT_EQ(felt.object, 0) << "with the mean the longer share pushes more";
  EXPECT_NEAR(proxy.step(parts, 2, true, Vec3(0.001, 0, -0.003)).force_n.z(), 0.3, 1e-6);
}

// Half spaces with damping of their own, as force methods have: from the motion of the point at which each is felt.
class DampedParts final : public FeltParts {
 public:
  explicit DampedParts(std::vector<MadeHalfSpace> spaces)
      : undamped(std::move(spaces)), step_start(undamped.spaces.size()), last_p_S(undamped.spaces.size()) {}

  Pose pose(std::size_t part) const noexcept override { return undamped.pose(part); }
  void reset(std::size_t part, const Pose& /*X_SO*/, const Vec3& p_S) noexcept override { last_p_S[part] = p_S; }
  bool resume(std::size_t part, const Pose& /*X_SO*/, const Vec3& p_S) noexcept override {
    last_p_S[part] = p_S;
    return true;
  }
  MethodOutput feel(std::size_t part, const Pose& X_SO, const Vec3& p_S, const Turn& turn) noexcept override {
    MethodOutput output = undamped.feel(part, X_SO, p_S, turn);
    if (!turn.is_correction) step_start[part] = last_p_S[part];
    last_p_S[part] = p_S;
    const double force_n = output.force_n.norm();
    if (turn.is_shared || force_n == 0.0) return output;
    const Vec3 normal = output.force_n / force_n;
    output.force_n = std::max(0.0, force_n - kDamping * normal.dot(p_S - step_start[part]) / kStepS) * normal;
    return output;
  }
  StiffnessRange stiffness(std::size_t part) const noexcept override { return undamped.stiffness(part); }
  double damping(std::size_t, int) const noexcept override { return kDamping; }

  static constexpr double kDamping = 2.0;
  static constexpr double kStepS = 1e-3;
  MadeParts undamped;
  std::vector<Vec3> step_start;
  std::vector<Vec3> last_p_S;
};

// However the shares change, only the device's motion counts: a plane in an acute corner comes and goes while the hand moves slowly.
TEST(CommonProxy, DampsTheMotionOfTheDeviceOnly) {
  DampedParts parts({{.normal = Vec3::UnitZ()}, {.normal = Vec3(0.8, 0, -0.6)}});
  CommonProxy proxy(2, kExtent);
  Vec3 last(0.05, 0, 0.01);
  proxy.reset(last);
  double most_damping_n = 0.0;
  for (int i = 0; i < 3000; ++i) {
    parts.undamped.spaces[1].height = i % 500 < 250 ? 0.0 : -0.01;
    const Vec3 hand(0.002 * std::cos(0.002 * i), 0, -0.003 + 0.001 * std::sin(0.003 * i));
    const MethodOutput felt = proxy.step(parts, 2, true, hand, DampedParts::kStepS);
    const double moved_m = i > 0 ? (hand - last).norm() : 0.06;
    const Vec3 spring = 1000.0 * (felt.p_SP - hand);
    ASSERT_LT((felt.force_n - spring).norm(), 2.0 * DampedParts::kDamping * moved_m / DampedParts::kStepS + 1e-3) << i;
    most_damping_n = std::max(most_damping_n, i > 0 ? (felt.force_n - spring).norm() : 0.0);
    last = hand;
  }
  EXPECT_GT(most_damping_n, 0.005);
}

// After forget(), each part is felt at the device point, not shifted by the shares that the other parts had before.
TEST(CommonProxy, AfterForgetNothingHoldsTheProxy) {
  MadeParts parts({{.normal = Vec3::UnitZ()}, {.normal = Vec3::UnitX()}});
  CommonProxy proxy(2, kExtent);
  proxy.reset(Vec3(0.01, 0, 0.01));
  EXPECT_TRUE(proxy.step(parts, 2, true, Vec3(-0.003, 0, 0.01)).contact) << "with the second part alone";
  proxy.forget();
  parts.feels = 0;
  const Vec3 hand(0.02, 0.01, 0.03);
  EXPECT_FALSE(proxy.step(parts, 2, true, hand).contact);
  for (const Vec3& p_S : parts.felt_at) EXPECT_EQ(p_S, hand);
  EXPECT_EQ(parts.feels, 2);
}

// The parts that hold the proxy may be anywhere in the order of the parts.
TEST(CommonProxy, OfManyPartsEachIsLiftedOffThoseThatHold) {
  std::vector<MadeHalfSpace> spaces(200, MadeHalfSpace{.height = -1.0});
  for (const int k : {0, 1, 2}) spaces[static_cast<std::size_t>(139 - 61 * k)] = {.normal = Vec3::Unit(k)};
  MadeParts parts(spaces);
  CommonProxy proxy(200, kExtent);
  proxy.reset(Vec3(0.01, 0.01, 0.01));
  for (int n = 0; n < 3; ++n) EXPECT_LT(proxy.step(parts, 200, false, Vec3(-0.002, -0.003, -0.001)).p_SP.norm(), kLiftM);
  for (const std::size_t i : {5U, 100U, 199U}) EXPECT_LT((parts.felt_at[i] - Vec3::Constant(kLiftM)).norm(), 0.5 * kLiftM) << i;
  EXPECT_LT((parts.felt_at[78] + proxy.share_of(78).norm() * Vec3::UnitY() - kLiftM * Vec3(1, 0, 1)).norm(), 0.5 * kLiftM);
}

}  // namespace
}  // namespace hapton
