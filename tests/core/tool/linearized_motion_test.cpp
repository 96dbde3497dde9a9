#include "core/tool/linearized_motion.h"

#include <gtest/gtest.h>

#include <random>

namespace hapton {
namespace {

TEST(LinearizedMotion, EveryPathStaysNearTheLineFromItsStartToItsEnd) {
  constexpr unsigned kSeed = 11;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto random_vector = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  for (int n = 0; n < 300; ++n) {
    const RigidMotion motion{{random_vector(), turn_by(3.0 * random_vector())}, 0.3 * random_vector(), 0.4 * random_vector()};
    const LinearizedMotion linear(motion);
    const Vec3 r = random_vector();
    const Vec3 arm = linear.orientation * r;
    const Vec3 start = motion.from.at(r);
    EXPECT_LT((start - (linear.from.position + arm)).norm(), 1e-14);
    EXPECT_LT((motion.at(1.0).at(r) - (start + linear.displacement(arm))).norm(), 1e-13);
    for (double t = 0.0; t <= 1.0; t += 0.125) {
      const Vec3 on_line = start + t * linear.displacement(arm);
      EXPECT_LE((motion.at(t).at(r) - on_line).norm(), linear.sagitta * arm.norm() + 1e-14);
    }
  }
}

}  // namespace
}  // namespace hapton
