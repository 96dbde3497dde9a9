#pragma once

#include <meshoptimizer.h>

#include <string>
#include <vector>

#include "tests/scene/sample_files.h"

// glTF documents put together piece by piece.
namespace hapton::sample {

// Pieces of one buffer, each with its own buffer view.
class Pieces {
 public:
  // Returns the index of the buffer view. members: further JSON members of the view, each preceded by a comma.
  std::size_t add(const std::string& bytes, const std::string& members = "") {
    buffer_.resize((buffer_.size() + 3) / 4 * 4, '\0');
    views_ +=
        fmt::format(R"({}{{"buffer":0,"byteOffset":{},"byteLength":{}{}}})", count_ == 0 ? "" : ",", buffer_.size(), bytes.size(), members);
    buffer_ += bytes;
    return count_++;
  }
  // Like add(), for bytes that meshopt has compressed: the view itself refers to buffer 1, a fallback buffer without data.
  std::size_t add_meshopt(const std::string& bytes, std::size_t items, std::size_t stride, const std::string& mode,
                          const std::string& members = "") {
    buffer_.resize((buffer_.size() + 3) / 4 * 4, '\0');
    views_ += fmt::format(
        R"({}{{"buffer":1,"byteLength":{},"extensions":{{"EXT_meshopt_compression":{{"buffer":0,"byteOffset":{},"byteLength":{},)"
        R"("byteStride":{},"count":{},"mode":"{}"{}}}}}}})",
        count_ == 0 ? "" : ",", items * stride, buffer_.size(), bytes.size(), stride, items, mode, members);
    buffer_ += bytes;
    return count_++;
  }

  const std::string& buffer() const { return buffer_; }
  std::string json(const std::string& accessors, const std::string& rest) const {
    return fmt::format(
        R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],{},"accessors":[{}],"bufferViews":[{}],)"
        R"("buffers":[{{"byteLength":{}}},{{"byteLength":1000000,"extensions":{{"EXT_meshopt_compression":{{"fallback":true}}}}}}]}})",
        rest, accessors, views_, buffer_.size());
  }
  std::string glb(const std::string& accessors, const std::string& rest) const { return sample::glb(json(accessors, rest), buffer_); }

 private:
  std::string buffer_;
  std::string views_;
  std::size_t count_ = 0;
};

// One node with one mesh of accessors 0 (positions) and 1 (indices).
inline constexpr const char* kOneNode =
    R"("nodes":[{"mesh":0,"name":"body"}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}])";

inline std::string positions_of(const TriangleMesh& mesh) {
  std::string bytes;
  for (const Vec3& v : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) append(bytes, static_cast<float>(v[axis]));
  }
  return bytes;
}

inline std::string indices_of(const TriangleMesh& mesh) {
  std::string bytes;
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) append(bytes, static_cast<std::uint16_t>(v));
  }
  return bytes;
}

inline std::string accessors_of(const TriangleMesh& mesh) {
  return fmt::format(R"({{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3"}},)"
                     R"({{"bufferView":1,"componentType":5123,"count":{},"type":"SCALAR"}})",
                     mesh.vertices.size(), 3 * mesh.triangles.size());
}

inline std::string meshopt_vertices(const std::string& bytes, std::size_t count, std::size_t stride) {
  std::string packed(meshopt_encodeVertexBufferBound(count, stride), '\0');
  auto* into = reinterpret_cast<unsigned char*>(packed.data());
  packed.resize(meshopt_encodeVertexBuffer(into, packed.size(), bytes.data(), count, stride));
  return packed;
}

inline std::string meshopt_triangles(const TriangleMesh& mesh) {
  std::vector<unsigned> indices;
  for (const Triangle& t : mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
  std::string packed(meshopt_encodeIndexBufferBound(indices.size(), mesh.vertices.size()), '\0');
  packed.resize(meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(packed.data()), packed.size(), indices.data(), indices.size()));
  return packed;
}

inline std::string meshopt_indices(const TriangleMesh& mesh) {
  std::vector<unsigned> indices;
  for (const Triangle& t : mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
  std::string packed(meshopt_encodeIndexSequenceBound(indices.size(), mesh.vertices.size()), '\0');
  packed.resize(
      meshopt_encodeIndexSequence(reinterpret_cast<unsigned char*>(packed.data()), packed.size(), indices.data(), indices.size()));
  return packed;
}

}  // namespace hapton::sample
