#include "scene/gltf/buffers.h"

#include "scene/file_bytes.h"
#include "scene/gltf/meshopt.h"
#include "scene/gltf/uri.h"
#include "scene/mesh_file.h"
#include "scene/text_cursor.h"

namespace hapton::gltf {

Result<Buffers::View> Buffers::view(const Json& index_json, const std::string& where) {
  const Json& views = member(root_, "bufferViews");
  const auto index = index_of(index_json, views, where);
  if (!index) return tl::unexpected(index.error());
  const Json& json = views[*index];
  const Json& compression = extension_of(json, "EXT_meshopt_compression");
  if (compression.is_object()) return compressed_view(*index, compression);
  const std::string name = fmt::format("bufferViews[{}]", *index);
  const auto stride = count_or(member(json, "byteStride"), 0, name + ".byteStride");
  if (!stride) return tl::unexpected(stride.error());
  return range(json, name).map([&](std::string_view bytes) { return View{bytes, *stride}; });
}

Result<std::string> Buffers::copy_for_image(const Json& index_json, const std::string& where) {
  const Result<View> found = view(index_json, where);
  if (!found) return tl::unexpected(found.error());
  if (copied_bytes_ + found->bytes.size() > kMaxCopyRatio * bytes_read_) {
    return fail("{}: the images have more than {} times the {} bytes of the buffers, which they share: {}", where, kMaxCopyRatio,
                bytes_read_, kExportAgain);
  }
  copied_bytes_ += found->bytes.size();
  return std::string(found->bytes);
}

Result<Buffers::View> Buffers::compressed_view(std::size_t index, const Json& compression) {
  const std::string name = fmt::format("bufferViews[{}].extensions.EXT_meshopt_compression", index);
  const Result<MeshoptLayout> layout = meshopt_layout_of(compression, name);
  if (!layout) return tl::unexpected(layout.error());
  auto unfolded = unfolded_.find(index);
  if (unfolded == unfolded_.end()) {
    const Result<std::string_view> bytes = range(compression, name);
    if (!bytes) return tl::unexpected(bytes.error());
    Result<std::string> decoded = decode_meshopt(*bytes, *layout, name);
    if (!decoded) return tl::unexpected(decoded.error());
    // Any number of views may share the same bytes, so the sum over all views has a limit.
    unfolded_bytes_ += decoded->size();
    if (unfolded_bytes_ > kMaxMeshoptBytesPerByte * bytes_read_) {
      return fail("{}: its compressed views unfold to more than the {} bytes of its buffers can hold: {}", name, bytes_read_, kExportAgain);
    }
    unfolded = unfolded_.emplace(index, std::move(*decoded)).first;
  }
  return View{unfolded->second, layout->stride};
}

// The bytes that the keys buffer, byteOffset and byteLength select. A buffer view and its compression extension both have these keys.
Result<std::string_view> Buffers::range(const Json& json, const std::string& name) {
  const auto length = count_of(member(json, "byteLength"), name + ".byteLength");
  const auto offset = count_or(member(json, "byteOffset"), 0, name + ".byteOffset");
  if (!length) return tl::unexpected(length.error());
  if (!offset) return tl::unexpected(offset.error());
  Result<std::string_view> bytes = buffer(member(json, "buffer"), name + ".buffer");
  if (!bytes) return bytes;
  if (*offset + *length > bytes->size()) {
    return fail("{} ends at byte {} but its buffer has {}: cut short; copy or export it again", name, *offset + *length, bytes->size());
  }
  return bytes->substr(*offset, *length);
}

Result<std::string_view> Buffers::buffer(const Json& index_json, const std::string& where) {
  const Json& buffers = member(root_, "buffers");
  const auto index = index_of(index_json, buffers, where);
  if (!index) return tl::unexpected(index.error());
  const Json& uri = member(buffers[*index], "uri");
  const std::string name = fmt::format("buffers[{}]", *index);
  const auto length = count_of(member(buffers[*index], "byteLength"), name + ".byteLength");
  if (!length) return tl::unexpected(length.error());
  std::string_view bytes;
  if (uri.is_null() && *index == 0 && binary_) {
    bytes = *binary_;
  } else {
    const std::string from = text_of(uri);
    const std::string key = from.empty() || from.starts_with("data:") ? name : file_key(folder_, from);
    auto loaded = loaded_.find(key);
    if (loaded == loaded_.end()) {
      Result<std::string> read = load_buffer(from, name);
      if (!read) return tl::unexpected(read.error());
      bytes_read_ += read->size();
      loaded = loaded_.emplace(key, std::move(*read)).first;
    }
    bytes = loaded->second;
  }
  if (bytes.size() < *length)
    return fail("{} should have {} bytes but has {}: cut short; copy or export it again", name, *length, bytes.size());
  return bytes.substr(0, *length);
}

Result<std::string> Buffers::load_buffer(const std::string& uri, const std::string& name) const {
  if (uri.empty()) return fail("{} has neither a uri nor a binary chunk: {}", name, kExportAgain);
  if (uri.starts_with("data:")) {
    const auto comma = uri.find(";base64,");
    if (comma == std::string::npos) return fail("{} is inline but not base64: {}", name, kExportAgain);
    return decode_base64(std::string_view(uri).substr(comma + 8), name);
  }
  if (uri.find("://") != std::string::npos) return fail("{} is on the network ({}): fetch it beside the file", name, printable(uri));
  Result<std::string> bytes = read_file_bytes(folder_ / decode_percent(uri), kMaxMeshFileBytes);
  if (!bytes) return fail("{} cannot be read: {}", name, bytes.error().what);
  return bytes;
}

}  // namespace hapton::gltf
