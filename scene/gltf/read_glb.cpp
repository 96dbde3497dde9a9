#include <cstdint>
#include <cstring>
#include <optional>

#include "scene/gltf/reader.h"
#include "scene/raw_mesh.h"

namespace hapton {
namespace {

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof word);
  return word;
}

}  // namespace

// Reads the header and the chunks of a GLB file (glTF 2.0, section 4.4).
Result<RawMesh> read_glb(std::string_view bytes, const std::filesystem::path& folder, std::size_t max_triangles,
                         AppearanceReading appearance) {
  constexpr std::size_t kHeaderBytes = 12;
  constexpr std::size_t kChunkHeaderBytes = 8;
  constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
  constexpr std::uint32_t kBinaryChunk = 0x004E4942;
  if (!bytes.starts_with("glTF")) return fail("does not begin with 'glTF', so not a GLB file: check its extension");
  if (bytes.size() < kHeaderBytes) return fail("has {} bytes, fewer than a GLB header: copy or export it again", bytes.size());
  if (word_at(bytes, 4) != 2) return fail("is GLB version {}, only 2 can be read: export it as glTF 2.0", word_at(bytes, 4));
  if (word_at(bytes, 8) > bytes.size()) {
    return fail("should have {} bytes but has {}: cut short; copy or export it again", word_at(bytes, 8), bytes.size());
  }
  bytes = bytes.substr(0, word_at(bytes, 8));
  std::optional<std::string_view> json;
  std::optional<std::string_view> binary;
  for (std::size_t at = kHeaderBytes; at + kChunkHeaderBytes <= bytes.size();) {
    const std::size_t length = word_at(bytes, at);
    const std::uint32_t type = word_at(bytes, at + 4);
    if (length > bytes.size() - at - kChunkHeaderBytes) return fail("byte {}: a chunk reaches past the end: copy or export it again", at);
    const std::string_view chunk = bytes.substr(at + kChunkHeaderBytes, length);
    if (type == kJsonChunk && !json) json = chunk;
    if (type == kBinaryChunk && !binary) binary = chunk;
    at += kChunkHeaderBytes + length;
  }
  if (!json) return fail("has no JSON chunk: copy or export it again");
  return gltf::read_document(*json, binary, folder, "GLB", max_triangles, appearance);
}

}  // namespace hapton
