#include "scene/gltf/haptics.h"

#include <algorithm>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/similar_word.h"
#include "scene/file_bytes.h"
#include "scene/gltf/uri.h"
#include "scene/text_cursor.h"

namespace hapton::gltf {
namespace {

constexpr const char* kHapticExtension = "MPEG_haptic_material";
constexpr std::array<std::string_view, 3> kHapticTypes = {"High_Resolution", "Low_Resolution", "Other"};  // best first
constexpr std::string_view kReferenceType = "Reference";  // refers to haptic data in another file

// A property of a haptic material: the key of its textures, and the key in extras.hapton of the numbers that give these a unit.
struct HapticProperty {
  const char* name;
  const char* numbers;  // if this key is missing, the property is ignored, with a note
  std::optional<std::size_t> HapticMaterial::*image;
};

// The extension does not define what a custom texture means. With the key viscosity_map_ns_per_m it is a viscosity.
constexpr std::string_view kCustom = "custom";
constexpr std::array<HapticProperty, 4> kProperties = {{{"vibrotactileTexture", "bump_height_m", &HapticMaterial::height},
                                                        {"stiffness", "stiffness_map_n_per_m", &HapticMaterial::stiffness},
                                                        {"friction", "friction_map_range", &HapticMaterial::friction},
                                                        {"custom", "viscosity_map_ns_per_m", &HapticMaterial::viscosity}}};
// Largest depth of nested lists and tables. Keys of a material need 3 at most, but a file may nest millions and so exhaust the stack.
constexpr int kDeepestExtras = 16;
constexpr std::size_t kMaxHapticImageBytes = std::size_t{1} << 28;
constexpr std::array<std::string_view, 2> kNotFelt = {"vibration", "temperature"};
constexpr std::array<std::string_view, 7> kKnownKeys = {"stiffness",  "friction", "vibrotactileTexture", kCustom, "name",
                                                        "extensions", "extras"};

Result<std::string> read_image_bytes(const Document& document, const Json& json, const std::string& where,
                                     const std::filesystem::path& folder) {
  const std::string uri = text_of(member(json, "uri"));
  if (uri.starts_with("data:")) {
    const auto comma = uri.find(";base64,");
    if (comma == std::string::npos) return fail("{} is inline but not base64: {}", where, kExportAgain);
    return decode_base64(std::string_view(uri).substr(comma + 8), where);
  }
  if (uri.find("://") != std::string::npos) return fail("{} is on the network ({}): put it beside the file", where, printable(uri));
  if (!uri.empty()) {
    auto bytes = read_file_bytes(folder / decode_percent(uri), kMaxHapticImageBytes);
    if (!bytes) return fail("{}: '{}' cannot be read: put it beside the file", where, printable(uri));
    return bytes;
  }
  if (member(json, "bufferView").is_null()) return fail("{} has neither a uri nor a buffer view: {}", where, kExportAgain);
  return document.buffers.copy_for_image(member(json, "bufferView"), where + ".bufferView");
}

// Chooses the texture of a property that is used: the one with the best type. Null: no texture of the list has a supported type. Error:
// an entry that the extension does not allow.
Result<const Json*> choose_texture(const Json& list, const std::string& where) {
  const Json* best = nullptr;
  std::size_t best_type = kHapticTypes.size();
  if (!list.is_array()) return fail("{} is not a list of textures: {}", where, kExportAgain);
  for (std::size_t i = 0; i < list.size(); ++i) {
    // If the type is missing, the extension's schema defines it as High_Resolution.
    const Json& given = member(list[i], "type");
    const std::string type = given.is_null() ? std::string(kHapticTypes[0]) : text_of(given);
    const auto found = std::find(kHapticTypes.begin(), kHapticTypes.end(), type);
    if (found == kHapticTypes.end() && type != kReferenceType) {
      return fail("{}[{}].type is '{}': it must be High_Resolution, Low_Resolution, Reference or Other", where, i, printable(type));
    }
    const auto rank = static_cast<std::size_t>(found - kHapticTypes.begin());
    if (rank < best_type) {
      best = &list[i];
      best_type = rank;
    }
  }
  return best;
}

// Whether the texture repeats in one direction, by the wrap mode of its sampler (glTF 2.0 [5.26]).
Result<bool> repeats(const Json& sampler, const char* key, const std::string& where) {
  const Json& value = member(sampler, key);
  constexpr int kRepeat = 10497, kMirroredRepeat = 33648, kClampToEdge = 33071;  // numbers of OpenGL
  if (value.is_null() || value == kRepeat) return true;
  if (value == kMirroredRepeat || value == kClampToEdge) return false;
  return fail("{}.{} must be {}, {} or {}: {}", where, key, kRepeat, kClampToEdge, kMirroredRepeat, kExportAgain);
}

bool is_deeper_than(const Json& json, int levels) {
  if (!json.is_structured()) return false;
  return levels == 0 || std::any_of(json.begin(), json.end(), [&](const Json& each) { return is_deeper_than(each, levels - 1); });
}

class HapticReader {
 public:
  HapticReader(const Document& document, const std::filesystem::path& folder, RawMesh& raw)
      : document_(document), folder_(folder), raw_(raw) {}

  Result<HapticPlace> add(const Json& json, const std::string& where) {
    if (!json.is_object()) return fail("{} is not an object: {}", where, kExportAgain);
    HapticMaterial material{.name = printable(text_of(member(json, "name"))), .where = where, .numbers = {}};
    const Json& numbers = member(member(json, "extras"), "hapton");
    if (!numbers.is_null() && !numbers.is_object()) return fail("{}.extras.hapton is not an object", where);
    if (is_deeper_than(numbers, kDeepestExtras)) {
      return fail("{}.extras.hapton has more than {} lists and objects inside each other: no key has so many", where, kDeepestExtras);
    }
    if (numbers.is_object() && !numbers.empty()) material.numbers = numbers.dump(-1, ' ', false, Json::error_handler_t::replace);
    std::optional<HapticPlace> place;
    for (const HapticProperty& property : kProperties) {
      const Json& list = member(json, property.name);
      if (list.is_null()) continue;
      const bool has_numbers = !member(numbers, property.numbers).is_null();
      // Without these numbers, a custom texture may mean anything.
      if (property.name == kCustom && !has_numbers) {
        if (!list.empty()) note_custom(where);
        continue;
      }
      const std::string list_where = fmt::format("{}.{}", where, property.name);
      const auto texture = choose_texture(list, list_where);
      if (!texture) return tl::unexpected(texture.error());
      if (*texture == nullptr) {
        if (!list.empty()) note("{} only refers to haptic data in other files, which is not supported: it is ignored", list_where);
        continue;
      }
      if (!has_numbers) {
        note("{} is ignored, because the extension has no units: add \"extras\": {{\"hapton\": {{\"{}\": ...}}}} to {}", list_where,
             property.numbers, where);
        continue;
      }
      const auto read = read_texture_of(**texture, list_where, material.*property.image);
      if (!read) return tl::unexpected(read.error());
      if (place && !is_same(*place, *read)) {
        return fail(
            "{}: its texture uses other texture coordinates than those before it: give all textures of a haptic material the same "
            "texCoord, KHR_texture_transform and wrap modes",
            list_where);
      }
      place = *read;
    }
    note_ignored(json, where);
    raw_.haptics.materials.push_back(std::move(material));
    return place.value_or(HapticPlace());
  }

 private:
  void note_custom(const std::string& where) {
    note(
        "{}.custom is ignored, because the extension does not say what it is: if it is a viscosity, add \"extras\": {{\"hapton\": "
        "{{\"viscosity_map_ns_per_m\": [...]}}}} to {}",
        where, where);
  }

  void note_ignored(const Json& json, const std::string& where) {
    for (const auto& [name, value] : json.items()) {
      if (std::find(kKnownKeys.begin(), kKnownKeys.end(), name) != kKnownKeys.end()) continue;
      if (std::find(kNotFelt.begin(), kNotFelt.end(), name) == kNotFelt.end()) {
        note("{}.{} is ignored: the extension has no such property{}", where, printable(name), similar_word_hint(name, kKnownKeys));
      } else if (!value.empty()) {
        note("{}.{} is ignored: only stiffness, friction, vibrotactileTexture and custom are supported", where, name);
      }
    }
  }

  static bool is_same(const HapticPlace& a, const HapticPlace& b) {
    return a.texture.set == b.texture.set && a.texture.place.matrix() == b.texture.place.matrix() && a.repeats == b.repeats;
  }

  template <class... Args>
  void note(fmt::format_string<Args...> format, Args&&... args) {
    raw_.notes.push_back(fmt::format(format, std::forward<Args>(args)...));
  }

  // where: JSON path of the property's list of textures.
  Result<HapticPlace> read_texture_of(const Json& item, const std::string& where, std::optional<std::size_t>& image) {
    const Json& info = member(item, "texture");
    const Json& textures = member(document_.root, "textures");
    const auto texture = index_of(member(info, "index"), textures, where + ".texture.index");
    if (!texture) return tl::unexpected(texture.error());
    const std::string name = fmt::format("textures[{}]", *texture);
    const Json& images = member(document_.root, "images");
    if (member(textures[*texture], "source").is_null()) return fail("{}: {} has no PNG or JPEG image: {}", where, name, kExportAgain);
    const auto source = index_of(member(textures[*texture], "source"), images, name + ".source");
    if (!source) return tl::unexpected(source.error());
    const auto added = add_image(images[*source], fmt::format("images[{}]", *source));
    if (!added) return tl::unexpected(added.error());
    image = *added;
    auto place = read_texture_place(info, where + ".texture");
    if (!place) return tl::unexpected(place.error());
    HapticPlace made{.texture = *place};
    const Json& given = member(textures[*texture], "sampler");
    if (given.is_null()) return made;
    const Json& samplers = member(document_.root, "samplers");
    const auto sampler = index_of(given, samplers, name + ".sampler");
    if (!sampler) return tl::unexpected(sampler.error());
    constexpr std::array<const char*, 2> kWraps = {"wrapS", "wrapT"};
    for (std::size_t k = 0; k < 2; ++k) {
      const auto one = repeats(samplers[*sampler], kWraps[k], fmt::format("samplers[{}]", *sampler));
      if (!one) return tl::unexpected(one.error());
      made.repeats[k] = *one;
    }
    return made;
  }

  Result<std::size_t> add_image(const Json& json, const std::string& name) {
    auto& images = raw_.haptics.maps.images;
    const std::string uri = text_of(member(json, "uri"));
    const bool is_file = !uri.empty() && !uri.starts_with("data:");
    const std::string key = is_file ? file_key(folder_, uri) : name;
    const auto [known, is_new] = numbers_.try_emplace(key, images.size());
    if (!is_new) return known->second;
    auto bytes = read_image_bytes(document_, json, name, folder_);
    if (!bytes) return tl::unexpected(bytes.error());
    images.push_back({name, std::move(*bytes)});
    return known->second;
  }

  const Document& document_;
  const std::filesystem::path& folder_;
  RawMesh& raw_;
  std::map<std::string, std::size_t> numbers_;  // index of an image in maps.images, by its file or its JSON path
};

}  // namespace

Result<std::vector<HapticPlace>> read_haptic_materials(const Document& document, const std::filesystem::path& folder, RawMesh& raw) {
  std::vector<HapticPlace> places;
  const Json& extension = extension_of(document.root, kHapticExtension);
  if (extension.is_null()) return places;
  const std::string where = fmt::format("extensions.{}.materials", kHapticExtension);
  const Json& materials = member(extension, "materials");
  if (size_of_array(materials) == 0) return fail("{} is not a list with at least one material: {}", where, kExportAgain);
  HapticReader reader(document, folder, raw);
  for (std::size_t m = 0; m < materials.size(); ++m) {
    auto place = reader.add(materials[m], fmt::format("{}[{}]", where, m));
    if (!place) return tl::unexpected(place.error());
    places.push_back(*place);
  }
  return places;
}

Result<std::optional<std::uint32_t>> haptic_material_of(const Document& document, std::size_t mesh, const MeshHaptics& haptics) {
  const Json& extension = extension_of(member(document.root, "meshes")[mesh], kHapticExtension);
  if (extension.is_null()) return std::optional<std::uint32_t>();
  const std::string where = fmt::format("meshes[{}].extensions.{}.hapticMaterialIndex", mesh, kHapticExtension);
  const Json& materials = member(extension_of(document.root, kHapticExtension), "materials");
  const auto index = index_of(member(extension, "hapticMaterialIndex"), materials, where);
  if (!index) return tl::unexpected(index.error());
  if (!haptics.materials[*index].has_content()) return std::optional<std::uint32_t>();
  return std::optional(static_cast<std::uint32_t>(*index));
}

Result<std::vector<Eigen::Vector2f>> read_haptic_places(const Document& document, const Json& json, const Primitive& primitive,
                                                        const HapticPlace& place, const std::string& where) {
  const std::string name = fmt::format("TEXCOORD_{}", place.texture.set);
  if (!has_attribute(json, primitive, name)) return fail("{} has a haptic material with textures, and no {}: unwrap it", where, name);
  const auto values = read_attribute(document, json, primitive, name, where, "VEC2", 2);
  if (!values) return tl::unexpected(values.error());
  const std::size_t vertices = values->count;
  std::vector<Eigen::Vector2f> places;
  places.reserve(vertices);
  for (std::size_t i = 0; i < vertices; ++i) {
    const Eigen::Vector2f given(static_cast<float>(values->component(i, 0)), static_cast<float>(values->component(i, 1)));
    places.push_back(place.texture.place * given);
    const Eigen::Vector2f& made = places.back();
    if (!made.allFinite()) return fail("{}: texture coordinate {} is not finite: {}", values->json_path, i, kExportAgain);
    for (int k = 0; k < 2; ++k) {
      if (place.repeats[static_cast<std::size_t>(k)] || (made[k] >= 0.0F && made[k] <= 1.0F)) continue;
      return fail(
          "{}: texture coordinate {} is {:.6g}, and the sampler of its haptic texture does not repeat: haptic textures only repeat, "
          "so keep the coordinates within 0 to 1",
          values->json_path, i, made[k]);
    }
  }
  return places;
}

}  // namespace hapton::gltf
