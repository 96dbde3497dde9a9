#include "scene/keyframe_reader.h"

#include "scene/object_reader.h"
#include "scene/rotation_reader.h"

namespace hapton {
namespace {

constexpr double kMaxTimeS = 86400.0;  // a day
// Masses that a hand can push on a desk: a lighter body would follow a stylus as if it had no mass, a heavier one would not move.
constexpr double kMinMassKg = 0.001;
constexpr double kMaxMassKg = 100.0;

Result<KeyframeSpec> read_keyframe(const toml::table& table, const std::string& where) {
  KeyframeSpec spec;
  spec.line = table.source().begin.line;
  TableReader reader(table, where);
  reader.allow({"time_s", "position_m", "rotation_deg", "rotation"});
  reader.require("time_s");
  reader.read("time_s", spec.time_s, 0.0, kMaxTimeS);
  if (reader.has("position_m")) reader.read("position_m", spec.p_SM.emplace(Vec3::Zero()), kMaxLengthM);
  Quat q = Quat::Identity();
  if (!reader.error()) read_rotation(table, reader, q);
  if (reader.has("rotation") || reader.has("rotation_deg")) spec.q_SM = q;
  if (reader.error()) return tl::unexpected(*reader.error());
  return spec;
}

Result<std::vector<KeyframeSpec>> read_keyframes(const toml::node& node, const std::string& name) {
  const toml::array* tables = node.as_array();
  if (tables == nullptr || !tables->is_array_of_tables()) {
    return fail("{}'keyframe' in {} must be tables that begin with [[object.keyframe]]", line_prefix(node), name);
  }
  std::vector<KeyframeSpec> keyframes;
  for (const toml::node& table : *tables) {
    auto read = read_keyframe(*table.as_table(), fmt::format("keyframe {} of {}", keyframes.size() + 1, name));
    if (!read) return tl::unexpected(read.error());
    if (!keyframes.empty() && !(read->time_s > keyframes.back().time_s)) {
      return fail("{}keyframe {} of {} is at {} s, the one before at {} s: times must increase", line_prefix(table), keyframes.size() + 1,
                  name, read->time_s, keyframes.back().time_s);
    }
    keyframes.push_back(*read);
  }
  if (keyframes.size() < 2) return fail("{}{} has one keyframe: a motion needs two or more", line_prefix(node), name);
  return keyframes;
}

void read_moved_by(const toml::table& object, TableReader& reader, const std::string& name, MotionSpec& spec) {
  std::string by;
  reader.read("moved_by", by);
  if (!reader.has("moved_by")) return;
  spec.by_program = by == "program";
  if (!spec.by_program) {
    reader.fail_at("moved_by", "'moved_by' in {} is '{}': it may be \"program\"; what the stylus picks up has 'movable = true'", name,
                   printable(by));
  }
  for (const char* key : {"keyframe", "animation", "morph"}) {
    if (object.contains(key)) reader.fail_at("moved_by", "{} has 'moved_by' and '{}': keep one", name, key);
  }
  if (object["movable"].value_or(false)) reader.fail_at("moved_by", "{} has 'moved_by' and 'movable': keep one", name);
}

}  // namespace

Result<MotionSpec> read_motion(const toml::table& object, const std::string& name) {
  MotionSpec spec;
  TableReader reader(object, name);
  reader.read("loop", spec.loops);
  reader.read("pivot_m", spec.p_MP, kMaxLengthM);
  reader.read("animation", spec.animation);
  reader.read("animation_speed", spec.animation_speed, 1e-6, 1e6);
  read_moved_by(object, reader, name, spec);
  reader.read("mass_kg", spec.mass_kg, kMinMassKg, kMaxMassKg);
  if (reader.has("mass_kg") && !spec.by_program) {
    reader.fail_at("mass_kg", "'mass_kg' in {} goes with 'moved_by = \"program\"': add it, or leave this out", name);
  }
  const toml::node* keyframes = object.get("keyframe");
  const toml::node* animation = object.get("animation");
  if (animation != nullptr) spec.animation_line = animation->source().begin.line;
  if (animation != nullptr && keyframes != nullptr) reader.fail_at("animation", "{} has an animation and keyframes: keep one", name);
  if (animation != nullptr && spec.animation.empty()) reader.fail_at("animation", "'animation' in {} is empty: name one of the file", name);
  if (animation == nullptr && reader.has("animation_speed")) {
    reader.fail_at("animation_speed", "'animation_speed' in {} goes with 'animation': add it, or leave this out", name);
  }
  if (keyframes == nullptr && !spec.by_program && reader.has("pivot_m")) {
    reader.fail_at("pivot_m", "'pivot_m' in {} goes with keyframes or 'moved_by': add one of them, or leave it out", name);
  }
  if (keyframes == nullptr && animation == nullptr && object.get("morph") == nullptr && reader.has("loop")) {
    reader.fail_at("loop",
                   "'loop' in {} goes with keyframes or morphs: add [[object.keyframe]] or [[object.morph]] tables, or leave it out", name);
  }
  if (reader.error()) return tl::unexpected(*reader.error());
  if (keyframes == nullptr) return spec;
  auto read = read_keyframes(*keyframes, name);
  if (!read) return tl::unexpected(read.error());
  spec.keyframes = std::move(*read);
  return spec;
}

}  // namespace hapton
