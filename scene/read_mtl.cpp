#include "scene/read_mtl.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

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

// "d 0.4", "d -halo 0.4" or "Tr 0.6". None: not a number.
std::optional<float> read_share(TextCursor& cursor) {
  std::string_view word = cursor.word_in_line();
  if (word == "-halo") word = cursor.word_in_line();
  double value = 0.0;
  if (!parse_number(word, value) || !std::isfinite(value)) return std::nullopt;
  return static_cast<float>(std::clamp(value, 0.0, 1.0));
}

// Opacity 0 to 1; what is not fully opaque is blended.
void set_opacity(LookMaterial& material, float opacity) {
  material.alpha = opacity;
  material.alpha_mode = opacity < 1.0F ? AlphaMode::blend : AlphaMode::opaque;
}

// An image of heights or normals, by its usual names.
bool is_bump_map(std::string_view keyword) {
  constexpr std::array<std::string_view, 6> kNames = {"map_Bump", "map_bump", "bump", "norm", "map_Kn", "disp"};
  return std::find(kNames.begin(), kNames.end(), keyword) != kNames.end();
}

struct ImageLine {
  std::string name;
  TextureWrap wrap = TextureWrap::repeat;
  Eigen::Vector2f scale = Eigen::Vector2f::Ones();  // -s and -o, u and v, v upwards: u of the image = scale u + shift
  Eigen::Vector2f shift = Eigen::Vector2f::Zero();
};

// "u [v [w]]" of -s and -o. The numbers that are left out stay as they are; w is of images with depth.
void read_pair(TextCursor& options, Eigen::Vector2f& pair) {
  for (int k = 0; k < 3; ++k) {
    TextCursor ahead = options;
    double value = 0.0;
    if (!parse_number(ahead.word_in_line(), value)) return;
    if (k < 2 && std::isfinite(value)) pair[k] = static_cast<float>(value);
    options = ahead;
  }
}

// After options such as "-s 1 1 1" the name is the last word; without, it may have blanks in it.
ImageLine read_image_line(TextCursor& cursor) {
  ImageLine line;
  line.name = cursor.rest_of_line();
  if (line.name.starts_with('-')) {
    TextCursor options(line.name);
    for (std::string_view word = options.word_in_line(); !word.empty(); word = options.word_in_line()) {
      if (word == "-clamp") line.wrap = options.word_in_line() == "on" ? TextureWrap::clamp : TextureWrap::repeat;
      if (word == "-s") read_pair(options, line.scale);
      if (word == "-o") read_pair(options, line.shift);
    }
    line.name = line.name.substr(line.name.find_last_of(" \t") + 1);
  }
  std::replace(line.name.begin(), line.name.end(), '\\', '/');
  return line;
}

// Texcoords count downwards: down = 1 - v.
void place_image(const ImageLine& line, LookMaterial& material) {
  material.wrap = {line.wrap, line.wrap};
  material.image_scale = line.scale;
  material.image_shift = {line.shift.x(), 1.0F - line.scale.y() - line.shift.y()};
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
  bool has_d = false;
  std::size_t bump_maps = 0;
  for (TextCursor cursor(bytes); !cursor.at_end(); cursor.next_line()) {
    const std::string_view keyword = cursor.word_in_line();
    if (keyword == "newmtl") {
      const std::string name(cursor.rest_of_line());
      raw.mtl_materials.insert(name);
      material = find_material(raw.look, name);
      has_d = false;
    }
    if (material == nullptr) continue;
    if (keyword == "d" || (keyword == "Tr" && !has_d)) {
      const auto share = read_share(cursor);
      if (share) set_opacity(*material, keyword == "d" ? *share : 1.0F - *share);
      has_d = has_d || (share && keyword == "d");
    }
    if (keyword == "Kd") (material->image ? material->colour_no_image : material->colour) = read_colour(cursor);
    bump_maps += is_bump_map(keyword) ? 1 : 0;
    if (keyword != "map_Kd") continue;
    const ImageLine line = read_image_line(cursor);
    material->image = add_image_file(folder / line.name, raw);
    place_image(line, *material);
    if (material->image) material->colour_no_image = std::exchange(material->colour, std::nullopt);
  }
  if (bump_maps > 0) {
    raw.notes.push_back(
        fmt::format("{} images of bumps or normals are neither drawn nor felt: for bumps give the object a material with bump_map, an "
                    "image of heights, or "
                    "with normal_map",
                    bump_maps));
  }
}

}  // namespace hapton
