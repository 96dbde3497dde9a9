#pragma once

#include <string>
#include <string_view>

#include "scene/gltf/json.h"

namespace hapton::gltf {

enum class MeshoptMode { attributes, triangles, indices };
enum class MeshoptFilter { none, octahedral, quaternion, exponential };

// What EXT_meshopt_compression says of a buffer view.
struct MeshoptLayout {
  MeshoptMode mode = MeshoptMode::attributes;
  MeshoptFilter filter = MeshoptFilter::none;
  std::size_t count = 0;   // items
  std::size_t stride = 0;  // bytes of an item
};

// What one byte of the stream can stand for at most: 64 bytes of attributes (four groups of 16 equal bytes, two bits each); a triangle of a
// list and an index are less. Appendix A of the extension.
constexpr std::size_t kMeshoptBytesOfAByte = 64;

// Error: a mode, a filter, a count or a stride that the extension does not have.
Result<MeshoptLayout> meshopt_layout_of(const Json& json, const std::string& where);

// The decoded items, stride bytes each. Error: more items than the fewest bytes of an item allow, broken data. RT: set-up only. Source:
// meshoptimizer, EXT_meshopt_compression.
Result<std::string> decode_meshopt(std::string_view bytes, const MeshoptLayout& layout, const std::string& where);

}  // namespace hapton::gltf
