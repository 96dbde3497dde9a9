#include "scene/gltf/accessor.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

namespace hapton::gltf {
namespace {

template <class T>
double as(const char* at, bool normalized) {
  T value;
  std::memcpy(&value, at, sizeof value);
  if (!normalized || !std::is_integral_v<T>) return static_cast<double>(value);
  return std::max(static_cast<double>(value) / static_cast<double>(std::numeric_limits<T>::max()), -1.0);
}

struct Layout {
  std::size_t count = 0;
  std::size_t offset = 0;
  std::size_t component_type = 0;
  std::size_t item_bytes = 0;
};

Result<Layout> layout_of(const Json& json, const std::string& where, std::size_t components) {
  const auto count = count_of(member(json, "count"), where + ".count");
  const auto component_type = count_of(member(json, "componentType"), where + ".componentType");
  const auto offset = count_or(member(json, "byteOffset"), 0, where + ".byteOffset");
  if (!count) return tl::unexpected(count.error());
  if (!component_type) return tl::unexpected(component_type.error());
  if (!offset) return tl::unexpected(offset.error());
  const std::size_t item_bytes = components * component_bytes(*component_type);
  if (item_bytes == 0) return fail("{}.componentType is {}, unknown: {}", where, *component_type, kExportAgain);
  return Layout{*count, *offset, *component_type, item_bytes};
}

// The values, used in place in the file's buffer.
Result<Accessor> in_view(Buffers& buffers, const Json& view_index, const Layout& layout, const std::string& where) {
  const Result<Buffers::View> view = buffers.view(view_index, where + ".bufferView");
  if (!view) return tl::unexpected(view.error());
  Accessor result;
  result.json_path = where;
  result.stride = view->stride == 0 ? layout.item_bytes : view->stride;
  if (result.stride < layout.item_bytes) return fail("{}: its items overlap (stride {}): {}", where, view->stride, kExportAgain);
  const std::size_t size = view->bytes.size();
  const std::size_t end = layout.offset + layout.item_bytes;
  const std::size_t room = end > size ? 0 : (size - end) / result.stride + 1;
  if (layout.count > room) {
    return fail("{} promises {} items but its buffer view holds {}: cut short; copy or export it again", where, layout.count, room);
  }
  result.first = view->bytes.data() + layout.offset;
  result.count = layout.count;
  result.component_type = layout.component_type;
  return result;
}

// Zeros where the file gives no values (glTF 2.0, 3.6.2.3). Their number is bounded by the bytes read so far, not only by the count.
Result<std::string> dense_values(Buffers& buffers, const Json& json, const Layout& layout, const std::string& where) {
  if (member(json, "bufferView").is_null()) {
    if (layout.count > buffers.bytes_read()) {
      return fail("{} promises {} zeros, more than the file has bytes: {}", where, layout.count, kExportAgain);
    }
    return std::string(layout.count * layout.item_bytes, '\0');
  }
  const Result<Accessor> base = in_view(buffers, member(json, "bufferView"), layout, where);
  if (!base) return tl::unexpected(base.error());
  std::string values(layout.count * layout.item_bytes, '\0');
  for (std::size_t i = 0; i < layout.count; ++i) {
    std::memcpy(values.data() + i * layout.item_bytes, base->first + i * base->stride, layout.item_bytes);
  }
  return values;
}

// Replaces the items that a sparse accessor names by its values (glTF 2.0, 3.6.2.3).
std::optional<Error> replace_items(Buffers& buffers, const Json& sparse, const Layout& layout, const std::string& where,
                                   std::string& values) {
  const auto count = count_of(member(sparse, "count"), where + ".sparse.count");
  if (!count) return count.error();
  const Json& indices_json = member(sparse, "indices");
  const Json& values_json = member(sparse, "values");
  const std::string indices_name = where + ".sparse.indices";
  const std::string values_name = where + ".sparse.values";
  const auto indices_type = count_of(member(indices_json, "componentType"), indices_name + ".componentType");
  const auto indices_offset = count_or(member(indices_json, "byteOffset"), 0, indices_name + ".byteOffset");
  const auto values_offset = count_or(member(values_json, "byteOffset"), 0, values_name + ".byteOffset");
  if (!indices_type) return indices_type.error();
  if (!indices_offset) return indices_offset.error();
  if (!values_offset) return values_offset.error();
  if (*indices_type != 5121 && *indices_type != 5123 && *indices_type != 5125) {
    return Error{fmt::format("{}.componentType is {}, not an index: {}", indices_name, *indices_type, kExportAgain)};
  }
  const auto indices = in_view(buffers, member(indices_json, "bufferView"),
                               {*count, *indices_offset, *indices_type, component_bytes(*indices_type)}, indices_name);
  if (!indices) return indices.error();
  const auto replaced =
      in_view(buffers, member(values_json, "bufferView"), {*count, *values_offset, layout.component_type, layout.item_bytes}, values_name);
  if (!replaced) return replaced.error();
  for (std::size_t i = 0; i < *count; ++i) {
    const double index = indices->component(i, 0);
    if (!(index < static_cast<double>(layout.count))) {
      return Error{
          fmt::format("{}: index {} is {}, out of range: there are {} items; {}", indices_name, i, index, layout.count, kExportAgain)};
    }
    std::memcpy(values.data() + static_cast<std::size_t>(index) * layout.item_bytes, replaced->first + i * replaced->stride,
                layout.item_bytes);
  }
  return std::nullopt;
}

Result<Accessor> in_own_values(Buffers& buffers, const Json& json, const Layout& layout, const std::string& where) {
  const Json& sparse = member(json, "sparse");
  // dense_values bounds the number of zeros by the bytes read so far, so the replacements are read first.
  if (sparse.is_object()) {
    const auto read_first = buffers.view(member(member(sparse, "values"), "bufferView"), where + ".sparse.values.bufferView");
    if (!read_first) return tl::unexpected(read_first.error());
  }
  Result<std::string> values = dense_values(buffers, json, layout, where);
  if (!values) return tl::unexpected(values.error());
  if (!sparse.is_null()) {
    if (auto error = replace_items(buffers, sparse, layout, where, *values)) return tl::unexpected(std::move(*error));
  }
  Accessor result;
  result.json_path = where;
  result.storage = std::make_shared<const std::string>(std::move(*values));
  result.first = result.storage->data();
  result.count = layout.count;
  result.stride = layout.item_bytes;
  result.component_type = layout.component_type;
  return result;
}

}  // namespace

std::size_t component_bytes(std::size_t component_type) {
  switch (component_type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      return 0;
  }
}

double Accessor::component(std::size_t item, std::size_t k) const {
  const char* at = first + item * stride;
  switch (component_type) {
    case 5120:
      return as<std::int8_t>(at + k, normalized);
    case 5121:
      return as<std::uint8_t>(at + k, normalized);
    case 5122:
      return as<std::int16_t>(at + 2 * k, normalized);
    case 5123:
      return as<std::uint16_t>(at + 2 * k, normalized);
    case 5125:
      return as<std::uint32_t>(at + 4 * k, normalized);
    default:
      return as<float>(at + 4 * k, normalized);
  }
}

Result<Accessor> read_accessor(const Document& document, const Json& index_json, const std::string& where, std::string_view type,
                               std::size_t components) {
  const Json& accessors = member(document.root, "accessors");
  const auto index = index_of(index_json, accessors, where);
  if (!index) return tl::unexpected(index.error());
  const Json& json = accessors[*index];
  const std::string name = fmt::format("accessors[{}]", *index);
  if (text_of(member(json, "type")) != type) return fail("{} is not of type {}: {}", name, type, kExportAgain);
  const Result<Layout> layout = layout_of(json, name, components);
  if (!layout) return tl::unexpected(layout.error());
  const bool is_plain = member(json, "sparse").is_null() && !member(json, "bufferView").is_null();
  Result<Accessor> result = is_plain ? in_view(document.buffers, member(json, "bufferView"), *layout, name)
                                     : in_own_values(document.buffers, json, *layout, name);
  if (result) result->normalized = member(json, "normalized") == true;
  return result;
}

Result<std::size_t> accessor_count(const Document& document, const Json& index_json, const std::string& where) {
  const Json& accessors = member(document.root, "accessors");
  const auto index = index_of(index_json, accessors, where);
  if (!index) return tl::unexpected(index.error());
  return count_of(member(accessors[*index], "count"), fmt::format("accessors[{}].count", *index));
}

}  // namespace hapton::gltf
