#include "core/effects/texture_models.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "tests/core/effects/made_textures.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

void expect_blend(const TextureModels& models, double speed, double force, double query_speed, double query_force) {
  const TextureModel expected = made::interpolated(models, speed, force);
  TextureModels::Blend blend;
  std::size_t triangle = 5;
  models.blend(query_speed, query_force, triangle, blend);
  const auto expect_coefficients = [](std::span<const double> found, const std::vector<double>& frequencies) {
    const auto expected_coefficients = made::coefficients(frequencies);
    ASSERT_EQ(found.size(), frequencies.size());
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected_coefficients[i + 1], 1e-6);
  };
  expect_coefficients(models.ar(blend), expected.ar);
  expect_coefficients(models.ma(blend), expected.ma);
  EXPECT_NEAR(blend.deviation, expected.gain * std::sqrt(expected.variance), 1e-9);
}

TEST(TextureModels, InterpolatesOverTheTriangle) {
  const auto models = made::texture(1000.0, 20, 18);
  ASSERT_NE(models, nullptr);
  for (double speed = 0.0; speed <= 0.2; speed += 0.0125) {
    for (double force = 0.0; force <= 4.0; force += 0.23) expect_blend(*models, speed, force, speed, force);
  }
}

TEST(TextureModels, BeyondTheModelsIsTheBorder) {
  const auto models = made::texture(1000.0, 16, 0);
  ASSERT_NE(models, nullptr);
  expect_blend(*models, 0.2, 1.3, 5.0, 1.3);
  expect_blend(*models, 0.07, 4.0, 0.07, 1e9);
  expect_blend(*models, 0.2, 4.0, 1e9, 1e9);
  expect_blend(*models, 0.0, 0.0, -1.0, -1.0);
}

// The triangle does not fill the range of the models: a place outside the triangle gets the model of the side that faces it.
TEST(TextureModels, OutsideTheTrianglesNoShareIsNegative) {
  auto models = TextureModels::make(1000.0, made::nine_models(8, 0), {{0, 2, 6}});
  ASSERT_TRUE(models) << models.error().what;
  TextureModels::Blend blend;
  std::size_t triangle = 0;
  models->blend(0.2, 4.0, triangle, blend);
  const auto& a = models->models()[2];
  const auto& b = models->models()[6];
  std::vector<double> middle;
  for (std::size_t i = 0; i < 8; ++i) middle.push_back(0.5 * (a.ar[i] + b.ar[i]));
  const auto expected = made::coefficients(middle);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_NEAR(models->ar(blend)[i], expected[i + 1], 1e-6);
}

// All poles are inside the unit circle if the reflection coefficients of the polynomial are below 1 (Schur and Cohn).
void expect_stable(const TextureModels& models, double speed, double force) {
  TextureModels::Blend blend;
  std::size_t triangle = 0;
  models.blend(speed, force, triangle, blend);
  std::vector<double> c = {1.0};
  c.insert(c.end(), models.ar(blend).begin(), models.ar(blend).end());
  while (c.size() > 1) {
    const double reflection = c.back();
    ASSERT_LT(std::abs(reflection), 1.0) << speed << " " << force;
    std::vector<double> lower;
    for (std::size_t i = 0; i + 1 < c.size(); ++i) {
      lower.push_back((c[i] - reflection * c[c.size() - 1 - i]) / (1.0 - reflection * reflection));
    }
    c = lower;
  }
}

TEST(TextureModels, EveryInterpolatedFilterIsStable) {
  const auto models = made::texture(1000.0, 20, 18);
  ASSERT_NE(models, nullptr);
  for (int s = 0; s <= 40; ++s) {
    for (int f = 0; f <= 40; ++f) expect_stable(*models, 0.005 * s, 0.1 * f);
  }
}

// Models of any order, with any ascending frequencies: the filters interpolated between them are stable too.
TEST(TextureModels, StableModelsHaveStableFiltersBetweenThem) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int round = 0; round < 60; ++round) {
    const std::size_t order = 1 + random() % 24;
    auto nine = made::nine_models(order, 0);
    for (TextureModel& model : nine) {
      std::vector<double> cuts;
      for (std::size_t i = 0; i <= order; ++i) cuts.push_back(0.2 + unit(random));
      double sum = 0.0;
      for (const double cut : cuts) sum += cut;
      double at = 0.0;
      for (std::size_t i = 0; i < order; ++i) model.ar[i] = at += std::numbers::pi * cuts[i] / sum;
      model.variance = 0.0;  // so that no model is rejected as too loud
    }
    const auto models = TextureModels::make(1000.0, nine, made::eight_triangles());
    ASSERT_TRUE(models) << models.error().what;
    for (int n = 0; n < 100; ++n) expect_stable(*models, 0.2 * unit(random), 4.0 * unit(random));
  }
}

TEST(TextureModels, KnowsTheLoudest) {
  const auto models = made::texture(1000.0, 20, 18);
  ASSERT_NE(models, nullptr);
  double loudest = 0.0;
  for (const TextureModel& model : models->models()) {
    double sum = 0.0;
    for (int k = 0; k < 20000; ++k) sum += made::density(model, 1000.0, 500.0 * (k + 0.5) / 20000.0) * 500.0 / 20000.0;
    loudest = std::max(loudest, std::sqrt(sum));
  }
  EXPECT_NEAR(models->loudest_m_per_s2(), loudest, 1e-3 * loudest);
}

std::string models_error(double rate_hz, const std::vector<TextureModel>& models, const std::vector<TextureTriangle>& triangles) {
  const auto made = TextureModels::make(rate_hz, models, triangles);
  return made ? "it was made" : made.error().what;
}

TEST(TextureModels, RejectsInvalidTextures) {
  const auto triangles = made::eight_triangles();
  const auto error_with = [&](auto change) {
    auto models = made::nine_models(8, 4);
    change(models[3]);
    return models_error(1000.0, models, triangles);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(models_error(nan, made::nine_models(8, 4), triangles), HasSubstr("sample rate"));
  EXPECT_THAT(models_error(20000.0, made::nine_models(8, 4), triangles), HasSubstr("sample rate is 20000 Hz"));
  EXPECT_THAT(models_error(1000.0, {}, triangles), HasSubstr("there are 0 models"));
  EXPECT_THAT(models_error(1000.0, std::vector<TextureModel>(257, made::nine_models(8, 4)[4]), triangles), HasSubstr("257 models"));
  EXPECT_THAT(models_error(1000.0, made::nine_models(8, 4), {}), HasSubstr("there are 0 triangles"));
  EXPECT_THAT(models_error(1000.0, made::nine_models(8, 4), {{0, 1, 9}}), HasSubstr("triangle 1 names model 10 of 9"));
  EXPECT_THAT(models_error(1000.0, made::nine_models(8, 4), {{0, 1, 3}, {0, 1, 2}}), HasSubstr("triangle 2 has no area"));
  EXPECT_THAT(models_error(1000.0, made::nine_models(0, 4), triangles), HasSubstr("0 AR and 4 MA"));
  EXPECT_THAT(models_error(1000.0, made::nine_models(33, 0), triangles), HasSubstr("33 AR"));
  EXPECT_THAT(models_error(1000.0, made::nine_models(8, 33), triangles), HasSubstr("33 MA"));
  EXPECT_THAT(error_with([&](TextureModel& m) { m.speed_m_per_s = -0.1; }), HasSubstr("model 4: its speed"));
  EXPECT_THAT(error_with([&](TextureModel& m) { m.force_n = nan; }), HasSubstr("model 4: its force"));
  EXPECT_THAT(error_with([&](TextureModel& m) { m.variance = -1.0; }), HasSubstr("model 4: its variance"));
  EXPECT_THAT(error_with([&](TextureModel& m) { m.gain = nan; }), HasSubstr("model 4: its gain"));
  EXPECT_THAT(error_with([&](TextureModel& m) { m.ar.pop_back(); }), HasSubstr("model 4 has 7 AR"));
  EXPECT_THAT(error_with([&](TextureModel& m) { std::swap(m.ar[2], m.ar[3]); }), HasSubstr("model 4 is not stable"));
  EXPECT_THAT(error_with([&](TextureModel& m) { m.ar[2] = m.ar[3] - 1e-6; }), HasSubstr("model 4 is not stable"));
  EXPECT_THAT(error_with([&](TextureModel& m) { m.ar[7] = 3.1415; }), HasSubstr("model 4 is not stable"));
  EXPECT_THAT(error_with([&](TextureModel& m) { m.ar[0] = 0.0; }), HasSubstr("model 4 is not stable"));
  EXPECT_THAT(error_with([&](TextureModel& m) { m.ar[0] = nan; }), HasSubstr("model 4 is not stable"));
  EXPECT_THAT(error_with([&](TextureModel& m) { m.ma[0] = nan; }), HasSubstr("model 4: its MA"));
  EXPECT_THAT(error_with([&](TextureModel& m) { m.ma[3] = 3.2; }), HasSubstr("model 4: its MA"));
  EXPECT_THAT(error_with([&](TextureModel& m) {
                m.variance = 1e6;
                m.gain = 1e4;
              }),
              HasSubstr("model 4 has"));
}

}  // namespace
}  // namespace hapton
