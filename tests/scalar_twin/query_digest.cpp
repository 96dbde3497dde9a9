// Prints a checksum of the results of core/collision's queries, to the last bit. Built twice, with Float8 and with its scalar twin
// (core/math/float8.h): both must print the same.
#include <fmt/core.h>

#include <bit>
#include <cstdint>
#include <memory>
#include <random>

#include "core/collision/fdh_tree.h"
#include "core/collision/near_triangles.h"
#include "core/collision/touch_geometry.h"
#include "core/collision/triangle_pair.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

// FNV-1a, over words.
class Digest {
 public:
  void add(std::uint64_t word) { value_ = (value_ ^ word) * 0x100000001B3ULL; }
  void add(float x) { add(std::uint64_t{std::bit_cast<std::uint32_t>(x)}); }
  void add(double x) { add(std::bit_cast<std::uint64_t>(x)); }
  void add(const Vec3& v) {
    for (int k = 0; k < 3; ++k) add(v[k]);
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xCBF29CE484222325ULL;
};

constexpr std::uint64_t kSeed = 20261121;

class RandomNumbers {
 public:
  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vec3 vector(double size) { return {between(-size, size), between(-size, size), between(-size, size)}; }

 private:
  std::mt19937_64 random_{kSeed};
};

TriangleMesh make_rough_torus(RandomNumbers& numbers) {
  TriangleMesh mesh = make_torus(0.03, 0.012, 96, 48);
  for (Vec3& vertex : mesh.vertices) vertex += numbers.vector(1e-4);
  return mesh;
}

std::uint64_t digest_touch(const TouchGeometry& geometry, RandomNumbers& numbers) {
  Digest digest;
  for (std::uint32_t id = 0; id < geometry.triangle_count(); ++id) digest.add(std::uint64_t{geometry.is_walkable(id)});
  auto near = std::make_unique<NearTriangles>();
  for (int n = 0; n < 400; ++n) {
    const Vec3 p = numbers.vector(0.6);
    const Vec3 motion = numbers.vector(0.05);
    int queried = 0;
    if (near->gather(geometry, p, 0.1, queried)) {
      digest.add(std::uint64_t(near->count()));
      near->visit_near(p, p + 0.3 * motion, 0.04, [&](int slot) { digest.add(std::uint64_t{near->triangle(slot)}); });
    }
  }
  return digest.value();
}

std::uint64_t digest_hulls(const TriangleMesh& mesh, RandomNumbers& numbers) {
  Digest digest;
  const auto tree = FdhTree<14>::build(mesh.vertices, mesh.triangles);
  if (!tree) return 0;
  for (int n = 0; n < 400; ++n) {
    const Vec3 p = numbers.vector(0.05);
    tree->for_each_overlapping(FdhBall{p, 0.004}, [&](std::uint32_t triangle) { digest.add(std::uint64_t{triangle}); });
    tree->for_each_overlapping(FdhSweep{p, p + numbers.vector(0.02), 0.001},
                               [&](std::uint32_t triangle) { digest.add(std::uint64_t{triangle}); });
    digest.add(std::uint64_t{tree->find_nearest(p).triangle});
  }
  return digest.value();
}

std::uint64_t digest_pairs(RandomNumbers& numbers) {
  Digest digest;
  for (int n = 0; n < 400; ++n) {
    std::array<TrianglePair, 8> pairs;
    for (TrianglePair& pair : pairs) {
      for (int k = 0; k < 3; ++k) {
        pair.a[k] = numbers.vector(1.0);
        pair.b[k] = numbers.vector(1.0);
      }
    }
    TrianglePairs8 packed;
    TriangleContacts8 contacts;
    pack_8(pairs.data(), packed);
    intersect_8(packed, contacts);
    digest.add(std::uint64_t{contacts.meets} << 8 | contacts.undecided);
    for (int lane = 0; lane < 8; ++lane) {
      if ((contacts.meets >> lane & 1) == 0) continue;
      for (int k = 0; k < 3; ++k) {
        digest.add(contacts.begin[k][lane]);
        digest.add(contacts.end[k][lane]);
      }
      digest.add(contacts.error[lane]);
    }
  }
  return digest.value();
}

}  // namespace
}  // namespace hapton

int main() {
  using namespace hapton;
  RandomNumbers numbers;
  const TriangleMesh mesh = make_rough_torus(numbers);
  const TouchGeometry geometry({&mesh});
  const auto touch = digest_touch(geometry, numbers);
  const auto hulls = digest_hulls(mesh, numbers);
  const auto pairs = digest_pairs(numbers);
  fmt::print("seed {}, touch {:016x}, hulls {:016x}, pairs {:016x}\n", kSeed, touch, hulls, pairs);
}
