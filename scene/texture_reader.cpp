#include "scene/texture_reader.h"

#include <array>
#include <utility>

#include "core/effects/bounded_force.h"
#include "scene/texture_file.h"

namespace hapton {
namespace {

constexpr double kMaxTextureMassKg = 5.0;
constexpr std::array<std::string_view, 3> kTextureKeys = {"recorded_texture", "texture_mass_kg", "texture_max_force_n"};

}  // namespace

std::span<const std::string_view> texture_keys() { return kTextureKeys; }

void read_texture(const toml::table& table, TableReader& reader, RecordedTexture& texture, TextureSpec& spec) {
  reader.read("recorded_texture", spec.file);
  reader.read("texture_mass_kg", texture.mass_kg, 0.0, kMaxTextureMassKg, true);
  reader.read("texture_max_force_n", texture.max_force_n, 0.0, kMaxEffectForceN, true);
  if (!reader.has("recorded_texture")) {
    for (const char* key : {"texture_mass_kg", "texture_max_force_n"}) {
      if (reader.has(key)) reader.fail_at(key, "'{}' has no effect without 'recorded_texture'", key);
    }
    return;
  }
  spec.where = fmt::format("line {}", table.get("recorded_texture")->source().begin.line);
  if (spec.file.empty()) reader.fail_at("recorded_texture", "'recorded_texture' is empty: name a file with texture models, XML");
}

Result<std::shared_ptr<const TextureModels>> TextureCache::find(const TextureSpec& spec) {
  if (spec.file.empty()) return nullptr;
  if (const auto known = models_.find(spec.file); known != models_.end()) return known->second;
  auto read = read_texture_file((folder_ / spec.file).lexically_normal());
  if (!read) return fail("{}: 'recorded_texture': {}", spec.where, read.error().what);
  return models_.emplace(spec.file, std::make_shared<const TextureModels>(std::move(*read))).first->second;
}

}  // namespace hapton
