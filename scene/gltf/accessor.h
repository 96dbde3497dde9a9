#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "scene/gltf/buffers.h"
#include "scene/gltf/json.h"

namespace hapton::gltf {

// A parsed glTF file. Numbers in brackets here are sections of the glTF 2.0 specification.
struct Document {
  const Json& root;
  Buffers& buffers;
};

// Typed values in a buffer [3.6.2].
struct Accessor {
  const char* first = nullptr;
  std::size_t count = 0;
  std::size_t stride = 0;
  std::size_t component_type = 0;
  bool normalized = false;
  std::string json_path;                       // the accessor's path in the JSON, for error texts
  std::shared_ptr<const std::string> storage;  // holds values that are not in the file as such: of a sparse accessor, or zeros

  // One number of one item. KHR_mesh_quantization allows integers for positions; normalised ones are converted as [3.6.2.2] says.
  // Pre: item < count, k below the number of components of the type.
  double component(std::size_t item, std::size_t k) const;
};

// The size of one number of that type in bytes [3.6.2.2]; 0: there is no such type.
std::size_t component_bytes(std::size_t component_type);

// The accessor with the index that index_json holds. A sparse one is read with its substitutions. where: the place in the JSON, for errors.
// Error: its type is not `type` ("VEC3" ..., with that many components) or its component type is unknown; its values lie outside the file's
// bytes; it has no buffer view and more items than the file has bytes.
Result<Accessor> read_accessor(const Document& document, const Json& index_json, const std::string& where, std::string_view type,
                               std::size_t components);

// Only the count of an accessor: a compressed primitive describes its data with an accessor that may have no bytes of its own.
Result<std::size_t> accessor_count(const Document& document, const Json& index_json, const std::string& where);

}  // namespace hapton::gltf
