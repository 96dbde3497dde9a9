#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/effects/recorded_texture.h"
#include "core/effects/texture_models.h"
#include "scene/table_reader.h"

namespace hapton {

// The file with the models of a material's recorded texture.
struct TextureSpec {
  std::string file = {};   // name of the file, relative to the scene file; empty: none
  std::string where = {};  // place of the key that errors name: "line 7"
};

// The keys of [material.NAME] for recorded textures. docs/effects.md describes each of them and its range.
std::span<const std::string_view> texture_keys();

// Reads these keys, but not the file. The reader keeps the error: values out of range, a key without the file. RT: set-up only.
void read_texture(const toml::table& table, TableReader& reader, RecordedTexture& texture, TextureSpec& spec);

// Reads the models of textures, each file once. RT: set-up only.
class TextureCache {
 public:
  explicit TextureCache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  // The models of a material's texture; null if it has none. Error: as read_texture_file, with the line in the scene file.
  Result<std::shared_ptr<const TextureModels>> find(const TextureSpec& spec);

 private:
  std::filesystem::path folder_;
  std::map<std::string, std::shared_ptr<const TextureModels>> models_;  // by file
};

}  // namespace hapton
