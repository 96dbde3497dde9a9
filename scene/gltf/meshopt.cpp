#include "scene/gltf/meshopt.h"

#include <meshoptimizer.h>

#include <array>
#include <optional>

#include "scene/mesh_file.h"
#include "scene/text_cursor.h"

namespace hapton::gltf {
namespace {

template <class Value, std::size_t N>
std::optional<Value> find_name(const std::array<std::pair<std::string_view, Value>, N>& names, std::string_view name) {
  for (const auto& [known, value] : names) {
    if (known == name) return value;
  }
  return std::nullopt;
}

constexpr std::array kModes = {std::pair(std::string_view("ATTRIBUTES"), MeshoptMode::attributes),
                               std::pair(std::string_view("TRIANGLES"), MeshoptMode::triangles),
                               std::pair(std::string_view("INDICES"), MeshoptMode::indices)};
constexpr std::array kFilters = {std::pair(std::string_view("NONE"), MeshoptFilter::none),
                                 std::pair(std::string_view(""), MeshoptFilter::none),
                                 std::pair(std::string_view("OCTAHEDRAL"), MeshoptFilter::octahedral),
                                 std::pair(std::string_view("QUATERNION"), MeshoptFilter::quaternion),
                                 std::pair(std::string_view("EXPONENTIAL"), MeshoptFilter::exponential)};

bool is_stride_of(const MeshoptLayout& layout) {
  if (layout.mode != MeshoptMode::attributes) return layout.stride == 2 || layout.stride == 4;
  if (layout.stride == 0 || layout.stride % 4 != 0 || layout.stride > 256) return false;
  if (layout.filter == MeshoptFilter::octahedral) return layout.stride == 4 || layout.stride == 8;
  return layout.filter != MeshoptFilter::quaternion || layout.stride == 8;
}

std::size_t most_items(const MeshoptLayout& layout, std::size_t bytes) {
  switch (layout.mode) {
    case MeshoptMode::triangles:
      return 3 * bytes;
    case MeshoptMode::indices:
      return bytes;
    default:
      return kMaxMeshoptBytesPerByte * bytes / layout.stride;
  }
}

int decode_items(std::string_view bytes, const MeshoptLayout& layout, std::string& items) {
  const auto* from = reinterpret_cast<const unsigned char*>(bytes.data());
  switch (layout.mode) {
    case MeshoptMode::triangles:
      return meshopt_decodeIndexBuffer(items.data(), layout.count, layout.stride, from, bytes.size());
    case MeshoptMode::indices:
      return meshopt_decodeIndexSequence(items.data(), layout.count, layout.stride, from, bytes.size());
    default:
      return meshopt_decodeVertexBuffer(items.data(), layout.count, layout.stride, from, bytes.size());
  }
}

void undo_filter(const MeshoptLayout& layout, std::string& items) {
  switch (layout.filter) {
    case MeshoptFilter::octahedral:
      return meshopt_decodeFilterOct(items.data(), layout.count, layout.stride);
    case MeshoptFilter::quaternion:
      return meshopt_decodeFilterQuat(items.data(), layout.count, layout.stride);
    case MeshoptFilter::exponential:
      return meshopt_decodeFilterExp(items.data(), layout.count, layout.stride);
    default:
      return;
  }
}

}  // namespace

Result<MeshoptLayout> meshopt_layout_of(const Json& json, const std::string& where) {
  const std::string mode_name = text_of(member(json, "mode"));
  const std::string filter_name = text_of(member(json, "filter"));
  const auto mode = find_name(kModes, mode_name);
  const auto filter = find_name(kFilters, filter_name);
  const auto count = count_of(member(json, "count"), where + ".count");
  const auto stride = count_of(member(json, "byteStride"), where + ".byteStride");
  if (!mode) return fail("{}.mode is '{}', unknown: {}", where, printable(mode_name), kExportAgain);
  if (!filter) return fail("{}.filter is '{}', unknown: {}", where, printable(filter_name), kExportAgain);
  if (!count) return tl::unexpected(count.error());
  if (!stride) return tl::unexpected(stride.error());
  const MeshoptLayout layout{.mode = *mode, .filter = *filter, .count = *count, .stride = *stride};
  if (!is_stride_of(layout)) return fail("{}.byteStride is {}, which its mode and filter exclude: {}", where, *stride, kExportAgain);
  if (layout.filter != MeshoptFilter::none && layout.mode != MeshoptMode::attributes) {
    return fail("{}: only attributes have a filter: {}", where, kExportAgain);
  }
  if (layout.mode == MeshoptMode::triangles && layout.count % 3 != 0) {
    return fail("{}.count is {}, not a multiple of 3: {}", where, layout.count, kExportAgain);
  }
  return layout;
}

Result<std::string> decode_meshopt(std::string_view bytes, const MeshoptLayout& layout, const std::string& where) {
  const std::size_t room = std::min(most_items(layout, bytes.size()), kMaxMeshFileBytes / layout.stride);
  if (layout.count > room) {
    return fail("{} promises {} items but {} bytes hold at most {}: cut short; copy or export it again", where, layout.count, bytes.size(),
                room);
  }
  std::string items(layout.count * layout.stride, '\0');
  if (layout.count > 0 && decode_items(bytes, layout, items) != 0) {
    return fail("{}: its compressed data are broken: copy or export it again", where);
  }
  undo_filter(layout, items);
  return items;
}

}  // namespace hapton::gltf
