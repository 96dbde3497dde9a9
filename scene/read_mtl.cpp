#include "scene/read_mtl.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "scene/file_bytes.h"
#include "scene/text_cursor.h"

namespace hapton {
namespace {

constexpr std::size_t kMaxImageBytes = std::size_t{1} << 28;

VisualMaterial* find_material(MeshAppearance& appearance, std::string_view name) {
  const auto found =
      std::find_if(appearance.materials.begin(), appearance.materials.end(), [&](const VisualMaterial& each) { return each.name == name; });
  return found == appearance.materials.end() ? nullptr : &*found;
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

// Reads the number of "d 0.4", "d -halo 0.4" or "Tr 0.6". None: not a number.
std::optional<float> read_share(TextCursor& cursor) {
  std::string_view word = cursor.word_in_line();
  if (word == "-halo") word = cursor.word_in_line();
  double value = 0.0;
  if (!parse_number(word, value) || !std::isfinite(value)) return std::nullopt;
  return static_cast<float>(std::clamp(value, 0.0, 1.0));
}

// Sets the opacity, 0 to 1. A material that is not fully opaque is blended.
void set_opacity(VisualMaterial& material, float opacity) {
  material.alpha = opacity;
  material.alpha_mode = opacity < 1.0F ? AlphaMode::blend : AlphaMode::opaque;
}

// Whether the keyword names an image of heights or normals.
bool is_bump_map(std::string_view keyword) {
  constexpr std::array<std::string_view, 6> kNames = {"map_Bump", "map_bump", "bump", "norm", "map_Kn", "disp"};
  return std::find(kNames.begin(), kNames.end(), keyword) != kNames.end();
}

struct ImageLine {
  std::string name;
  TextureWrap wrap = TextureWrap::repeat;
  Eigen::Vector2f scale = Eigen::Vector2f::Ones();  // options -s and -o: the place in the image is scale (u, v) + shift, v upwards
  Eigen::Vector2f shift = Eigen::Vector2f::Zero();
};

// Takes the next number only if a word follows it, because the last word is the name of the image.
bool take_number(TextCursor& options, double& value) {
  TextCursor ahead = options;
  if (!parse_number(ahead.word_in_line(), value) || TextCursor(ahead).word_in_line().empty()) return false;
  options = ahead;
  return true;
}

// Reads "u [v [w]]" after -s or -o. The numbers that are left out stay as they are; w is for images with depth, and is ignored.
// False: there is no number.
bool read_pair(TextCursor& options, Eigen::Vector2f& pair) {
  double value = 0.0;
  int count = 0;
  for (; count < 3 && take_number(options, value); ++count) {
    if (count < 2 && std::isfinite(value)) pair[count] = static_cast<float>(value);
  }
  return count > 0;
}

// Reads the values of an option of an image. False: the option is unknown, or its values are not valid.
bool read_option(std::string_view option, TextCursor& options, ImageLine& line) {
  constexpr std::array<std::string_view, 7> kOneWord = {"-blendu", "-blendv", "-cc", "-boost", "-texres", "-imfchan", "-type"};
  double ignored = 0.0;
  if (option == "-clamp") {
    line.wrap = options.word_in_line() == "on" ? TextureWrap::clamp : TextureWrap::repeat;
  } else if (option == "-s" || option == "-o") {
    return read_pair(options, option == "-s" ? line.scale : line.shift);
  } else if (option == "-t" || option == "-mm" || option == "-bm") {  // at most three numbers, two or one
    for (int k = option == "-t" ? 3 : option == "-mm" ? 2 : 1; k > 0 && take_number(options, ignored);) --k;
  } else if (std::find(kOneWord.begin(), kOneWord.end(), option) != kOneWord.end()) {
    (void)options.word_in_line();
  } else {
    return false;
  }
  return true;
}

// All that follows options such as "-s 1 1 1" is the name of the image, including blanks. After an option that is unknown or not valid, the
// last word is the name. The name may have quotes around it.
ImageLine read_image_line(TextCursor& cursor) {
  ImageLine line;
  std::string_view name = cursor.rest_of_line();
  while (name.starts_with('-')) {
    TextCursor options(name);
    const bool is_known = read_option(options.word_in_line(), options, line);
    const std::string_view rest = is_known ? options.rest_of_line() : std::string_view();
    name = rest.empty() ? name.substr(name.find_last_of(" \t") + 1) : rest;
    if (rest.empty()) break;
  }
  line.name = without_quotes(name);
  std::replace(line.name.begin(), line.name.end(), '\\', '/');
  return line;
}

// A file that was written on another machine may name folders of that machine, so the image is also searched beside the mesh.
std::filesystem::path find_image(const std::filesystem::path& folder, const std::string& name) {
  const std::filesystem::path given = folder / name;
  std::error_code ignored;
  if (std::filesystem::exists(given, ignored)) return given;
  const std::filesystem::path beside = folder / std::filesystem::path(name).filename();
  return std::filesystem::exists(beside, ignored) ? beside : given;
}

// Texture coordinates count downwards, the MTL file's v upwards: down = 1 - v.
void place_image(const ImageLine& line, VisualMaterial& material) {
  material.wrap = {line.wrap, line.wrap};
  material.image_scale = line.scale;
  material.image_shift = {line.shift.x(), 1.0F - line.scale.y() - line.shift.y()};
}

}  // namespace

std::string_view without_quotes(std::string_view name) {
  const bool has_quotes = name.size() > 1 && name.front() == name.back() && (name.front() == '"' || name.front() == '\'');
  return has_quotes ? name.substr(1, name.size() - 2) : name;
}

std::optional<std::size_t> add_image_file(const std::filesystem::path& file, RawMesh& raw) {
  auto& images = raw.appearance.images;
  const std::string name = file.string();
  const auto known = std::find_if(images.begin(), images.end(), [&](const TextureImage& image) { return image.name == name; });
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
  VisualMaterial* material = nullptr;
  bool has_d = false;
  std::size_t bump_maps = 0;
  std::set<const VisualMaterial*> emitting;
  for (TextCursor cursor(without_byte_order_mark(bytes)); !cursor.at_end(); cursor.next_line()) {
    const std::string_view keyword = cursor.word_in_line();
    if (keyword == "newmtl") {
      const std::string name(cursor.rest_of_line());
      raw.mtl_materials.insert(name);
      material = find_material(raw.appearance, name);
      has_d = false;
    }
    if (material == nullptr) continue;
    if (keyword == "d" || (keyword == "Tr" && !has_d)) {
      const auto share = read_share(cursor);
      if (share) set_opacity(*material, keyword == "d" ? *share : 1.0F - *share);
      has_d = has_d || (share && keyword == "d");
    }
    if (keyword == "Kd") (material->image ? material->colour_no_image : material->colour) = read_colour(cursor);
    if (keyword == "map_Ke" || (keyword == "Ke" && !read_colour(cursor).value_or(Eigen::Vector3f::Zero()).isZero(0.0F))) {
      emitting.insert(material);
    }
    bump_maps += is_bump_map(keyword) ? 1 : 0;
    if (keyword != "map_Kd") continue;
    const ImageLine line = read_image_line(cursor);
    material->image = add_image_file(find_image(folder, line.name), raw);
    place_image(line, *material);
    if (material->image) material->colour_no_image = std::exchange(material->colour, std::nullopt);
  }
  if (!emitting.empty()) raw.notes.push_back(fmt::format("the light that {} materials emit (Ke, map_Ke) is not drawn", emitting.size()));
  if (bump_maps > 0) {
    raw.notes.push_back(
        fmt::format("{} images of bumps or normals are neither drawn nor felt: for bumps give the object a material with bump_map, an "
                    "image of heights, or "
                    "with normal_map",
                    bump_maps));
  }
}

}  // namespace hapton
