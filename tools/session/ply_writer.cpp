#include "tools/session/ply_writer.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>

#include "runtime/atomic_file.h"

namespace hapton {
namespace {

static_assert(std::endian::native == std::endian::little, "the writer copies numbers as they lie in memory");

template <class T>
void append(std::string& bytes, const T& value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

}  // namespace

Result<void> write_ply(const std::filesystem::path& path, const TriangleMesh& mesh) {
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n"
      "element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
      mesh.vertices.size(), mesh.triangles.size());
  bytes.reserve(bytes.size() + 24 * mesh.vertices.size() + 13 * mesh.triangles.size());
  for (const Vec3& vertex : mesh.vertices) {
    for (int k = 0; k < 3; ++k) append(bytes, vertex[k]);
  }
  for (const Triangle& triangle : mesh.triangles) {
    append(bytes, std::uint8_t{3});
    for (const std::uint32_t index : triangle) append(bytes, index);
  }
  return write_file_atomically(path, bytes);
}

}  // namespace hapton
