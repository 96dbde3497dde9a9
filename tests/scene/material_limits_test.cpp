#include "scene/material_limits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <vector>

namespace hapton {
namespace {

using testing::HasSubstr;

std::string material_error(const Material& material, const SurfaceEffects& effects = {}, const Material& before = {}) {
  const auto fits = check_material(material, before, effects, "hull");
  return fits ? std::string() : fits.error().what;
}

TEST(MaterialLimits, ANumberOutOfRangeIsNamedWithItsRange) {
  EXPECT_EQ(material_error({}), "");
  EXPECT_EQ(material_error({.stiffness_n_per_m = 1e6, .damping_ns_per_m = 1e4, .friction_static = 10.0, .friction_dynamic = 10.0}), "");
  EXPECT_EQ(material_error({.stiffness_n_per_m = 0.0}),
            "'stiffness_n_per_m' of object 'hull' is 0: it must be above 0 and at most 1000000");
  EXPECT_EQ(material_error({.damping_ns_per_m = 2e4}),
            "'damping_ns_per_m' of object 'hull' is 20000: it must be at least 0 and at most 10000");
  EXPECT_THAT(material_error({.friction_static = -0.1}), HasSubstr("'friction_static' of object 'hull' is -0.1"));
  EXPECT_THAT(material_error({.friction_static = 11.0}), HasSubstr("at most 10"));
  EXPECT_THAT(material_error({.friction_static = 10.0, .friction_dynamic = 11.0}), HasSubstr("'friction_dynamic'"));
  EXPECT_THAT(material_error({.stiffness_n_per_m = std::numeric_limits<double>::quiet_NaN()}), HasSubstr("nan"));
}

TEST(MaterialLimits, DynamicFrictionIsAtMostTheStaticOne) {
  EXPECT_EQ(material_error({.friction_static = 0.3, .friction_dynamic = 0.3}), "");
  EXPECT_THAT(material_error({.friction_static = 0.3, .friction_dynamic = 0.4}),
              HasSubstr("is 0.4, more than 'friction_static' 0.3: make it at most that"));
}

TEST(MaterialLimits, EffectsOfASurfaceExcludeMaterialNumbersAsInSceneFiles) {
  SurfaceEffects layered;
  layered.layers.add({.depth_m = 0.0, .stiffness_n_per_m = 400.0, .pop_force_n = 1.0, .drag_ns_per_m = 1.0});
  EXPECT_EQ(material_error({.friction_static = 0.3}, layered), "") << "friction along the skin";
  EXPECT_THAT(material_error({.stiffness_n_per_m = 500.0}, layered), HasSubstr("has layers"));
  EXPECT_THAT(material_error({.damping_ns_per_m = 1.0}, layered), HasSubstr("has layers"));
  SurfaceEffects bumpy;
  bumpy.bumps.height_m = 1e-4;
  bumpy.bumps.length_m = 1e-3;
  EXPECT_EQ(material_error({.stiffness_n_per_m = 500.0}, bumpy), "");
  EXPECT_THAT(material_error({.damping_ns_per_m = 1.0}, bumpy), HasSubstr("source of energy"));
  const auto image = std::make_shared<const SurfaceImage>(1, 1, std::vector<float>{0.5F});
  for (ImageMap SurfaceMaps::*relief : {&SurfaceMaps::height, &SurfaceMaps::stiffness}) {
    SurfaceEffects mapped;
    mapped.maps.*relief = {.image = image, .at_black = 0.1, .at_white = 0.2};
    EXPECT_EQ(material_error({.friction_static = 0.3}, mapped), "");
    EXPECT_THAT(material_error({.damping_ns_per_m = 1.0}, mapped), HasSubstr("source of energy"));
  }
  SurfaceEffects rough;
  rough.maps.friction = {.image = image, .at_black = 0.1, .at_white = 0.2};
  EXPECT_EQ(material_error({.damping_ns_per_m = 1.0}, rough), "");
  EXPECT_EQ(material_error({.friction_static = 0.3}, rough),
            "object 'hull' has a friction map instead of friction coefficients: change the map in the scene file");
}

}  // namespace
}  // namespace hapton
