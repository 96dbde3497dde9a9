#include "scene/morph_reader.h"

#include "core/geometry/mesh_deformation.h"
#include "scene/object_reader.h"

namespace hapton {
namespace {

constexpr double kLatestKeyS = 86400.0;  // a day
constexpr double kMaxWeight = 1e3;
constexpr double kMaxStretch = 1e3;

Result<std::vector<MorphSpec::Key>> read_keys(const toml::node& node, const std::string& where) {
  const auto wrong = [&](const toml::node& at) {
    return fail("{}'keys' in {} must be pairs of a time in s and a weight, two or more, as [[0.0, 0.0], [0.5, 1.0]]", line_prefix(at),
                where);
  };
  std::vector<MorphSpec::Key> keys;
  const toml::array* pairs = node.as_array();
  if (pairs == nullptr || pairs->size() < 2) return wrong(node);
  for (const toml::node& each : *pairs) {
    const toml::array* pair = each.as_array();
    if (pair == nullptr || pair->size() != 2) return wrong(each);
    const auto time = pair->get(0)->value<double>();
    const auto weight = pair->get(1)->value<double>();
    if (!time || !weight || !pair->get(0)->is_number() || !pair->get(1)->is_number()) return wrong(each);
    if (!(*time >= 0.0 && *time <= kLatestKeyS)) {
      return fail("{}a time in 'keys' of {} is {} s: give 0 to {:g}", line_prefix(each), where, *time, kLatestKeyS);
    }
    if (!(*weight >= -kMaxWeight && *weight <= kMaxWeight)) {
      return fail("{}a weight in 'keys' of {} is {}: give {:g} to {:g}", line_prefix(each), where, *weight, -kMaxWeight, kMaxWeight);
    }
    if (!keys.empty() && !(*time > keys.back().time_s)) {
      return fail("{}the times in 'keys' of {} must increase: {} s comes after {} s", line_prefix(each), where, *time, keys.back().time_s);
    }
    keys.push_back({*time, *weight});
  }
  return keys;
}

Result<MorphSpec> read_morph(const toml::table& table, const std::string& where) {
  MorphSpec spec;
  spec.line = table.source().begin.line;
  TableReader reader(table, where);
  reader.allow({"push_m", "stretch", "center_m", "radius_m", "keys"});
  if (reader.has("push_m")) reader.read("push_m", spec.push_m.emplace(Vec3::Zero()), kMaxLengthM);
  if (reader.has("stretch")) {
    std::array<double, 3> stretch = {};
    reader.read("stretch", stretch, 0.0, kMaxStretch);
    spec.stretch = Vec3(stretch[0], stretch[1], stretch[2]);
  }
  if (!spec.push_m && !spec.stretch) reader.fail_at("push_m", "{} has neither 'push_m' nor 'stretch': add one", where);
  if (spec.push_m && spec.stretch) reader.fail_at("stretch", "{} has 'push_m' and 'stretch': make two [[object.morph]] of it", where);
  reader.read("center_m", spec.centre_m, kMaxLengthM);
  if (reader.has("radius_m")) reader.read("radius_m", spec.radius_m.emplace(0.0), 0.0, kMaxLengthM, true);
  reader.require("keys");
  if (reader.error()) return tl::unexpected(*reader.error());
  auto keys = read_keys(*table.get("keys"), where);
  if (!keys) return tl::unexpected(keys.error());
  spec.keys = std::move(*keys);
  return spec;
}

}  // namespace

Result<std::vector<MorphSpec>> read_morphs(const toml::table& object, const std::string& name) {
  std::vector<MorphSpec> morphs;
  const toml::node* node = object.get("morph");
  if (node == nullptr) return morphs;
  const toml::array* tables = node->as_array();
  if (tables == nullptr || !tables->is_array_of_tables()) {
    return fail("{}'morph' in {} must be tables that begin with [[object.morph]]", line_prefix(*node), name);
  }
  for (const toml::node& table : *tables) {
    auto morph = read_morph(*table.as_table(), fmt::format("morph {} of {}", morphs.size() + 1, name));
    if (!morph) return tl::unexpected(morph.error());
    morphs.push_back(std::move(*morph));
  }
  if (morphs.size() > MeshDeformation::kMaxTargets) {
    return fail("{}{} has {} morphs: at most {}", line_prefix(*node), name, morphs.size(), MeshDeformation::kMaxTargets);
  }
  return morphs;
}

}  // namespace hapton
