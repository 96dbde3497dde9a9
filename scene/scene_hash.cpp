#include "scene/scene_hash.h"

#include <bit>

namespace hapton {
namespace {

// Eight bytes at a time: xor, multiply by the golden ratio, fold the high half down (Knuth, TAOCP 6.4).
class Hash {
 public:
  void add(std::uint64_t value) noexcept {
    state_ = (state_ ^ value) * 0x9E3779B97F4A7C15ULL;
    state_ ^= state_ >> 32;
  }
  void add(double value) noexcept { add(std::bit_cast<std::uint64_t>(value)); }
  std::uint64_t value() const noexcept { return state_; }

 private:
  std::uint64_t state_ = 0x243F6A8885A308D3ULL;  // pi
};

void add_mesh(Hash& hash, const TriangleMesh& mesh) {
  hash.add(std::uint64_t{mesh.vertices.size()});
  hash.add(std::uint64_t{mesh.triangles.size()});
  for (const Vec3& v : mesh.vertices) {
    for (int k = 0; k < 3; ++k) hash.add(v[k]);
  }
  for (const Triangle& t : mesh.triangles) {
    hash.add(std::uint64_t{t[0]} << 32 | t[1]);
    hash.add(std::uint64_t{t[2]});
  }
}

}  // namespace

std::uint64_t hash_mesh(const TriangleMesh& mesh) {
  Hash hash;
  add_mesh(hash, mesh);
  return hash.value();
}

std::uint64_t hash_numbers(std::span<const double> numbers) {
  Hash hash;
  for (const double number : numbers) hash.add(number);
  return hash.value();
}

std::uint64_t combine_hashes(std::uint64_t first, std::uint64_t second) {
  Hash hash;
  hash.add(first);
  hash.add(second);
  return hash.value() == 0 ? 1 : hash.value();
}

std::uint64_t hash_scene(const TouchScene& scene) {
  Hash hash;
  hash.add(std::uint64_t{scene.objects.size()});
  for (const TouchObject& object : scene.objects) {
    add_mesh(hash, *object.mesh);
    const Material& m = object.material;
    for (const double value : {m.stiffness_n_per_m, m.damping_ns_per_m, m.friction_static, m.friction_dynamic}) hash.add(value);
    hash.add(std::uint64_t{m.two_sided});
  }
  return hash.value();
}

}  // namespace hapton
