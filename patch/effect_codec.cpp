#include "patch/effect_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <utility>
#include <variant>

#include "core/effects/texture_models.h"
#include "hapton.pb.h"
#include "link/patch_messages.h"
#include "patch/effect_numbers.h"

namespace hapton {
namespace {

using Triangles = std::vector<MappedTriangle>;
constexpr double kWhole = 65535.0;  // the 16-bit number of a texel at the highest value of its image
constexpr int kMaxImageSide = 4096;
constexpr int kTriangleNumbers = 15;
constexpr std::size_t kModelNumbers = 4;

template <class Numbers, class Field>
void append(const Numbers& numbers, Field& field) {
  for (const double number : numbers) field.Add(number);
}

template <class Field>
std::vector<double> to_vector(const Field& field) {
  return {field.begin(), field.end()};
}

// --- writing

// Writes once what several surfaces share. As in effect_numbers.h, the functions name all members of what they write.
class EffectWriter {
 public:
  explicit EffectWriter(wire::SceneEffects& to) : to_(to) {}

  void write(const SwitchedEffect& effect) {
    wire::SceneEffects::Space& space = *to_.add_space();
    space.set_kind(static_cast<std::uint32_t>(effect.effect.index()));
    space.set_button(effect.on.button);
    std::visit([&](const auto& one) { append(numbers_of(one), *space.mutable_numbers()); }, effect.effect);
  }

  void write(std::size_t object, int body, const SurfaceEffects& effects) {
    wire::SceneEffects::Surface& surface = *to_.add_surfaces();
    surface.set_object(static_cast<std::uint32_t>(object));
    surface.set_body(static_cast<std::uint32_t>(body));
    append(numbers_of(effects), *surface.mutable_numbers());
    for (std::size_t n = 0; n < effects.layers.count(); ++n) append(numbers_of(effects.layers[n]), *surface.mutable_layers());
    const auto& [triangles, height, stiffness, friction, viscosity] = effects.maps;
    if (height.is_on()) write(height, *surface.mutable_height());
    if (stiffness.is_on()) write(stiffness, *surface.mutable_stiffness());
    if (friction.is_on()) write(friction, *surface.mutable_friction());
    if (viscosity.is_on()) write(viscosity, *surface.mutable_viscosity());
    if (effects.maps.is_on()) surface.set_triangles(number_of(triangles.get(), triangles_, [&, &all = *triangles] { write(all); }));
    if (!effects.texture.is_on()) return;
    const auto& [models, mass_kg, max_force_n, seed] = effects.texture;
    wire::SceneEffects::Texture& texture = *surface.mutable_texture();
    texture.set_models(number_of(models.get(), models_, [&, &all = *models] { write(all); }));
    texture.set_mass_kg(mass_kg);
    texture.set_max_force_n(max_force_n);
    texture.set_seed(seed);
  }

 private:
  template <class Shared, class Write>
  static std::uint32_t number_of(const Shared* shared, std::vector<const Shared*>& known, Write&& write) {
    const auto found = std::find(known.begin(), known.end(), shared);
    const auto number = static_cast<std::uint32_t>(found - known.begin());
    if (found == known.end()) {
      known.push_back(shared);
      write();
    }
    return number;
  }

  void write(const ImageMap& map, wire::SceneEffects::Map& to) {
    const auto& [image, at_black, at_white] = map;
    to.set_image(number_of(image.get(), images_, [&, &texels = *image] { write(texels); }));
    to.set_at_black(at_black);
    to.set_at_white(at_white);
  }

  void write(const SurfaceImage& image) {
    wire::SceneEffects::Image& to = *to_.add_images();
    to.set_width(static_cast<std::uint32_t>(image.width()));
    to.set_height(static_cast<std::uint32_t>(image.height()));
    const auto [lowest, highest] = std::minmax_element(image.texels().begin(), image.texels().end());
    to.set_at_lowest(*lowest);
    to.set_at_highest(*highest);
    const double range = static_cast<double>(*highest) - static_cast<double>(*lowest);
    std::string& bytes = *to.mutable_texels();
    for (const float texel : image.texels()) {
      const double share = range > 0.0 ? (static_cast<double>(texel) - static_cast<double>(*lowest)) / range : 0.0;
      const auto rounded = static_cast<std::uint32_t>(std::lround(kWhole * share));
      bytes.push_back(static_cast<char>(rounded & 0xFFU));
      bytes.push_back(static_cast<char>(rounded >> 8U));
    }
  }

  void write(const Triangles& triangles) {
    auto& numbers = *to_.add_triangles()->mutable_numbers();
    for (const MappedTriangle& triangle : triangles) {
      for (const Vec3& corner : triangle.corner) {
        for (int k = 0; k < 3; ++k) numbers.Add(static_cast<float>(corner[k]));
      }
      for (const Eigen::Vector2d& place : triangle.texcoord) {
        for (int k = 0; k < 2; ++k) numbers.Add(static_cast<float>(place[k]));
      }
    }
  }

  void write(const TextureModels& models) {
    wire::SceneEffects::Models& to = *to_.add_models();
    to.set_rate_hz(models.rate_hz());
    for (const auto& [speed_m_per_s, force_n, ar, ma, variance, gain] : models.models()) {
      wire::SceneEffects::Model& one = *to.add_models();
      append(std::array{speed_m_per_s, force_n, variance, gain}, *one.mutable_numbers());
      append(ar, *one.mutable_ar());
      append(ma, *one.mutable_ma());
    }
    for (const TextureTriangle& triangle : models.triangles()) {
      for (const std::size_t corner : triangle) to.add_triangles(static_cast<std::uint32_t>(corner));
    }
  }

  wire::SceneEffects& to_;
  std::vector<const SurfaceImage*> images_;
  std::vector<const Triangles*> triangles_;
  std::vector<const TextureModels*> models_;
};

// --- reading

SwitchedEffect no_effect() { return ConstantEffect(); }

template <std::size_t Kind = 0>
bool read_kind(std::size_t kind, std::span<const double> numbers, SpaceEffect& effect) {
  if constexpr (Kind < std::variant_size_v<SpaceEffect>) {
    if (kind != Kind) return read_kind<Kind + 1>(kind, numbers, effect);
    std::variant_alternative_t<Kind, SpaceEffect> one;
    if (!read_numbers(numbers, one)) return false;
    if constexpr (std::is_same_v<decltype(one), MassEffect>) {
      if (one.filter_s < MassEffect::kMinFilterS) return false;
    }
    effect = one;
    return true;
  }
  return false;
}

bool read_layers(std::span<const double> numbers, TissueLayers& layers) {
  constexpr std::size_t kEach = 4;
  if (numbers.size() % kEach != 0 || numbers.size() / kEach > TissueLayers::kMax) return false;
  for (std::size_t at = 0; at < numbers.size(); at += kEach) {
    TissueLayer layer;
    if (!read_numbers(numbers.subspan(at, kEach), layer)) return false;
    if (layers.count() > 0) {
      const TissueLayer& before = layers[layers.count() - 1];
      if (!(layer.depth_m > before.depth_m) || std::isinf(before.pop_force_n)) return false;
    }
    layers.add(layer);
  }
  return true;
}

class EffectReader {
 public:
  // False: one of the things that surfaces share (images, triangles, models) is invalid.
  bool read_shared(const wire::SceneEffects& from) {
    return std::all_of(from.images().begin(), from.images().end(), [this](const auto& one) { return add(one); }) &&
           std::all_of(from.triangles().begin(), from.triangles().end(), [this](const auto& one) { return add(one); }) &&
           std::all_of(from.models().begin(), from.models().end(), [this](const auto& one) { return add(one); });
  }

  bool read(const wire::SceneEffects::Surface& from, SurfaceEffects& to) const {
    if (!read_numbers(to_vector(from.numbers()), to) || !read_layers(to_vector(from.layers()), to.layers)) return false;
    if (to.snap.bound_n() > kMaxEffectForceN || to.bumps.slope() > SurfaceMaps::kSteepest) return false;
    if (from.has_height() && !read(from.height(), -kMaxHeightM, 0.0, to.maps.height)) return false;
    if (from.has_stiffness() && !read(from.stiffness(), 0.0, 1.0, to.maps.stiffness)) return false;
    if (from.has_friction() && !read(from.friction(), 0.0, kMaxNumber, to.maps.friction)) return false;
    if (from.has_viscosity() && !read(from.viscosity(), 0.0, kMaxNumber, to.maps.viscosity)) return false;
    if (to.maps.is_on()) {
      if (from.triangles() >= triangles_.size()) return false;
      to.maps.triangles = triangles_[from.triangles()];
    }
    return !from.has_texture() || read(from.texture(), to.texture);
  }

 private:
  static constexpr double kMaxHeightM = 10.0;  // chosen limits, as in NumberReader
  static constexpr double kMaxNumber = 1e9;

  bool read(const wire::SceneEffects::Map& from, double least, double most, ImageMap& to) const {
    const auto is_within = [&](double number) { return number >= least && number <= most; };
    if (from.image() >= images_.size() || !is_within(from.at_black()) || !is_within(from.at_white())) return false;
    to = {images_[from.image()], from.at_black(), from.at_white()};
    return true;
  }

  bool read(const wire::SceneEffects::Texture& from, RecordedTexture& to) const {
    const bool is_possible = from.mass_kg() > 0.0 && from.mass_kg() <= kMaxMassKg && from.max_force_n() >= 0.0 &&
                             from.max_force_n() <= kMaxEffectForceN && from.models() < models_.size();
    if (!is_possible) return false;
    to = {.models = models_[from.models()], .mass_kg = from.mass_kg(), .max_force_n = from.max_force_n(), .seed = from.seed()};
    return true;
  }

  bool add(const wire::SceneEffects::Image& from) {
    const std::size_t texels = std::size_t{from.width()} * from.height();
    const double lowest = static_cast<double>(from.at_lowest());
    const double range = static_cast<double>(from.at_highest()) - lowest;
    if (from.width() - 1 >= kMaxImageSide || from.height() - 1 >= kMaxImageSide || from.texels().size() != 2 * texels) return false;
    if (!(lowest >= 0.0 && range >= 0.0 && lowest + range <= 1.0)) return false;
    std::vector<float> read;
    for (std::size_t n = 0; n < texels; ++n) {
      const auto byte = [&](std::size_t at) { return std::uint32_t{static_cast<std::uint8_t>(from.texels()[at])}; };
      read.push_back(static_cast<float>(lowest + range / kWhole * static_cast<double>(byte(2 * n) | byte(2 * n + 1) << 8U)));
    }
    images_.push_back(std::make_shared<const SurfaceImage>(static_cast<int>(from.width()), static_cast<int>(from.height()), read));
    return true;
  }

  bool add(const wire::SceneEffects::Triangles& from) {
    const auto& numbers = from.numbers();
    const auto is_possible = [](float number) { return std::abs(number) <= kMaxCoordinate; };
    if (numbers.empty() || numbers.size() % kTriangleNumbers != 0 || !std::all_of(numbers.begin(), numbers.end(), is_possible))
      return false;
    Triangles triangles(static_cast<std::size_t>(numbers.size() / kTriangleNumbers));
    int at = 0;
    for (MappedTriangle& triangle : triangles) {
      for (Vec3& corner : triangle.corner) {
        for (int k = 0; k < 3; ++k) corner[k] = static_cast<double>(numbers.Get(at++));
      }
      for (Eigen::Vector2d& place : triangle.texcoord) {
        for (int k = 0; k < 2; ++k) place[k] = static_cast<double>(numbers.Get(at++));
      }
    }
    triangles_.push_back(std::make_shared<const Triangles>(std::move(triangles)));
    return true;
  }

  bool add(const wire::SceneEffects::Models& from) {
    std::vector<TextureModel> models;
    for (const wire::SceneEffects::Model& one : from.models()) {
      if (static_cast<std::size_t>(one.numbers().size()) != kModelNumbers) return false;
      models.push_back({one.numbers(0), one.numbers(1), to_vector(one.ar()), to_vector(one.ma()), one.numbers(2), one.numbers(3)});
    }
    if (from.triangles().size() % 3 != 0) return false;
    std::vector<TextureTriangle> triangles;
    for (int n = 0; n < from.triangles().size(); n += 3) {
      triangles.push_back({from.triangles(n), from.triangles(n + 1), from.triangles(n + 2)});
    }
    auto made = TextureModels::make(from.rate_hz(), std::move(models), std::move(triangles));
    if (!made) return false;
    models_.push_back(std::make_shared<const TextureModels>(std::move(*made)));
    return true;
  }

  static constexpr double kMaxMassKg = 5.0;      // as in scene files
  static constexpr float kMaxCoordinate = 1e6F;  // of positions (m) and of texture coordinates; chosen

  std::vector<std::shared_ptr<const SurfaceImage>> images_;
  std::vector<std::shared_ptr<const Triangles>> triangles_;
  std::vector<std::shared_ptr<const TextureModels>> models_;
};

}  // namespace

std::string encode_effects(const SceneEffectSet& effects) {
  if (!effects.any()) return {};
  wire::SceneEffects message;
  message.set_objects(static_cast<std::uint32_t>(effects.surfaces.size()));
  EffectWriter writer(message);
  for (const SwitchedEffect& effect : effects.space) writer.write(effect);
  for (std::size_t object = 0; object < effects.surfaces.size(); ++object) {
    if (effects.surfaces[object].any()) writer.write(object, effects.body_of[object], effects.surfaces[object]);
  }
  return message.SerializeAsString();
}

Result<SceneEffectSet> decode_effects(std::string_view bytes) {
  wire::SceneEffects message;
  if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return fail("no effects of a scene");
  SceneEffectSet effects;
  if (static_cast<std::size_t>(message.space().size()) > kMaxSpaceEffects)
    return fail("more than {} effects in free space", kMaxSpaceEffects);
  for (const wire::SceneEffects::Space& space : message.space()) {
    SwitchedEffect& effect = effects.space.emplace_back(no_effect());
    effect.on.button = space.button();
    if (!read_kind(space.kind(), to_vector(space.numbers()), effect.effect))
      return fail("effect {} in free space is not valid for kind {}", effects.space.size(), space.kind());
  }
  if (message.objects() > kMaxEffectObjects) return fail("more than {} objects", kMaxEffectObjects);
  effects.surfaces.resize(message.objects());
  effects.body_of.resize(message.objects(), 0);
  EffectReader reader;
  if (!reader.read_shared(message)) return fail("an image, texture coordinates or a recorded texture of the effects is invalid");
  for (const wire::SceneEffects::Surface& surface : message.surfaces()) {
    const std::size_t object = surface.object();
    if (object >= effects.surfaces.size() || surface.body() >= PatchBody::kMaxBodies)
      return fail("the effects name object {}, which does not exist", object);
    effects.body_of[object] = static_cast<int>(surface.body());
    if (!reader.read(surface, effects.surfaces[object] = {})) return fail("the effects of object {} are invalid", object);
  }
  return effects;
}

}  // namespace hapton
