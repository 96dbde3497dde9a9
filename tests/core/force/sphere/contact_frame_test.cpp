#include "core/force/sphere/contact_frame.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace hapton {
namespace {

// Largest deviation of dual . normal from the identity.
double error_of(const ContactFrame& frame) {
  double most = 0.0;
  for (int i = 0; i < frame.count; ++i) {
    for (int j = 0; j < frame.count; ++j) most = std::max(most, std::fabs(frame.dual[i].dot(frame.normal[j]) - (i == j ? 1.0 : 0.0)));
  }
  return most;
}

class RandomNormals {
 public:
  explicit RandomNormals(std::uint64_t seed) : random_(seed) { testing::Test::RecordProperty("seed", std::to_string(seed)); }
  Vec3 next() {
    const double x = normal_(random_);
    const double y = normal_(random_);
    return Vec3(x, y, normal_(random_)).normalized();
  }
  double number() { return normal_(random_); }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

TEST(ContactFrame, DualsHaveTheProductsOfAnIdentity) {
  RandomNormals random(5);
  int wide_frames = 0;
  for (int i = 0; i < 2000; ++i) {
    ContactFrame frame;
    frame.count = 1 + i % 3;
    for (int k = 0; k < frame.count; ++k) frame.normal[k] = random.next();
    double volume = 1.0;
    if (frame.count == 2) volume = frame.normal[0].cross(frame.normal[1]).norm();
    if (frame.count == 3) volume = std::fabs(frame.normal[0].cross(frame.normal[1]).dot(frame.normal[2]));
    ASSERT_TRUE(frame.prepare());
    ASSERT_LE(error_of(frame), 0x1p-49 / volume);
    wide_frames += volume > 0.1 ? 1 : 0;
    if (frame.count == 2) {
      EXPECT_NEAR(frame.along.norm(), 1.0, 0x1p-50);
      for (int k = 0; k < 2; ++k) {
        EXPECT_LE(std::fabs(frame.along.dot(frame.normal[k])), 0x1p-50 / volume);
        EXPECT_LE(std::fabs(frame.along.dot(frame.dual[k])), 0x1p-50 / (volume * volume)) << "it leaves the span";
      }
    }
  }
  EXPECT_GT(wide_frames, 1500);
}

TEST(ContactFrame, DualsGiveTheMultipliersOfAPullAndTheLeastMotionThatRaises) {
  RandomNormals random(6);
  for (int i = 0; i < 600; ++i) {
    ContactFrame frame;
    frame.count = 1 + i % 3;
    for (int k = 0; k < frame.count; ++k) frame.normal[k] = random.next();
    ASSERT_TRUE(frame.prepare());
    Vec3 pull = Vec3::Zero();
    Vec3 lift = Vec3::Zero();
    std::array<double, 3> multipliers{};
    std::array<double, 3> raises{};
    double size = 1.0;
    for (int k = 0; k < frame.count; ++k) {
      multipliers[k] = random.number();
      raises[k] = random.number();
      pull += multipliers[k] * frame.normal[k];
      lift += raises[k] * frame.dual[k];
      size = std::max(size, frame.dual[k].norm());
    }
    Vec3 out_of_span = random.next();
    for (int k = 0; k < frame.count; ++k) out_of_span -= frame.dual[k].dot(out_of_span) * frame.normal[k];
    for (int k = 0; k < frame.count; ++k) {
      EXPECT_NEAR(frame.dual[k].dot(pull), multipliers[k], 1e-14 * size * size);
      EXPECT_NEAR(frame.normal[k].dot(lift), raises[k], 1e-14 * size * size);
      EXPECT_NEAR(frame.normal[k].dot(out_of_span), 0.0, 1e-14 * size * size);
    }
    EXPECT_NEAR(lift.dot(out_of_span), 0.0, 1e-13 * size * size * size) << "a shorter motion would do";
  }
}

TEST(ContactFrame, ParallelNormalsAreRejected) {
  RandomNormals random(7);
  for (int i = 0; i < 200; ++i) {
    const Vec3 n = random.next();
    const Vec3 m = random.next();
    ContactFrame frame;
    frame.count = 2;
    frame.normal = {n, n, Vec3::Zero()};
    EXPECT_FALSE(frame.prepare());
    frame.normal[1] = -n;
    EXPECT_FALSE(frame.prepare());
    frame.count = 3;
    frame.normal = {n, m, (random.number() * n + random.number() * m).normalized()};
    EXPECT_FALSE(frame.prepare()) << "three in one plane";
  }
}

TEST(ContactFrame, NormalsALittleApartAreAccepted) {
  const Vec3 n = Vec3(1.0, 2.0, 3.0).normalized();
  const Vec3 sideways = n.unitOrthogonal();
  for (const double angle : {1e-3, 1e-6, 1e-10, 1e-13}) {
    ContactFrame frame;
    frame.count = 2;
    frame.normal = {n, n + angle * sideways, Vec3::Zero()};
    ASSERT_TRUE(frame.prepare()) << angle;
    EXPECT_LE(error_of(frame), 0x1p-50 / angle);
    EXPECT_NEAR(std::fabs(frame.along.dot(n.cross(sideways))), 1.0, 1e-15 / angle);
  }
}

}  // namespace
}  // namespace hapton
