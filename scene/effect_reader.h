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

// Reads these keys, and the [[material.NAME.layer]] tables. Errors: values out of range; a key of an effect that is off; effects that
// exclude each other, or a key of the material. An error of a layer's table is returned; all others are in reader.error(). RT: set-up only.
Result<void> read_surface_effects(const toml::table& table, const std::string& material_name, const Material& material, TableReader& reader,
                                  SurfaceEffects& effects);

// One [[effect]] table.
struct EffectSpec {
  std::string name;  // default: its type
  SpaceEffect effect;
  EffectSwitch on = {};
  std::string object;           // the effect is placed at this object's centre, or in its box; empty: its own keys place it
  std::size_t object_line = 0;  // line of the key `object` in the scene file
};

// number: its place among the [[effect]] tables, counted from 1. Error, one line: a value out of range, an unknown type, a key of another
// type. RT: set-up only.
Result<EffectSpec> read_space_effect(const toml::table& table, std::size_t number);

// Whether an [[effect]] table is a plug-in. RT: set-up only, as is read_library_effect.
bool is_library_effect(const toml::table& table);

// number: as above. Error, one line as for other effects: no library, an unknown key, a parameter that is not a text, number or boolean,
// or that has a comma, because the flag --effect could not have it.
Result<LibraryEffect> read_library_effect(const toml::table& table, std::size_t number);

// Moves an effect to an object with the box from low to high: its centre becomes that of the box, or its volume becomes the box. Frame: S.
void place_at_object(SpaceEffect& effect, const Vec3& low, const Vec3& high);

}  // namespace hapton
