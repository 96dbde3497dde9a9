#include "scene/gltf/materials.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "scene/gltf/base_colour.h"
#include "scene/gltf/uri.h"
#include "scene/read_mtl.h"
#include "scene/text_cursor.h"

namespace hapton::gltf {
namespace {

// The images of base colour textures (glTF 2.0 [3.9.2]). Each image is read once [3.8.3]; a note says why one is missing.
class TextureImages {
 public:
  TextureImages(const Document& document, const std::filesystem::path& folder, RawMesh& raw)
      : document_(document), folder_(folder), raw_(raw) {}

  // The image's index in RawMesh::appearance. None: it is missing. Pre: the file has an image with this index.
  std::optional<std::size_t> find(std::size_t index) {
    const auto [known, is_new] = known_.try_emplace(index);
    if (is_new) known->second = read(index);
    return known->second;
  }

 private:
  std::optional<std::size_t> read(std::size_t index) {
    const Json& json = member(document_.root, "images")[index];
    const std::string name = fmt::format("images[{}]", index);
    const std::string uri = text_of(member(json, "uri"));
    if (!uri.empty() && !uri.starts_with("data:")) {
      if (uri.find("://") == std::string::npos) return add_image_file(folder_ / decode_percent(uri), raw_);
      raw_.notes.push_back(fmt::format("a texture is missing: {} is on the network ({})", name, printable(uri)));
      return std::nullopt;
    }
    Result<std::string> bytes = fail("{} has neither a uri nor a buffer view", name);
    if (!uri.empty()) {
      const auto comma = uri.find(";base64,");
      bytes = comma == std::string::npos ? Result<std::string>(fail("{} is inline but not base64", name))
                                         : decode_base64(std::string_view(uri).substr(comma + 8), name);
    } else if (!member(json, "bufferView").is_null()) {
      bytes = document_.buffers.copy_for_image(member(json, "bufferView"), name + ".bufferView");
    }
    if (!bytes) {
      raw_.notes.push_back(fmt::format("a texture is missing: {}", bytes.error().what));
      return std::nullopt;
    }
    raw_.appearance.images.push_back({name, std::move(*bytes)});
    return raw_.appearance.images.size() - 1;
  }

  const Document& document_;
  const std::filesystem::path& folder_;
  RawMesh& raw_;
  std::map<std::size_t, std::optional<std::size_t>> known_;  // by index in the file; none: the image is missing
};

std::optional<std::size_t> read_texture(const Document& document, const Json& info, const std::string& where, TextureImages& images,
                                        RawMesh& raw) {
  const auto texture = index_of(member(info, "index"), member(document.root, "textures"), where);
  if (!texture) {
    raw.notes.push_back(fmt::format("a texture is missing: {}", texture.error().what));
    return std::nullopt;
  }
  const auto image =
      index_of(member(member(document.root, "textures")[*texture], "source"), member(document.root, "images"), where + ".source");
  if (!image) {
    raw.notes.push_back(fmt::format("a texture is missing: textures[{}] has no PNG or JPEG image", *texture));
    return std::nullopt;
  }
  return images.find(*image);
}

// Reads wrapS or wrapT of a sampler [5.26]. If it is missing, the texture repeats.
TextureWrap read_wrap(const Json& sampler, const char* key, const std::string& where, RawMesh& raw) {
  const Json& value = member(sampler, key);
  if (value.is_null() || value == 10497) return TextureWrap::repeat;
  if (value == 33648) return TextureWrap::mirror;
  if (value == 33071) return TextureWrap::clamp;
  raw.notes.push_back(fmt::format("{}.{} is not 10497, 33071 or 33648: its textures repeat", where, key));
  return TextureWrap::repeat;
}

// Reads the two wrap modes of a texture that has an image.
std::array<TextureWrap, 2> read_wraps(const Document& document, const Json& info, const std::string& where, RawMesh& raw) {
  const auto texture = index_of(member(info, "index"), member(document.root, "textures"), where);
  if (!texture) return {};
  const Json& given = member(member(document.root, "textures")[*texture], "sampler");
  if (given.is_null()) return {};
  const Json& samplers = member(document.root, "samplers");
  const auto index = index_of(given, samplers, fmt::format("textures[{}].sampler", *texture));
  if (!index) {
    raw.notes.push_back(fmt::format("a texture repeats: {}", index.error().what));
    return {};
  }
  const std::string name = fmt::format("samplers[{}]", *index);
  return {read_wrap(samplers[*index], "wrapS", name, raw), read_wrap(samplers[*index], "wrapT", name, raw)};
}

// Reads alphaMode and alphaCutoff [3.9.4].
void read_alpha(const Json& json, const std::string& where, VisualMaterial& material, RawMesh& raw) {
  const Json& mode = member(json, "alphaMode");
  if (mode == "BLEND") material.alpha_mode = AlphaMode::blend;
  if (mode == "MASK") material.alpha_mode = AlphaMode::mask;
  if (!mode.is_null() && mode != "OPAQUE" && material.alpha_mode == AlphaMode::opaque) {
    raw.notes.push_back(fmt::format("{}.alphaMode is not OPAQUE, MASK or BLEND: drawn opaque", where));
  }
  const Json& cutoff = member(json, "alphaCutoff");
  if (cutoff.is_null()) return;
  if (cutoff.is_number() && std::isfinite(cutoff.get<double>()) && cutoff.get<double>() >= 0.0) {
    // A cutoff above 2 has the same effect as 2, which is safe in single precision.
    material.alpha_cutoff = static_cast<float>(std::min(2.0, cutoff.get<double>()));
  } else {
    raw.notes.push_back(fmt::format("{}.alphaCutoff is not a number of 0 or more: 0.5 is used", where));
  }
}

bool is_same(const TexturePlace& a, const TexturePlace& b) { return a.set == b.set && a.place.matrix() == b.place.matrix(); }

// Reads normalTexture [3.9.3]. place: that of the material's base colour texture; all images for forces use its texture coordinates.
void read_normals(const Document& document, const Json& json, const std::string& where, TextureImages& images, const TexturePlace& place,
                  VisualMaterial& material, RawMesh& raw) {
  const Json& texture = member(json, "normalTexture");
  if (!texture.is_object()) return;
  const auto own = read_texture_place(texture, where);
  if (!own || !is_same(*own, place)) {
    raw.notes.push_back(
        fmt::format("{} has other texture coordinates than the colours of its material (without these: TEXCOORD_0), so it cannot be felt: "
                    "name the image in a material",
                    where));
    return;
  }
  const Json& scale = member(texture, "scale");
  if (!scale.is_null() && !(scale.is_number() && std::isfinite(scale.get<float>()))) {
    raw.notes.push_back(fmt::format("{}.scale is not a finite number: it cannot be felt", where));
    return;
  }
  material.normal_scale = scale.is_null() ? 1.0F : scale.get<float>();
  material.normals = read_texture(document, texture, where, images, raw);
}

// The two numbers of `value`; `absent` if it is missing.
Result<Eigen::Vector2d> pair_or(const Json& value, const Eigen::Vector2d& absent, const std::string& where) {
  if (value.is_null()) return absent;
  return numbers_of<2>(value, where).map([](const std::array<double, 2>& pair) { return Eigen::Vector2d(pair[0], pair[1]); });
}

}  // namespace

// The transform is T R S, as in the extension's own matrices: scale S, then rotation R counter-clockwise in the image, then offset T.
Result<TexturePlace> read_texture_place(const Json& info, const std::string& where) {
  TexturePlace place;
  const auto set = count_or(member(info, "texCoord"), 0, where + ".texCoord");
  if (!set) return tl::unexpected(set.error());
  place.set = *set;
  const Json& transform = extension_of(info, "KHR_texture_transform");
  if (transform.is_null()) return place;
  const std::string name = where + ".extensions.KHR_texture_transform";
  const auto moved = count_or(member(transform, "texCoord"), place.set, name + ".texCoord");
  if (!moved) return tl::unexpected(moved.error());
  place.set = *moved;
  const auto offset = pair_or(member(transform, "offset"), Eigen::Vector2d::Zero(), name + ".offset");
  if (!offset) return tl::unexpected(offset.error());
  const auto scale = pair_or(member(transform, "scale"), Eigen::Vector2d::Ones(), name + ".scale");
  if (!scale) return tl::unexpected(scale.error());
  const Json& rotation = member(transform, "rotation");
  if (!rotation.is_null() && !(rotation.is_number() && std::isfinite(rotation.get<double>()))) {
    return fail("{}.rotation is not a finite number: {}", name, kExportAgain);
  }
  const Eigen::Affine2d made = Eigen::Translation2d(*offset) *
                               Eigen::Affine2d(Eigen::Rotation2Dd(rotation.is_null() ? 0.0 : -rotation.get<double>())) *
                               Eigen::Scaling((*scale)[0], (*scale)[1]);
  place.place = made.cast<float>();
  return place;
}

std::vector<TexturePlace> read_materials(const Document& document, const std::filesystem::path& folder, AppearanceReading appearance,
                                         RawMesh& raw) {
  const Json& materials = member(document.root, "materials");
  TextureImages images(document, folder, raw);
  std::vector<TexturePlace> places;
  for (std::size_t m = 0; m < size_of_array(materials); ++m) {
    VisualMaterial material{.name = text_of(member(materials[m], "name"))};
    read_alpha(materials[m], fmt::format("materials[{}]", m), material, raw);
    material.is_double_sided = member(materials[m], "doubleSided") == true;
    const BaseColour base = find_base_colour(materials[m], m);
    if (base.has_colour) {
      material.colour = Eigen::Vector3f(to_srgb(base.colour.x()), to_srgb(base.colour.y()), to_srgb(base.colour.z()));
      material.alpha = static_cast<float>(std::clamp(base.alpha, 0.0, 1.0));
    }
    const auto place = read_texture_place(*base.texture, base.where);
    if (!place) raw.notes.push_back(fmt::format("a texture may be misplaced: {}", place.error().what));
    places.push_back(place.value_or(TexturePlace()));
    if (base.texture->is_object()) material.image = read_texture(document, *base.texture, base.where, images, raw);
    if (material.image) material.wrap = read_wraps(document, *base.texture, base.where, raw);
    if (appearance == AppearanceReading::with_normals) {
      read_normals(document, materials[m], fmt::format("materials[{}].normalTexture", m), images, places.back(), material, raw);
    }
    raw.appearance.materials.push_back(std::move(material));
  }
  return places;
}

namespace {

void read_texcoords(const Document& document, const Json& json, const Primitive& primitive, const TexturePlace& from,
                    const std::string& where, VertexAppearances& appearances) {
  const std::string name = fmt::format("TEXCOORD_{}", from.set);
  if (!has_attribute(json, primitive, name)) return;
  const auto values = read_attribute(document, json, primitive, name, where, "VEC2", 2);
  if (!values) return;
  for (std::size_t i = 0; i < values->count; ++i) {
    const Eigen::Vector2f given(static_cast<float>(values->component(i, 0)), static_cast<float>(values->component(i, 1)));
    const Eigen::Vector2f place = from.place * given;
    if (place.allFinite()) appearances.vertices[i].texcoord = place;
  }
}

// Reads colours of three or four components. The fourth is alpha, which is linear and needs no conversion to sRGB.
void read_colours(const Document& document, const Json& json, const Primitive& primitive, const std::string& where,
                  VertexAppearances& appearances) {
  if (!has_attribute(json, primitive, "COLOR_0")) return;
  auto values = read_attribute(document, json, primitive, "COLOR_0", where, "VEC4", 4);
  const bool has_alpha = values.has_value();
  if (!values) values = read_attribute(document, json, primitive, "COLOR_0", where, "VEC3", 3);
  if (!values) return;
  appearances.has_colours = true;
  for (std::size_t i = 0; i < values->count; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      appearances.vertices[i].colour[k] = static_cast<std::uint8_t>(std::lround(255.0F * to_srgb(values->component(i, k))));
    }
    if (!has_alpha) continue;
    const double alpha = values->component(i, 3);
    appearances.vertices[i].alpha =
        static_cast<std::uint8_t>(std::isfinite(alpha) ? std::lround(255.0 * std::clamp(alpha, 0.0, 1.0)) : 255);
  }
}

}  // namespace

VertexAppearances read_vertex_appearances(const Document& document, const Json& json, const Primitive& primitive,
                                          const std::vector<TexturePlace>& places, const std::string& where) {
  VertexAppearances appearances;
  const auto material = index_of(member(json, "material"), member(document.root, "materials"), where + ".material");
  const bool has_material = !member(json, "material").is_null() && material && *material < places.size();
  if (!has_material && !has_attribute(json, primitive, "COLOR_0")) return appearances;
  appearances.vertices.resize(primitive.positions.size());
  if (has_material) {
    appearances.material = static_cast<std::uint32_t>(*material);
    read_texcoords(document, json, primitive, places[*material], where, appearances);
  }
  read_colours(document, json, primitive, where, appearances);
  return appearances;
}

}  // namespace hapton::gltf
