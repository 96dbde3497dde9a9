#include "scene/gltf/extensions.h"

#include <array>
#include <set>
#include <string_view>

#include "scene/text_cursor.h"

namespace hapton::gltf {
namespace {

constexpr std::array<std::string_view, 7> kReadExtensions = {
    "KHR_mesh_quantization", "KHR_draco_mesh_compression", "EXT_meshopt_compression", "EXT_mesh_gpu_instancing",
    "KHR_node_visibility",   "EXT_mesh_manifold",          "MPEG_haptic_material"};
// The name of MPEG_haptic_material in drafts of the standard, where it had another structure.
constexpr std::string_view kEarlierHaptics = "MPEG_material_haptic";

// Prefixes of extensions for surfaces, images, light, sound, motion and descriptions. Any other one may contain geometry that is not read.
constexpr std::array<std::string_view, 22> kHarmlessExtensions = {"KHR_materials_",
                                                                  "KHR_texture_",
                                                                  "EXT_texture_",
                                                                  "MSFT_texture_",
                                                                  "KHR_lights_",
                                                                  "EXT_lights_",
                                                                  "KHR_xmp",
                                                                  "KHR_animation_",
                                                                  "KHR_audio",
                                                                  "MSFT_audio",
                                                                  "EXT_structural_metadata",
                                                                  "EXT_instance_features",
                                                                  "EXT_mesh_features",
                                                                  "KHR_techniques_",
                                                                  "KHR_interactivity",
                                                                  "KHR_environment_map",
                                                                  "ADOBE_materials_",
                                                                  "EXT_materials_",
                                                                  "AGI_",
                                                                  "FB_geometry_metadata",
                                                                  "KHR_node_selectability",
                                                                  "MPEG_haptic"};

bool is_shape_complete_with(std::string_view extension) {
  for (const std::string_view read : kReadExtensions) {
    if (extension == read) return true;
  }
  for (const std::string_view prefix : kHarmlessExtensions) {
    if (extension.starts_with(prefix)) return true;
  }
  return false;
}

}  // namespace

std::optional<Error> check_required_extensions(const Json& root) {
  for (const Json& extension : member(root, "extensionsRequired")) {
    if (is_shape_complete_with(text_of(extension))) continue;
    return Error{fmt::format("needs the glTF extension '{}', which is not read: export it without", printable(text_of(extension)))};
  }
  return std::nullopt;
}

std::vector<std::string> describe_unsupported_extensions(const Json& root) {
  std::set<std::string> unread;
  for (const Json& extension : member(root, "extensionsUsed")) {
    if (!is_shape_complete_with(text_of(extension))) unread.insert(printable(text_of(extension)));
  }
  std::vector<std::string> notes;
  for (const std::string& extension : unread) {
    if (extension == kEarlierHaptics) {
      notes.push_back(
          fmt::format("uses the glTF extension '{}', a draft of MPEG_haptic_material that is not read: its haptic materials are "
                      "ignored; export it as MPEG_haptic_material",
                      extension));
      continue;
    }
    notes.push_back(fmt::format("uses the glTF extension '{}', which is not read: what it adds to the shape is missing", extension));
  }
  return notes;
}

}  // namespace hapton::gltf
