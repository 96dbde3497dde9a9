#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "scene/gltf/buffers.h"
#include "scene/gltf/json.h"

namespace hapton::gltf {

// What a file's parts refer to.
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
  std::string where;
  std::shared_ptr<const std::string> own;  // where first points to when the values stand nowhere in the file as they are (sparse ones)

  // KHR_mesh_quantization allows integers for positions; normalised ones by [3.6.2.2]. Pre: item < count, k below the type's components.
  double component(std::size_t item, std::size_t k) const;
};

// The accessor of that number, if it has this type ("VEC3" ...) and number of components. A sparse one is read with its substitutions.
// Error: what does not fit or lies outside the file's bytes; an accessor without a buffer view with more items than the file has bytes.
Result<Accessor> read_accessor(const Document& document, const Json& index_json, const std::string& where, std::string_view type,
                               std::size_t components);

// Only its count, of one that a compressed primitive describes and that need not have bytes of its own.
Result<std::size_t> accessor_count(const Document& document, const Json& index_json, const std::string& where);

}  // namespace hapton::gltf
