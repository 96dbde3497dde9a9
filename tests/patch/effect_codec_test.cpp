#include "patch/effect_codec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "patch/effect_numbers.h"
#include "tests/core/force/made_effects.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

SceneEffectSet one_of_each() {
  const EffectVolume ball = EffectVolume::ball({1, 2, 3}, 0.5);
  SceneEffectSet effects;
  effects.space = {SpringEffect{.centre = {1, 2, 3}, .stiffness_n_per_m = 4.0, .max_force_n = 5.0},
                   SwitchedEffect(ConstantEffect{.force_n = {1, 2, 3}, .volume = ball}, EffectSwitch{.button = 8}),
                   SnapEffect{.target = SnapEffect::Target::plane, .position = {1, 2, 3}, .direction = {0.6, 0.8, 0}, .range_m = 0.1},
                   GravityWellEffect{.centre = {4, 5, 6}, .radius_m = 0.3, .max_force_n = 1.5},
                   ViscousEffect{.damping_ns_per_m = 3.0, .max_force_n = 2.5, .volume = EffectVolume::box({0, 0, 0}, {1, 2, 4})},
                   WaveEffect{.waveform = Waveform::sawtooth, .direction = {0, 1, 0}, .amplitude_n = 0.7, .frequency_hz = 33.0},
                   BurstEffect{.amplitude_n = 0.9, .frequency_hz = 44.0, .decay_s = 0.1, .duration_s = 0.3, .volume = ball},
                   MassEffect{.mass_kg = 0.06, .filter_s = 0.03, .max_force_n = 2.0}};
  const TriangleMesh mesh = made::box({0, 0, 0}, {0.03, 0.02, 0.01});
  effects.surfaces.emplace_back();
  for (const NamedEffects& named : all_effects()) effects.surfaces.push_back(named.make(mesh));
  for (std::size_t object = 0; object < effects.surfaces.size(); ++object) effects.body_of.push_back(static_cast<int>(object % 3));
  effects.body_of[0] = 0;
  return effects;
}

std::vector<double> all_numbers(const SwitchedEffect& effect) {
  auto numbers = std::visit([](const auto& one) { return numbers_of(one); }, effect.effect);
  numbers.push_back(static_cast<double>(effect.effect.index()));
  numbers.push_back(static_cast<double>(effect.on.button));
  return numbers;
}

void expect_same_map(const ImageMap& a, const ImageMap& b) {
  ASSERT_EQ(a.is_on(), b.is_on());
  if (!a.is_on()) return;
  EXPECT_EQ(a.at_black, b.at_black);
  EXPECT_EQ(a.at_white, b.at_white);
  ASSERT_EQ(a.image->width(), b.image->width());
  ASSERT_EQ(a.image->texels().size(), b.image->texels().size());
  for (std::size_t n = 0; n < a.image->texels().size(); ++n) EXPECT_NEAR(a.image->texels()[n], b.image->texels()[n], 0.5 / 65535.0 + 1e-7);
}

TEST(EffectCodec, GivesBackEachEffect) {
  const SceneEffectSet before = one_of_each();
  const auto after = decode_effects(encode_effects(before));
  ASSERT_TRUE(after) << after.error().what;
  ASSERT_EQ(after->space.size(), before.space.size());
  for (std::size_t n = 0; n < before.space.size(); ++n) EXPECT_EQ(all_numbers(after->space[n]), all_numbers(before.space[n])) << n;
  ASSERT_EQ(after->surfaces.size(), before.surfaces.size());
  EXPECT_EQ(after->body_of, before.body_of);
  for (std::size_t object = 0; object < before.surfaces.size(); ++object) {
    SCOPED_TRACE(object);
    const SurfaceEffects& a = before.surfaces[object];
    const SurfaceEffects& b = after->surfaces[object];
    EXPECT_EQ(numbers_of(b), numbers_of(a));
    ASSERT_EQ(b.layers.count(), a.layers.count());
    for (std::size_t n = 0; n < a.layers.count(); ++n) EXPECT_EQ(numbers_of(b.layers[n]), numbers_of(a.layers[n]));
    for (const auto map : {&SurfaceMaps::height, &SurfaceMaps::stiffness, &SurfaceMaps::friction, &SurfaceMaps::viscosity}) {
      expect_same_map(a.maps.*map, b.maps.*map);
    }
    if (a.maps.is_on()) {
      ASSERT_EQ(b.maps.triangles->size(), a.maps.triangles->size());
      for (std::size_t t = 0; t < a.maps.triangles->size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
          EXPECT_LT(((*b.maps.triangles)[t].corner[k] - (*a.maps.triangles)[t].corner[k]).norm(), 1e-8);
          EXPECT_LT(((*b.maps.triangles)[t].texcoord[k] - (*a.maps.triangles)[t].texcoord[k]).norm(), 1e-6);
        }
      }
    }
    ASSERT_EQ(b.texture.is_on(), a.texture.is_on());
    if (!a.texture.is_on()) continue;
    EXPECT_EQ(b.texture.mass_kg, a.texture.mass_kg);
    EXPECT_EQ(b.texture.max_force_n, a.texture.max_force_n);
    EXPECT_EQ(b.texture.seed, a.texture.seed);
    EXPECT_EQ(b.texture.models->rate_hz(), a.texture.models->rate_hz());
    EXPECT_EQ(b.texture.models->triangles().size(), a.texture.models->triangles().size());
    EXPECT_EQ(b.texture.models->models()[4].ar, a.texture.models->models()[4].ar);
    EXPECT_EQ(b.texture.models->models()[4].ma, a.texture.models->models()[4].ma);
    EXPECT_EQ(b.texture.models->models()[4].gain, a.texture.models->models()[4].gain);
  }
}

TEST(EffectCodec, EncodesNoEffectsAsNoBytes) {
  SceneEffectSet none;
  none.surfaces.resize(3);
  none.body_of.resize(3, 0);
  EXPECT_FALSE(none.any());
  EXPECT_TRUE(encode_effects(none).empty());
}

TEST(EffectCodec, WritesSharedImagesOnce) {
  SceneEffectSet effects = one_of_each();
  const std::size_t one = encode_effects(effects).size();
  effects.surfaces.push_back(effects.surfaces.back());
  effects.body_of.push_back(0);
  EXPECT_LT(encode_effects(effects).size(), one + 300);
}

// A texel of eight bits comes back as it was.
TEST(EffectCodec, KeepsGreyLevels) {
  std::vector<float> texels;
  for (int grey = 0; grey < 256; ++grey) texels.push_back(static_cast<float>(grey) / 255.0F);
  SceneEffectSet effects;
  effects.surfaces.push_back(with_map(made::box({0, 0, 0}, {1, 1, 1}), &SurfaceMaps::height, -1e-3, 0.0));
  effects.surfaces[0].maps.height.image = std::make_shared<const SurfaceImage>(16, 16, texels);
  effects.body_of = {0};
  const auto after = decode_effects(encode_effects(effects));
  ASSERT_TRUE(after);
  for (std::size_t n = 0; n < texels.size(); ++n) EXPECT_FLOAT_EQ(after->surfaces[0].maps.height.image->texels()[n], texels[n]);
}

struct WrongCase {
  const char* what;
  void (*change)(SceneEffectSet&);
};

TEST(EffectCodec, RejectsEffectsThatNoSceneMayHave) {
  using Set = SceneEffectSet;
  const std::vector<WrongCase> wrong_cases = {
      {"a force above all devices", [](Set& s) { s.space[0] = SpringEffect{.max_force_n = 100.5}; }},
      {"a force below zero", [](Set& s) { s.space[0] = SpringEffect{.max_force_n = -1.0}; }},
      {"NaN", [](Set& s) { s.space[0] = SpringEffect{.stiffness_n_per_m = kNan}; }},
      {"a long force",
       [](Set& s) {
         s.space[1] = ConstantEffect{.force_n = {80, 80, 0}};
       }},
      {"no direction",
       [](Set& s) {
         s.space[2] = SnapEffect{.direction = {0, 0, 0}};
       }},
      {"no range", [](Set& s) { s.space[2] = SnapEffect{.range_m = 0.0}; }},
      {"no radius", [](Set& s) { s.space[3] = GravityWellEffect{.radius_m = 0.0}; }},
      {"negative damping", [](Set& s) { s.space[4] = ViscousEffect{.damping_ns_per_m = -1.0}; }},
      {"no decay", [](Set& s) { s.space[6] = BurstEffect{.decay_s = 0.0}; }},
      {"a short filter", [](Set& s) { s.space[7] = MassEffect{.filter_s = 0.001}; }},
      {"too many effects", [](Set& s) { s.space.resize(kMaxSpaceEffects + 1, SpringEffect()); }},
      {"steep bumps", [](Set& s) { s.surfaces[0].bumps = {.height_m = 0.002, .length_m = 0.005}; }},
      {"a strong snap", [](Set& s) { s.surfaces[0].snap = {.stiffness_n_per_m = 1e5, .range_m = 2e-3}; }},
      {"a tap without decay", [](Set& s) { s.surfaces[0].tap = {.ns_per_m = 1.0, .decay_s = 0.0}; }},
      {"layers in no order",
       [](Set& s) {
         s.surfaces[0].layers.add({.depth_m = 0.004, .pop_force_n = 1.0});
         s.surfaces[0].layers.add({.depth_m = 0.002});
       }},
      {"a layer behind one that holds",
       [](Set& s) {
         s.surfaces[0].layers.add({.depth_m = 0.001});
         s.surfaces[0].layers.add({.depth_m = 0.002});
       }},
      {"a pop force above all devices", [](Set& s) { s.surfaces[0].layers.add({.pop_force_n = 101.0}); }},
      {"a height above the surface", [](Set& s) { s.surfaces[9].maps.height.at_white = 0.1; }},
      {"more than the stiffness", [](Set& s) { s.surfaces[10].maps.stiffness.at_white = 1.5; }},
      {"negative friction", [](Set& s) { s.surfaces[11].maps.friction.at_black = -0.5; }},
      {"no triangles", [](Set& s) { s.surfaces[9].maps.triangles = std::make_shared<const std::vector<MappedTriangle>>(); }},
      {"bright texels",
       [](Set& s) { s.surfaces[9].maps.height.image = std::make_shared<const SurfaceImage>(1, 1, std::vector<float>{1.5F}); }},
      {"a large mass", [](Set& s) { s.surfaces[8].texture.mass_kg = 6.0; }},
      {"a loud texture", [](Set& s) { s.surfaces[8].texture.max_force_n = 101.0; }},
      {"a body that there is not", [](Set& s) { s.body_of[1] = 32; }},
  };
  // The surfaces that the cases above change.
  ASSERT_TRUE(one_of_each().surfaces[9].maps.height.is_on());
  ASSERT_TRUE(one_of_each().surfaces[10].maps.stiffness.is_on());
  ASSERT_TRUE(one_of_each().surfaces[11].maps.friction.is_on());
  ASSERT_TRUE(one_of_each().surfaces[8].texture.is_on());
  for (const WrongCase& one : wrong_cases) {
    SceneEffectSet effects = one_of_each();
    one.change(effects);
    EXPECT_FALSE(decode_effects(encode_effects(effects))) << one.what;
  }
}

// For any bytes decode_effects() returns effects or an error.
TEST(EffectCodec, DecodesAnyBytesToEffectsOrAnError) {
  const std::string good = encode_effects(one_of_each());
  std::mt19937_64 random(61);
  int accepted = 0;
  for (int n = 0; n < 3000; ++n) {
    std::string bytes = good;
    const std::size_t changes = 1 + random() % 4;
    for (std::size_t c = 0; c < changes; ++c) bytes[random() % std::min<std::size_t>(bytes.size(), 4000)] = static_cast<char>(random());
    if (random() % 3 == 0) bytes.resize(random() % bytes.size());
    accepted += decode_effects(bytes) ? 1 : 0;
  }
  EXPECT_GT(accepted, 0);
  EXPECT_FALSE(decode_effects("no effects"));
}

}  // namespace
}  // namespace hapton
