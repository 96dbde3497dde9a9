// A layout (three bytes: mode and filter, stride, count) and any bytes as meshopt data of a glTF buffer view.
#include <array>

#include "scene/gltf/meshopt.h"
#include "tests/fuzz/mesh_target.h"

FUZZ_TARGET(meshopt) {
  if (bytes.size() < 3) return;
  constexpr std::array kModes = {"ATTRIBUTES", "TRIANGLES", "INDICES", "ATTRIBUTES"};
  constexpr std::array kFilters = {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"};
  const std::string where = "here";
  const hapton::gltf::Json json = {{"mode", kModes[bytes[0] % 4]},
                                   {"filter", kFilters[bytes[0] / 4 % 4]},
                                   {"byteStride", bytes[1]},
                                   {"count", 3 * bytes[2] * (bytes[0] / 16U + 1U)}};
  const auto layout = hapton::gltf::meshopt_layout_of(json, where);
  if (!layout) return;
  const auto items = hapton::gltf::decode_meshopt(hapton::fuzz::text_of(bytes).substr(3), *layout, where);
  if (!items) {
    hapton::fuzz::require(items.error().what.find('\n') == std::string::npos);
    return;
  }
  hapton::fuzz::note_passage();
  hapton::fuzz::require(items->size() == layout->count * layout->stride);
}
