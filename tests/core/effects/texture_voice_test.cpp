#include "core/effects/texture_voice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/effects/effect_step.h"
#include "tests/core/effects/made_textures.h"
#include "tests/core/effects/spectrum_of.h"

namespace hapton {
namespace {

constexpr double kTextureSpring = 1000.0;  // N/m

SurfaceContact on_floor(const Vec3& p_SD, int object = 0) {
  if (!(p_SD.z() < 0.0)) return {.p_SP = p_SD};
  return {.force_n = {0, 0, -kTextureSpring * p_SD.z()}, .p_SP = {p_SD.x(), p_SD.y(), 0}, .object = object, .contact = true};
}

// Slides along x. Returns what the texture adds to the force along y, divided by the mass of the texture: an acceleration.
std::vector<double> slide(const RecordedTexture& texture, double speed, double force, double rate_hz, double seconds) {
  EffectStep step({SurfaceEffects{.texture = texture}}, {});
  std::vector<double> across;
  const double dt_s = 1.0 / rate_hz;
  const auto settling_steps = static_cast<std::size_t>(0.3 * rate_hz);
  const auto measured_steps = static_cast<std::size_t>(seconds * rate_hz);
  for (std::size_t n = 0; n < settling_steps + measured_steps; ++n) {
    const Vec3 p(speed * static_cast<double>(n) * dt_s, 0, -force / kTextureSpring);
    const Vec3 force_n = step.step(p, dt_s, on_floor(p)).force_n;
    EXPECT_EQ(force_n.x(), 0.0) << "along the motion";
    if (n >= settling_steps) across.push_back(force_n.y() / texture.mass_kg);
  }
  return across;
}

// Largest difference from the models' own spectrum, dB, in bands of 1/25 of half the lower rate, from 0.02 to 0.9 of half the lower rate.
double worst_band_db(const TextureModels& models, const TextureModel& expected, const std::vector<double>& signal, double rate_hz,
                     std::size_t size) {
  const auto measured = spectrum::density(signal, rate_hz, size);
  const double half_lower_hz = 0.5 * std::min(rate_hz, models.rate_hz());
  const double bin_hz = rate_hz / static_cast<double>(size);
  double worst = 0.0;
  for (double low_hz = 0.02 * half_lower_hz; low_hz < 0.88 * half_lower_hz; low_hz += 0.04 * half_lower_hz) {
    double measured_power = 0.0, expected_power = 0.0;
    for (auto k = static_cast<std::size_t>(low_hz / bin_hz); static_cast<double>(k) * bin_hz < low_hz + 0.04 * half_lower_hz; ++k) {
      measured_power += measured[k];
      expected_power += made::density(expected, models.rate_hz(), static_cast<double>(k) * bin_hz);
    }
    worst = std::max(worst, std::abs(10.0 * std::log10(measured_power / expected_power)));
  }
  return worst;
}

// Models at 1 and 10 kHz, steps at 1 and 10 kHz, speeds and forces of models and between models; each case has its own seed.
TEST(TextureVoice, HasTheSpectrumOfItsModelsAtAnyRate) {
  std::uint64_t seed = 1;
  for (const double model_hz : {1000.0, 10000.0}) {
    const auto models = made::texture(model_hz, 20, model_hz < 5000.0 ? 18 : 0);
    ASSERT_NE(models, nullptr);
    for (const double rate_hz : {1000.0, 10000.0}) {
      for (const auto& [speed, force] : {std::pair(0.1, 2.0), std::pair(0.2, 4.0), std::pair(0.13, 2.7), std::pair(0.17, 1.1)}) {
        const RecordedTexture texture = {.models = models, .mass_kg = 0.01, .max_force_n = 10.0, .seed = seed++};
        const auto signal = slide(texture, speed, force, rate_hz, 40.0);
        const TextureModel expected = made::interpolated(*models, speed, force);
        EXPECT_LT(worst_band_db(*models, expected, signal, rate_hz, rate_hz < 5000.0 ? 1024 : 8192), 1.0)
            << model_hz << " Hz read at " << rate_hz << ", " << speed << " m/s, " << force << " N, seed " << texture.seed;
      }
    }
  }
}

// Each interval of 1 / 3700 s is divided into two steps at a random moment, so that steps are late or early.
TEST(TextureVoice, HasTheSpectrumWithUnevenSteps) {
  const auto models = made::texture(1000.0, 20, 18);
  const RecordedTexture texture = {.models = models, .mass_kg = 0.01, .max_force_n = 10.0};
  TextureVoice voice;
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> factor(0.8, 1.2);
  constexpr double kRateHz = 3700.0;  // not a multiple of the models' rate
  // The first of two steps ends at 0.4 to 0.6 of the interval. The signal is taken after the second one, so at equal intervals.
  std::vector<double> signal;
  for (int n = 0; n < 200000; ++n) {
    const double first_s = 0.5 * factor(random) / kRateHz;
    voice.force(texture, {0.13, 0, 0}, Vec3::UnitZ(), 2.7, first_s);
    const Vec3 force_n = voice.force(texture, {0.13, 0, 0}, Vec3::UnitZ(), 2.7, 1.0 / kRateHz - first_s);
    if (n > 2000) signal.push_back(force_n.y() / texture.mass_kg);
  }
  EXPECT_LT(worst_band_db(*models, made::interpolated(*models, 0.13, 2.7), signal, kRateHz, 4096), 1.0);
}

// Two voices at one speed: in one, every 100th step is missed, so that the next one takes twice the time. A change of the signal's delay
// would differ by the whole amplitude.
TEST(TextureVoice, ALateStepLeavesTheSignalAsItIs) {
  for (const auto& [model_hz, rate_hz] : {std::pair(1000.0, 1000.0), std::pair(2000.0, 1000.0), std::pair(10000.0, 2000.0)}) {
    const RecordedTexture texture = {.models = made::texture(model_hz, 20, 0), .mass_kg = 0.01, .max_force_n = 10.0};
    ASSERT_NE(texture.models, nullptr);
    const double dt_s = 1.0 / rate_hz;
    TextureVoice even, late;
    const auto step = [&](TextureVoice& voice, double step_s) {
      return voice.force(texture, {0.13, 0, 0}, Vec3::UnitZ(), 2.7, step_s).y();
    };
    double largest_n = 0.0;
    for (int n = 1; n < 5000; ++n) {
      const double even_n = step(even, dt_s);
      if (n % 100 == 99) continue;
      const double late_n = step(late, n % 100 == 0 ? 2.0 * dt_s : dt_s);
      largest_n = std::max(largest_n, std::fabs(even_n));
      if (n > 500) {
        ASSERT_NEAR(late_n, even_n, 1e-6 * largest_n) << model_hz << " Hz read at " << rate_hz << " Hz, step " << n;
      }
    }
    EXPECT_GT(largest_n, 0.0);
  }
}

TEST(TextureVoice, ActsAcrossTheMotionWithinItsBounds) {
  const RecordedTexture texture = {.models = made::texture(1000.0, 20, 18), .mass_kg = 5.0, .max_force_n = 1.5};
  TextureVoice voice;
  std::mt19937_64 random(9);
  std::normal_distribution<double> normal;
  double largest_n = 0.0;
  for (int n = 0; n < 100000; ++n) {
    // Any jumps: speeds, directions and forces from step to step.
    const Vec3 n_S = Vec3(normal(random), normal(random), normal(random)).normalized();
    const Vec3 v = 0.2 * Vec3(normal(random), normal(random), normal(random));
    const double pressed_n = std::abs(2.0 * normal(random));
    const Vec3 force_n = voice.force(texture, v, n_S, pressed_n, 1e-3 * std::abs(normal(random)));
    ASSERT_TRUE(force_n.allFinite());
    EXPECT_LE(force_n.norm(), std::min(texture.bound_n(), pressed_n) + 1e-12);
    EXPECT_LT(std::abs(force_n.dot(n_S)), 1e-9);
    largest_n = std::max(largest_n, force_n.norm());
  }
  EXPECT_GT(largest_n, 1.4) << "the bound was reached";
}

TEST(TextureVoice, IsSilentAtRestAndWithoutContact) {
  const auto models = made::texture(1000.0, 20, 18);
  EffectStep step({SurfaceEffects{.texture = {.models = models, .mass_kg = 0.2}}}, {});
  double x = 0.0;
  const auto force_after = [&](double moved, double z) {
    x += moved;
    return step.step({x, 0, z}, 1e-3, on_floor({x, 0, z})).force_n;
  };
  for (int n = 0; n < 50; ++n) EXPECT_EQ(force_after(0.0, -0.002), Vec3(0, 0, 2)) << "pressed, at rest";
  double loudest = 0.0;
  for (int n = 0; n < 300; ++n) loudest = std::max(loudest, std::abs(force_after(2e-4, -0.002).y()));
  EXPECT_GT(loudest, 0.05);
  for (int n = 0; n < 60; ++n) force_after(0.0, -0.002);
  for (int n = 0; n < 50; ++n) EXPECT_EQ(force_after(0.0, -0.002), Vec3(0, 0, 2)) << "at rest again";
  for (int n = 0; n < 300; ++n) force_after(2e-4, -0.002);
  EXPECT_EQ(force_after(2e-4, 0.001), Vec3::Zero()) << "at once";
}

// Each contact begins with kHalfWidth samples of silence, also when it soon follows another one, and goes on with new noise.
TEST(TextureVoice, EachContactBeginsSoftlyAndWithNewNoise) {
  EffectStep step({SurfaceEffects{.texture = {.models = made::texture(1000.0, 20, 18), .mass_kg = 0.2}}}, {});
  double x = 0.0;
  const auto force_across = [&](double z) {
    x += 2e-4;
    return step.step({x, 0, z}, 1e-3, on_floor({x, 0, z})).force_n.y();
  };
  std::vector<std::vector<double>> contacts(3);
  for (auto& forces : contacts) {
    for (int n = 0; n < 20; ++n) force_across(0.001);
    for (int n = 0; n < 200; ++n) forces.push_back(force_across(-0.002));
    for (std::size_t n = 0; n < BandLimitedSignal::kHalfWidth; ++n) EXPECT_EQ(forces[n], 0.0) << n;
    EXPECT_NE(forces.back(), 0.0);
  }
  double largest_difference_n = 0.0;
  for (std::size_t n = 0; n < contacts[1].size(); ++n)
    largest_difference_n = std::max(largest_difference_n, std::abs(contacts[1][n] - contacts[2][n]));
  EXPECT_GT(largest_difference_n, 0.02) << "not the same again";
}

TEST(TextureVoice, RepeatsBitForBitAfterAReset) {
  const auto models = made::texture(1000.0, 20, 18);
  EffectStep step({SurfaceEffects{.texture = {.models = models, .mass_kg = 0.1}}}, {});
  const auto run = [&] {
    std::vector<Vec3> forces;
    for (int n = 0; n < 2000; ++n) {
      const Vec3 p(0.02 * std::sin(0.01 * n), 0.01 * std::cos(0.013 * n), 0.001 * std::sin(0.004 * n) - 0.0005);
      forces.push_back(step.step(p, 1e-3 * (1.0 + 0.1 * std::sin(n)), on_floor(p)).force_n);
    }
    step.reset();
    return forces;
  };
  const auto first = run();
  EXPECT_EQ(first, run());
  EffectStep other({SurfaceEffects{.texture = {.models = models, .mass_kg = 0.1, .seed = 2}}}, {});
  std::swap(step, other);
  EXPECT_NE(first, run());
}

// Three surfaces in turn: two with models of different orders and rates, and one without a texture.
TEST(TextureVoice, GoesFromSurfaceToSurface) {
  const SurfaceEffects one = {.texture = {.models = made::texture(1000.0, 20, 18), .mass_kg = 0.02}};
  const SurfaceEffects other = {.texture = {.models = made::texture(2000.0, 31, 0), .mass_kg = 0.02}};
  EffectStep step({one, other, SurfaceEffects()}, {});
  double loudest = 0.0;
  for (int n = 0; n < 20000; ++n) {
    const Vec3 p(1e-4 * n, 0, -0.003);
    const int object = n / 7 % 3;
    const Vec3 force_n = step.step(p, 1e-3, on_floor(p, object)).force_n;
    if (object == 2) {
      EXPECT_EQ(force_n, Vec3(0, 0, 3));
    }
    loudest = std::max(loudest, std::abs(force_n.y()));
  }
  EXPECT_LT(loudest, 6.0 * 0.02 * one.texture.models->loudest_m_per_s2() + 6.0 * 0.02 * other.texture.models->loudest_m_per_s2());
}

// However fast speed and force change over the models, the signal is no louder than the models are. Here the speed changes every 30 ms, and
// the force every 20 ms.
TEST(TextureVoice, IsNoLouderThanItsModelsWhereTheyChangeFast) {
  const auto models = made::texture(1000.0, 20, 18);
  const RecordedTexture texture = {.models = models, .mass_kg = 1e-3, .max_force_n = 1e9};
  TextureVoice voice;
  double loudest = 0.0;
  for (int n = 0; n < 200000; ++n) {
    const double speed = n / 30 % 2 == 0 ? 0.1 + 0.1 * std::sin(1.1 * n) : 0.02;
    const double force = n / 20 % 2 == 0 ? 0.5 : 4.0;
    loudest = std::max(loudest, voice.force(texture, {speed, 0, 0}, Vec3::UnitZ(), force, 1e-3).norm());
  }
  EXPECT_LT(loudest, 6.0 * texture.mass_kg * models->loudest_m_per_s2());
}

// In a gap of 1024 samples of the models no more of them are made than in one of kMaxSamples: the signal after both gaps is the same. After
// a gap that is one sample shorter, the signal is another one.
TEST(TextureVoice, ALongGapTakesABoundedNumberOfSamples) {
  const RecordedTexture slow = {.models = made::texture(1024.0, 20, 0), .mass_kg = 0.01, .max_force_n = 10.0};
  ASSERT_NE(slow.models, nullptr);
  const auto signal_after_gap = [&](double gap_samples) {
    constexpr double kStepS = 0x1p-10;  // one sample of the models: both are powers of two, so that the number of samples due is exact
    TextureVoice voice;
    const auto step = [&](double dt_s) { return voice.force(slow, {0.13, 0, 0}, Vec3::UnitZ(), 2.7, dt_s).y(); };
    for (int n = 0; n < 1000; ++n) step(kStepS);
    step(gap_samples * kStepS);
    std::vector<double> signal;
    for (int n = 0; n < 200; ++n) signal.push_back(step(kStepS));
    return signal;
  };
  const std::vector<double> longest = signal_after_gap(TextureVoice::kMaxSamples);
  const std::vector<double> longer = signal_after_gap(1024.0);
  const std::vector<double> shorter = signal_after_gap(TextureVoice::kMaxSamples - 1);
  double largest_n = 0.0, largest_difference_n = 0.0;
  for (std::size_t n = 0; n < longest.size(); ++n) {
    largest_n = std::max(largest_n, std::fabs(longest[n]));
    largest_difference_n = std::max(largest_difference_n, std::fabs(longest[n] - shorter[n]));
  }
  EXPECT_GT(largest_difference_n, 0.1 * largest_n);
  for (std::size_t n = 0; n < longest.size(); ++n) EXPECT_NEAR(longer[n], longest[n], 1e-6 * largest_n) << n;

  const RecordedTexture texture = {.models = made::texture(10000.0, 20, 0)};
  TextureVoice voice;
  for (const double dt_s : {1.0, 0.0, -1.0, 1e-9, 0.7}) {
    EXPECT_TRUE(voice.force(texture, {0.1, 0, 0}, Vec3::UnitZ(), 1.0, dt_s).allFinite());
  }
}

}  // namespace
}  // namespace hapton
