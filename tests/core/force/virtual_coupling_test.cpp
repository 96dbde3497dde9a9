#include "core/force/virtual_coupling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

#include "core/force/force_method.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

TEST(VirtualCoupling, TwoSpringsInSeriesAreOne) {
  const Material coupled = couple_material({.stiffness_n_per_m = 3000.0, .damping_ns_per_m = 8.0, .friction_static = 0.5}, 1000.0);
  EXPECT_DOUBLE_EQ(coupled.stiffness_n_per_m, 750.0);
  EXPECT_DOUBLE_EQ(coupled.damping_ns_per_m, 0.5);
  EXPECT_EQ(coupled.friction_static, 0.5);
}

TEST(VirtualCoupling, NoSurfaceIsStifferThanTheCoupling) {
  for (const double stiffness : {1.0, 1e3, 1e6, 1e300}) {
    const double coupled = couple_material({.stiffness_n_per_m = stiffness}, 800.0).stiffness_n_per_m;
    EXPECT_LE(coupled, 800.0);
    EXPECT_LE(coupled, stiffness);
    EXPECT_GE(coupled, 0.5 * std::min(stiffness, 800.0));
  }
}

TEST(VirtualCoupling, WithoutOneNothingChanges) {
  const Material material{.stiffness_n_per_m = 1234.5, .damping_ns_per_m = 0.7};
  EXPECT_EQ(couple_material(material, 0.0).stiffness_n_per_m, 1234.5);
  EXPECT_EQ(couple_material(material, 0.0).damping_ns_per_m, 0.7);
}

// The force at a depth in a ball, by every method. A coupling of 1,000 N/m in series with 3,000 N/m leaves a quarter of it.
TEST(VirtualCoupling, EveryMethodUsesTheCoupling) {
  const TouchScene ball{.objects = {{made::shared(made::sphere(0.05, 32)), {.stiffness_n_per_m = 3000.0}}}};
  for (const char* name : {"proxy", "smooth", "sweep", "reference"}) {
    const auto force_of = [&](double coupling_n_per_m) {
      auto method = make_method({.name = name, .coupling_n_per_m = coupling_n_per_m}, ball);
      EXPECT_TRUE(method) << name;
      (*method)->reset(Vec3(0.0, 0.0, 0.06));
      MethodOutput out;
      for (double z = 0.06; z > 0.049; z -= 1e-4) {
        while ((*method)->prepare()) {
        }
        out = (*method)->step({.p_SD = Vec3(0.001, 0.0, z)});
      }
      return out.force_n.norm();
    };
    const double alone = force_of(0.0);
    EXPECT_GT(alone, 1.0) << name;
    EXPECT_NEAR(force_of(1000.0), 0.25 * alone, 1e-9 * alone) << name;
  }
}

TEST(VirtualCoupling, AnImpossibleOneIsRejected) {
  const TouchScene ball{.objects = {{made::shared(made::sphere(0.05, 8)), {}}}};
  for (const double bad : {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const auto method = make_method({.coupling_n_per_m = bad}, ball);
    ASSERT_FALSE(method);
    EXPECT_NE(method.error().what.find("coupling"), std::string::npos) << method.error().what;
  }
}

}  // namespace
}  // namespace hapton
