#include "bench/measure/effect_error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "bench/measure/effect_formula.h"

namespace hapton {
namespace {

const EffectCase& find_case(const std::vector<EffectCase>& cases, const std::string& name) {
  return *std::find_if(cases.begin(), cases.end(), [&](const EffectCase& one) { return one.name == name; });
}

EffectError error_of(const EffectCase& effects, double rate_hz = 1000.0, std::uint64_t seed = 1) {
  const auto error = measure_effect_error(effects, {.steps = static_cast<std::size_t>(2.0 * rate_hz), .rate_hz = rate_hz, .seed = seed});
  EXPECT_TRUE(error) << error.error().what;
  EXPECT_TRUE(*error) << effects.name;
  return **error;
}

// Effects that depend on the position alone match the formula, except for the offset at which contact begins.
TEST(EffectErrorOf, EffectsOfPositionDifferByRoundingOnly) {
  const auto cases = make_effect_cases(effect_plane());
  for (const std::uint64_t seed : {1, 2, 3}) {
    for (const char* name : {"none", "progressive stiffness", "bumps, ridges", "bumps, grid", "spring", "constant", "magnet", "line snap",
                             "plane snap", "gravity well", "wave"}) {
      EXPECT_LT(error_of(find_case(cases, name), 1000.0, seed).rms, 1e-6) << name << ", seed " << seed;
    }
  }
}

// The error of effects from images of 32 texels per wave is below 1 %.
TEST(EffectErrorOf, ImagesIsThatOfTheirResolution) {
  const auto cases = make_effect_cases(effect_plane());
  for (const char* name : {"bumps, image", "stiffness, image"}) {
    const double rms = error_of(find_case(cases, name)).rms;
    EXPECT_GT(rms, 1e-4) << name;
    EXPECT_LT(rms, 0.01) << name;
  }
}

// Velocities, beginnings and slips are found at samples: at ten times the rate the error is about a tenth; it must be less than a third.
TEST(EffectErrorOf, WhatDependsOnTimeFallsWithTheRate) {
  const auto cases = make_effect_cases(effect_plane());
  for (const char* name : {"viscosity", "viscous", "mass", "vibration on tap", "burst", "8 layers"}) {
    const double slow = error_of(find_case(cases, name)).rms;
    const double fast = error_of(find_case(cases, name), 10000.0).rms;
    EXPECT_LT(fast, slow / 3.0) << name;
    EXPECT_LT(fast, 0.1) << name;
  }
}

TEST(EffectErrorOf, TheFormulaDependsOnTheHeightOfBumps) {
  const auto cases = make_effect_cases(effect_plane());
  EffectCase bumps = find_case(cases, "bumps, ridges");
  const auto force_n = EffectFormula(bumps).force_at({.time_s = 0.001, .p = {0.0003, 0, -0.001}});
  bumps.surface.bumps.height_m *= 1.01;
  EXPECT_GT((EffectFormula(bumps).force_at({.time_s = 0.001, .p = {0.0003, 0, -0.001}}) - force_n).norm(), 1e-4);
}

TEST(EffectErrorOf, ARecordedTextureHasNoFormula) {
  const auto error = measure_effect_error(find_case(make_effect_cases(effect_plane()), "texture of 1 kHz"), {.steps = 300});
  ASSERT_TRUE(error);
  EXPECT_FALSE(*error);
}

}  // namespace
}  // namespace hapton
