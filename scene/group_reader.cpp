#include "scene/group_reader.h"

#include "scene/object_reader.h"
#include "scene/rotation_reader.h"

namespace hapton {
namespace {

// The name of a group is put before those of its objects: long ones would be hard to read, and too long to be sent over the link.
constexpr std::size_t kLongestName = 60;

std::size_t line_of_key(const toml::table& table, std::string_view key) {
  const toml::node* node = table.get(key);
  return (node == nullptr ? table.source() : node->source()).begin.line;
}

void read_group_name(TableReader& reader, const std::string& where, std::string& name) {
  reader.require("name");
  reader.read_name("name", name);
  if (reader.error()) return;
  if (name.empty() || name.size() > kLongestName) {
    reader.fail_at("name", "'name' in {} has {} bytes: give 1 to {}", where, name.size(), kLongestName);
  }
  if (name.find('/') != std::string::npos) {
    reader.fail_at("name", "'name' in {} is '{}': it may not contain '/', which stands between a group and its objects", where,
                   printable(name));
  }
}

void read_given_pose(const toml::table& table, TableReader& reader, GroupSpec& spec) {
  if (reader.has("scale")) read_scale(reader, spec.scale.emplace(1.0));
  if (reader.has("position_m")) reader.read("position_m", spec.p.emplace(Vec3::Zero()), kMaxLengthM);
  if (!reader.error() && (reader.has("rotation") || reader.has("rotation_deg"))) {
    read_rotation(table, reader, spec.q.emplace(Quat::Identity()));
  }
}

Result<GroupSpec> read_group(const toml::table& table, bool is_instance, const std::string& where) {
  GroupSpec spec;
  spec.line = table.source().begin.line;
  spec.of_line = line_of_key(table, "of");
  spec.group_line = line_of_key(table, "group");
  spec.material_line = line_of_key(table, "material");
  TableReader reader(table, where);
  std::vector<std::string_view> keys = {"name", "group", "position_m", "rotation_deg", "rotation", "scale", "material", "color"};
  if (is_instance) keys.insert(keys.begin() + 1, "of");
  reader.allow(keys);
  read_group_name(reader, where, spec.name);
  if (is_instance) reader.require("of");
  reader.read("of", spec.of);
  reader.read("group", spec.group);
  reader.read("material", spec.material);
  read_given_pose(table, reader, spec);
  if (reader.has("color")) reader.read("color", spec.colour.emplace(), 0.0, 1.0);
  if (reader.error()) return tl::unexpected(*reader.error());
  return spec;
}

Result<std::vector<GroupSpec>> read_tables(const toml::table& scene, std::string_view key, bool is_instance) {
  std::vector<GroupSpec> specs;
  const toml::node* node = scene.get(key);
  if (node == nullptr) return specs;
  const toml::array* tables = node->as_array();
  if (tables == nullptr || !tables->is_array_of_tables()) {
    return fail("{}'{}' must be tables that begin with [[{}]]", line_prefix(*node), key, key);
  }
  for (const toml::node& table : *tables) {
    auto spec = read_group(*table.as_table(), is_instance, fmt::format("[[{}]] {}", key, specs.size() + 1));
    if (!spec) return tl::unexpected(spec.error());
    specs.push_back(std::move(*spec));
  }
  return specs;
}

}  // namespace

Result<std::vector<GroupSpec>> read_groups(const toml::table& scene) { return read_tables(scene, "group", false); }

Result<std::vector<GroupSpec>> read_instances(const toml::table& scene) { return read_tables(scene, "instance", true); }

}  // namespace hapton
