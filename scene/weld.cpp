#include "scene/weld.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

namespace hapton {
namespace {

constexpr std::uint32_t kNone = 0xffffffffU;
// The slot of a vertex in the hash table is prefetched this many vertices ahead: for a large mesh the slots are in no cache.
constexpr std::size_t kPrefetchDistance = 16;

std::uint64_t mix(std::uint64_t h) {
  // The finaliser of MurmurHash3.
  h = (h ^ (h >> 33)) * 0xff51afd7ed558ccdULL;
  h = (h ^ (h >> 33)) * 0xc4ceb9fe1a85ec53ULL;
  return h ^ (h >> 33);
}

// The start value of the hash. It differs each time, so that nobody can make a file whose vertices all get the same slot. The result of
// welding does not depend on it.
std::uint64_t random_start() {
  std::random_device random;
  return mix((std::uint64_t{random()} << 32) + random());
}

std::uint64_t hash(const Vec3& p, std::uint64_t start) {
  std::uint64_t h = start;
  for (int axis = 0; axis < 3; ++axis) h = mix(h + std::bit_cast<std::uint64_t>(p[axis]));
  return h;
}

// Numbers the vertices in the order in which the triangles first use them; same(v) is the vertex that represents v.
template <class Same>
void renumber(TriangleMesh& mesh, Same same) {
  std::vector<std::uint32_t> new_index(mesh.vertices.size(), kNone);
  std::vector<Vec3> kept_vertices;
  kept_vertices.reserve(mesh.vertices.size());
  for (Triangle& triangle : mesh.triangles) {
    for (std::uint32_t& corner : triangle) {
      if (new_index[corner] == kNone) {
        const std::uint32_t twin = same(corner);
        if (new_index[twin] == kNone) {
          new_index[twin] = static_cast<std::uint32_t>(kept_vertices.size());
          kept_vertices.push_back(mesh.vertices[twin]);
        }
        new_index[corner] = new_index[twin];
      }
      corner = new_index[corner];
    }
  }
  kept_vertices.shrink_to_fit();
  mesh.vertices = std::move(kept_vertices);
}

}  // namespace

void weld_vertices(TriangleMesh& mesh) {
  for (Vec3& vertex : mesh.vertices) vertex.array() += 0.0;  // -0 becomes 0
  // A hash table with open addressing, at most half full.
  std::vector<std::uint32_t> slots(std::bit_ceil(2 * mesh.vertices.size() + 1), kNone);
  const std::size_t mask = slots.size() - 1;
  const std::uint64_t start = random_start();
  std::array<std::size_t, kPrefetchDistance> home_slots = {};
  const auto prefetch_slot = [&](std::size_t v) {
    if (v >= mesh.vertices.size()) return;
    home_slots[v % kPrefetchDistance] = hash(mesh.vertices[v], start) & mask;
    __builtin_prefetch(&slots[home_slots[v % kPrefetchDistance]], 1);
  };
  for (std::size_t v = 0; v < kPrefetchDistance; ++v) prefetch_slot(v);
  std::vector<std::uint32_t> twin(mesh.vertices.size());
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    std::size_t slot = home_slots[v % kPrefetchDistance];
    prefetch_slot(v + kPrefetchDistance);
    while (slots[slot] != kNone && mesh.vertices[slots[slot]] != mesh.vertices[v]) slot = (slot + 1) & mask;
    if (slots[slot] == kNone) slots[slot] = static_cast<std::uint32_t>(v);
    twin[v] = slots[slot];
  }
  renumber(mesh, [&](std::uint32_t v) { return twin[v]; });
}

void drop_unused_vertices(TriangleMesh& mesh) {
  renumber(mesh, [](std::uint32_t v) { return v; });
}

}  // namespace hapton
