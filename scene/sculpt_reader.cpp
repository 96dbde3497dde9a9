#include "scene/sculpt_reader.h"

#include <cmath>

#include "core/base/button_bit.h"
#include "core/geometry/mesh_measures.h"
#include "core/sculpt/carved_field.h"

namespace hapton {
namespace {

constexpr double kMaxMm = 1e6;
constexpr double kMaxButton = 32.0;
// A carve takes time with the cube of its radius: at this limit 27,000 nodes. The ball's points of touch are then 2.6 voxels apart.
constexpr double kMaxVoxelsOfRadius = 12.0;

void read_length(TableReader& reader, const char* key, std::optional<double>& value) {
  if (reader.has(key)) reader.read(key, value.emplace(1.0), 0.0, kMaxMm, true);
}

void read_button(TableReader& reader, const std::string& name, SculptSpec& spec) {
  double button = spec.carve_button;
  reader.read("carve_button", button, 1.0, kMaxButton);
  if (button != std::floor(button)) {
    reader.fail_at("carve_button", "'carve_button' in {} is {}: buttons are counted 1, 2, 3 ...", name, button);
  }
  spec.carve_button = static_cast<int>(button);
}

}  // namespace

Result<SculptSpec> read_sculpt(const toml::table& object, const std::string& name) {
  SculptSpec spec;
  TableReader reader(object, name);
  reader.read("sculpt", spec.is_on);
  read_length(reader, "voxel_mm", spec.voxel_mm);
  read_length(reader, "tool_radius_mm", spec.tool_radius_mm);
  read_button(reader, name, spec);
  for (const char* key : {"voxel_mm", "tool_radius_mm", "carve_button"}) {
    if (reader.has(key) && !spec.is_on) {
      reader.fail_at(key, "'{}' in {} goes with 'sculpt = true': add it, or leave this out", key, name);
    }
  }
  for (const char* key : {"keyframe", "animation", "morph", "moved_by"}) {
    if (spec.is_on && reader.has(key)) reader.fail_at("sculpt", "{} has 'sculpt' and '{}': keep one", name, key);
  }
  if (spec.is_on && object["movable"].value_or(false)) reader.fail_at("sculpt", "{} has 'sculpt' and 'movable': keep one", name);
  if (reader.error()) return tl::unexpected(*reader.error());
  if (const toml::node* node = object.get("sculpt")) spec.line = node->source().begin.line;
  return spec;
}

Result<SculptSettings> make_sculpt(const SculptSpec& spec, const std::string& name, const TriangleMesh& mesh) {
  SculptSettings settings;
  settings.voxel_m = spec.voxel_mm ? 1e-3 * *spec.voxel_mm : compute_bounds(mesh).extent() / SculptSettings::kVoxelsOfSide;
  settings.tool_radius_m = spec.tool_radius_mm ? 1e-3 * *spec.tool_radius_mm : SculptSettings::kVoxelsOfRadius * settings.voxel_m;
  settings.button = button_bit(spec.carve_button);
  const std::string shown = printable(name);
  if (const auto grid = CarvedField::plan(mesh, settings.voxel_m); !grid)
    return fail("'{}' cannot be carved: {}", shown, grid.error().what);
  if (settings.tool_radius_m < SculptSettings::kMinVoxelsOfRadius * settings.voxel_m * (1.0 - 1e-9)) {
    return fail(
        "'{}' is carved with a ball of {:.4g} mm radius in voxels of {:.4g} mm: give a radius of {:.4g} mm or more, or voxel_mm = {:.4g}",
        shown, 1e3 * settings.tool_radius_m, 1e3 * settings.voxel_m, 1e3 * SculptSettings::kMinVoxelsOfRadius * settings.voxel_m,
        1e3 * settings.tool_radius_m / SculptSettings::kVoxelsOfRadius);
  }
  if (settings.tool_radius_m > kMaxVoxelsOfRadius * settings.voxel_m * (1.0 + 1e-9)) {
    return fail(
        "'{}' is carved with a ball of {:.4g} mm radius in voxels of {:.4g} mm: give a radius of {:.4g} mm or less, or larger voxels",
        shown, 1e3 * settings.tool_radius_m, 1e3 * settings.voxel_m, 1e3 * kMaxVoxelsOfRadius * settings.voxel_m);
  }
  return settings;
}

}  // namespace hapton
