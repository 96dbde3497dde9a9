#include "scene/gltf/base_colour.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <set>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scene/text_cursor.h"

namespace hapton::gltf {
namespace {

constexpr const char* kGlossiness = "KHR_materials_pbrSpecularGlossiness";
constexpr const char* kStrength = "KHR_materials_emissive_strength";

std::optional<Vec3> colour_of(const Json& value) {
  const auto numbers = numbers_of<3>(value, "");
  return numbers ? std::optional(Vec3((*numbers)[0], (*numbers)[1], (*numbers)[2])) : std::nullopt;
}

void read_factor(const Json& rgba, BaseColour& base) {
  const auto numbers = numbers_of<4>(rgba, "");
  if (!numbers) return;
  base.has_colour = true;
  base.colour = Vec3((*numbers)[0], (*numbers)[1], (*numbers)[2]);
  base.alpha = (*numbers)[3];
}

bool is_black(const BaseColour& base) { return base.has_colour && (base.colour.array() <= 0.0).all(); }

// The colour of the light that the material emits, times its strength. None: it emits no light.
std::optional<Vec3> emission_of(const Json& material) {
  const std::optional<Vec3> factor = colour_of(member(material, "emissiveFactor"));
  if (!factor || (factor->array() <= 0.0).all()) return std::nullopt;
  const Json& strength = member(extension_of(material, kStrength), "emissiveStrength");
  return strength.is_number() ? Vec3(strength.get<double>() * *factor) : *factor;
}

BaseColour find_reflected_colour(const Json& material, std::size_t index) {
  const Json& roughness = member(material, "pbrMetallicRoughness");
  const Json& glossiness = extension_of(material, kGlossiness);
  BaseColour base;
  if (!glossiness.is_object() || roughness.contains("baseColorFactor") || roughness.contains("baseColorTexture")) {
    base.where = fmt::format("materials[{}].pbrMetallicRoughness.baseColorTexture", index);
    base.texture = &member(roughness, "baseColorTexture");
    read_factor(member(roughness, "baseColorFactor"), base);
    return base;
  }
  base.where = fmt::format("materials[{}].extensions.{}.diffuseTexture", index, kGlossiness);
  base.texture = &member(glossiness, "diffuseTexture");
  read_factor(member(glossiness, "diffuseFactor"), base);
  if (is_black(base)) base.colour = colour_of(member(glossiness, "specularFactor")).value_or(Vec3::Ones());
  return base;
}

}  // namespace

BaseColour find_base_colour(const Json& material, std::size_t index) {
  BaseColour base = find_reflected_colour(material, index);
  const auto emission = emission_of(material);
  if (!emission || !is_black(base)) return base;
  base.where = fmt::format("materials[{}].emissiveTexture", index);
  base.colour = *emission;
  base.texture = &member(material, "emissiveTexture");
  return base;
}

std::vector<std::string> describe_undrawn_materials(const Json& root) {
  const Json& materials = member(root, "materials");
  std::size_t emitting = 0;
  std::set<std::string> extensions;
  for (std::size_t m = 0; m < size_of_array(materials); ++m) {
    emitting += emission_of(materials[m]) && !is_black(find_reflected_colour(materials[m], m)) ? 1 : 0;
    const Json& used = member(materials[m], "extensions");
    if (!used.is_object()) continue;
    for (const auto& [name, value] : used.items()) {
      if (name.find("_materials_") != std::string::npos && name != kGlossiness && name != kStrength) extensions.insert(printable(name));
    }
  }
  std::vector<std::string> notes;
  if (emitting > 0) notes.push_back(fmt::format("the light that {} materials emit (emissiveFactor) is not drawn", emitting));
  if (!extensions.empty()) notes.push_back(fmt::format("its materials are drawn without {}", fmt::join(extensions, ", ")));
  return notes;
}

}  // namespace hapton::gltf
