#include "scene/object_reader.h"

#include <cmath>
#include <numbers>
#include <vector>

namespace hapton {
namespace {

constexpr double kMaxScale = 1e9;

// rotation: a unit quaternion w, x, y, z. rotation_deg: about the fixed x axis, then y, then z.
void read_rotation(const toml::table& table, TableReader& reader, Quat& q_SM) {
  if (table.contains("rotation") && table.contains("rotation_deg")) {
    return reader.fail_at("rotation_deg", "both 'rotation' and 'rotation_deg' are given: keep one");
  }
  std::array<double, 4> wxyz = {1, 0, 0, 0};
  reader.read("rotation", wxyz, -2.0, 2.0);
  const Quat given(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  if (std::abs(given.norm() - 1.0) > 1e-3) {
    return reader.fail_at("rotation", "'rotation' has length {:.6g}: a rotation is a quaternion [w, x, y, z] of length 1", given.norm());
  }
  std::array<double, 3> degrees = {};
  reader.read("rotation_deg", degrees, -360.0, 360.0);
  Quat turned = Quat::Identity();
  for (int axis = 0; axis < 3; ++axis) {
    turned = Eigen::AngleAxisd(degrees[axis] * std::numbers::pi / 180.0, Vec3::Unit(axis)) * turned;
  }
  q_SM = given.normalized() * turned;
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
  TableReader reader(table, name);
  // A tool has a grip, and no material yet.
  std::vector<std::string_view> keys = {"name",     "mesh",         "part",       "unit",  "scale",
                                        "rotation", "rotation_deg", "position_m", "color", "seal_cracks"};
  if (name == kToolTable) {
    keys.emplace_back("grip");
  } else {
    keys.insert(keys.end(), {"material", "movable"});
  }
  reader.allow(keys);
  if (!reader.has("mesh")) reader.fail_at("mesh", "{} has no 'mesh': name its mesh file", name);
  reader.read("name", spec.name);
  reader.read("mesh", spec.mesh);
  reader.read("part", spec.part);
  reader.read("material", spec.material);
  reader.read("seal_cracks", spec.seal_cracks);
  reader.read("movable", spec.is_movable);
  reader.read("scale", spec.scale, 0.0, kMaxScale, true);
  reader.read("color", spec.colour, 0.0, 1.0);
  spec.has_colour = reader.has("color");
  std::array<double, 3> position = {};
  reader.read("position_m", position, -kMaxLengthM, kMaxLengthM);
  spec.p_SM = Vec3(position[0], position[1], position[2]);
  if (!reader.error()) read_rotation(table, reader, spec.q_SM);
  std::string grip = "origin";
  reader.read("grip", grip);
  if (const auto parsed = parse_tool_grip(grip); parsed) {
    spec.grip = *parsed;
  } else {
    reader.fail_at("grip", "{}", parsed.error().what);
  }
  std::string unit;
  reader.read("unit", unit);
  if (!reader.error() && reader.has("unit")) {
    const Result<Unit> parsed = parse_unit(unit);
    if (parsed)
      spec.unit = *parsed;
    else
      reader.fail_at("unit", "{}", parsed.error().what);
  }
  if (reader.error()) return tl::unexpected(*reader.error());
  return spec;
}

}  // namespace hapton
