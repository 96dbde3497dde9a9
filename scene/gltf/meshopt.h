#pragma once

#include <string>
#include <string_view>

#include "scene/gltf/json.h"

namespace hapton::gltf {

enum class MeshoptMode { attributes, triangles, indices };
enum class MeshoptFilter { none, octahedral, quaternion, exponential };

// What EXT_meshopt_compression says about a buffer view.
struct MeshoptLayout {
  MeshoptMode mode = MeshoptMode::attributes;
  MeshoptFilter filter = MeshoptFilter::none;
  std::size_t count = 0;   // number of items
  std::size_t stride = 0;  // bytes of each item
};

// The largest number of decoded bytes for one byte of the compressed stream: 64 for attributes (four groups of 16 equal bytes, with two
// bits for each group). In a triangle list a byte gives at most 12, in an index sequence 4. Source: appendix A of the extension.
constexpr std::size_t kMaxMeshoptBytesPerByte = 64;

// Error: a mode, filter, count or stride that the extension does not allow.
Result<MeshoptLayout> meshopt_layout_of(const Json& json, const std::string& where);

// Returns the decoded items, layout.stride bytes each. Error: more items than so many compressed bytes can hold, or than kMaxMeshFileBytes
// permits; broken data. RT: set-up only. Source: meshoptimizer, EXT_meshopt_compression.
Result<std::string> decode_meshopt(std::string_view bytes, const MeshoptLayout& layout, const std::string& where);

}  // namespace hapton::gltf
