#include "scene/read_mtl.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "scene/file_bytes.h"
#include "scene/text_cursor.h"

namespace hapton {
namespace {

constexpr std::size_t kMaxImageBytes = std::size_t{1} << 28;

LookMaterial* find_material(MeshLook& look, std::string_view name) {
  const auto found =
      std::find_if(look.materials.begin(), look.materials.end(), [&](const LookMaterial& each) { return each.name == name; });
  return found == look.materials.end() ? nullptr : &*found;
}

std::optional<Eigen::Vector3f> read_colour(TextCursor& cursor) {
  Eigen::Vector3f colour;
  for (int channel = 0; channel < 3; ++channel) {
    double value = 0.0;
    if (!parse_number(cursor.word_in_line(), value) || !std::isfinite(value)) return std::nullopt;
    colour[channel] = static_cast<float>(std::clamp(value, 0.0, 1.0));
  }
  return colour;
}

// After options such as "-s 1 1 1" the name is the last word; without, it may have blanks in it.
std::string read_image_name(TextCursor& cursor) {
  std::string name(cursor.rest_of_line());
  if (name.starts_with('-')) name = name.substr(name.find_last_of(" \t") + 1);
  std::replace(name.begin(), name.end(), '\\', '/');
  return name;
}

}  // namespace

std::optional<std::size_t> add_image_file(const std::filesystem::path& file, RawMesh& raw) {
  auto& images = raw.look.images;
  const std::string name = file.string();
  const auto known = std::find_if(images.begin(), images.end(), [&](const LookImage& image) { return image.name == name; });
  if (known != images.end()) return static_cast<std::size_t>(known - images.begin());
  Result<std::string> bytes = read_file_bytes(file, kMaxImageBytes);
  if (!bytes) {
    raw.notes.push_back(fmt::format("a texture is missing: '{}' cannot be read", printable(file.filename().string())));
    return std::nullopt;
  }
  images.push_back({name, std::move(*bytes)});
  return images.size() - 1;
}

void read_mtl(std::string_view bytes, const std::filesystem::path& folder, RawMesh& raw) {
  LookMaterial* material = nullptr;
  for (TextCursor cursor(bytes); !cursor.at_end(); cursor.next_line()) {
    const std::string_view keyword = cursor.word_in_line();
    if (keyword == "newmtl") material = find_material(raw.look, cursor.rest_of_line());
    if (material == nullptr) continue;
    if (keyword == "Kd" && !material->image) material->colour = read_colour(cursor);
    if (keyword != "map_Kd") continue;
    material->image = add_image_file(folder / read_image_name(cursor), raw);
    if (material->image) material->colour.reset();
  }
}

}  // namespace hapton
