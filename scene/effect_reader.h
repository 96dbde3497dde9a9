#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/effects/space_effect.h"
#include "core/effects/surface_effects.h"
#include "core/force/touch_scene.h"
#include "scene/library_effect.h"
#include "scene/table_reader.h"

namespace hapton {

// The keys of [material.NAME] that describe surface effects. docs/effects.md has each with its range.
std::span<const std::string_view> surface_effect_keys();

// Reads them, and the [[material.NAME.layer]] tables. An error stays in the reader, or comes back where it is in a table of its own: values
// out of range, a key whose effect is off, effects that exclude each other or the material. RT: set-up only.
Result<void> read_surface_effects(const toml::table& table, const std::string& material_name, const Material& material, TableReader& reader,
                                  SurfaceEffects& effects);

// One [[effect]] table.
struct EffectSpec {
  std::string name;  // default: its type
  SpaceEffect effect;
  EffectSwitch on = {};
  std::string object;           // placed by this object: at its centre, or in its box; empty: by its own keys
  std::size_t object_line = 0;  // in the scene file
};

// number: its place in the file, from 1. Error: as above; an unknown type; a key that is not this type's.
Result<EffectSpec> read_space_effect(const toml::table& table, std::size_t number);

// Whether an [[effect]] table is a plug-in. RT: set-up only, like the next.
bool is_library_effect(const toml::table& table);

// number: its place in the file, from 1. Error: one line, as for other effects: a missing library, an unknown key, a parameter that is no
// text, number or boolean, or has a comma, which no command line could repeat.
Result<LibraryEffect> read_library_effect(const toml::table& table, std::size_t number);

// Moves an effect to an object: its centre becomes that of the object's box, its volume that box. Frame: S.
void place_at_object(SpaceEffect& effect, const Vec3& low, const Vec3& high);

}  // namespace hapton
