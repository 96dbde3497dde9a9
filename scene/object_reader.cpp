#include "scene/object_reader.h"

#include <filesystem>
#include <vector>

#include "scene/accepted_findings.h"
#include "scene/rotation_reader.h"

namespace hapton {

std::string name_of(const ObjectSpec& object) {
  if (!object.name.empty()) return object.name;
  return object.part.empty() ? std::filesystem::path(object.mesh).stem().string() : object.part;
}

void read_scale(TableReader& reader, double& scale) {
  reader.read("scale", scale, 0.0, kMaxScale, true);
  if (!reader.error() && scale < 1.0 / kMaxScale) {
    reader.fail_at("scale", "'scale' in {} is {}: it must be at least {}", reader.where(), scale, 1.0 / kMaxScale);
  }
}

namespace {

// Reads what moves, deforms or carves the object.
Result<void> read_changes(const toml::table& table, const std::string& name, ObjectSpec& spec) {
  auto motion = read_motion(table, name);
  if (!motion) return tl::unexpected(motion.error());
  spec.motion = std::move(*motion);
  auto morphs = read_morphs(table, name);
  if (!morphs) return tl::unexpected(morphs.error());
  spec.morphs = std::move(*morphs);
  const auto program_shape = read_program_shape(table, name);
  if (!program_shape) return tl::unexpected(program_shape.error());
  spec.program_shape = *program_shape;
  auto sculpt = read_sculpt(table, name);
  if (!sculpt) return tl::unexpected(sculpt.error());
  spec.sculpt = *sculpt;
  return {};
}

// The keys of an object, or of the tool, which has a grip but no material.
std::vector<std::string_view> keys_of(const std::string& name) {
  std::vector<std::string_view> keys = {"name",     "mesh",         "part",       "unit",  "scale",
                                        "rotation", "rotation_deg", "position_m", "color", "seal_cracks"};
  if (name == kToolTable) {
    keys.emplace_back("grip");
  } else {
    keys.insert(keys.end(),
                {"material", "group", "movable", "moved_by", "mass_kg", "keyframe", "loop", "pivot_m", "animation", "animation_speed",
                 kAcceptedFindingsKey, "morph", "sculpt", "voxel_mm", "tool_radius_mm", "carve_button", "deformed_by", "reach_m"});
  }
  return keys;
}

void read_mesh_position(TableReader& reader, Vec3& p_SM) {
  std::array<double, 3> position = {};
  reader.read("position_m", position, -kMaxLengthM, kMaxLengthM);
  p_SM = Vec3(position[0], position[1], position[2]);
}

void read_grip(TableReader& reader, ToolGrip& grip) {
  std::string name = "origin";
  reader.read("grip", name);
  if (const auto parsed = parse_tool_grip(name); parsed) {
    grip = *parsed;
  } else {
    reader.fail_at("grip", "{}", parsed.error().what);
  }
}

void read_unit(TableReader& reader, std::optional<Unit>& unit) {
  std::string name;
  reader.read("unit", name);
  if (reader.error() || !reader.has("unit")) return;
  if (const auto parsed = parse_unit(name); parsed) {
    unit = *parsed;
  } else {
    reader.fail_at("unit", "'unit': {}", parsed.error().what);
  }
}

}  // namespace

Result<ObjectSpec> read_object(const toml::table& table, const std::string& name) {
  ObjectSpec spec;
  const auto line_of = [&](std::string_view key) -> std::size_t {
    const toml::node* node = table.get(key);
    return (node == nullptr ? table.source() : node->source()).begin.line;
  };
  spec.mesh_line = line_of("mesh");
  spec.part_line = line_of("part");
  spec.material_line = line_of("material");
  spec.group_line = line_of("group");
  TableReader reader(table, name);
  reader.allow(keys_of(name));
  if (!reader.has("mesh")) reader.fail_at("mesh", "{} has no 'mesh': name its mesh file", name);
  reader.read_name("name", spec.name);
  reader.read("mesh", spec.mesh);
  reader.read("part", spec.part);
  reader.read("material", spec.material);
  reader.read("group", spec.group);
  reader.read("seal_cracks", spec.seal_cracks);
  reader.read("movable", spec.is_movable);
  read_scale(reader, spec.scale);
  reader.read("color", spec.colour, 0.0, 1.0);
  spec.has_colour = reader.has("color");
  read_mesh_position(reader, spec.p_SM);
  if (!reader.error()) read_rotation(table, reader, spec.q_SM);
  read_grip(reader, spec.grip);
  read_unit(reader, spec.unit);
  if (reader.error()) return tl::unexpected(*reader.error());
  if (const auto accepted = read_accepted_findings(table, name); !accepted) return tl::unexpected(accepted.error());
  if (const auto read = read_changes(table, name, spec); !read) return tl::unexpected(read.error());
  if (spec.is_movable && spec.motion.any()) {
    return fail("line {}: {} is movable and moves by itself: keep one", line_of("movable"), name);
  }
  if (spec.is_movable && spec.deforms()) return fail("line {}: {} is movable and deforms: keep one", line_of("movable"), name);
  if (!spec.motion.animation.empty() && spec.deforms()) {
    return fail("line {}: {} plays an animation and has morphs: keep one", line_of("animation"), name);
  }
  return spec;
}

}  // namespace hapton
