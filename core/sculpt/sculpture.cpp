#include "core/sculpt/sculpture.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace hapton {
namespace {

// Hash FNV-1a, with whole floats in place of bytes.
std::uint64_t hash_values(const CarvedField& field) {
  std::uint64_t hash = 0xCBF29CE484222325ULL;
  for (const float value : field.values()) hash = (hash ^ std::bit_cast<std::uint32_t>(value)) * 0x100000001B3ULL;
  return hash;
}

}  // namespace

Result<void> Sculpture::add(int object, const SculptSettings& settings, const TriangleMesh& mesh) {
  auto field = CarvedField::make(mesh, settings.voxel_m);
  if (!field) return tl::unexpected(field.error());
  const std::uint64_t hash = hash_values(*field);
  bodies_.push_back({.object = object, .settings = settings, .field = std::move(*field), .rest_hash = hash});
  return {};
}

bool Sculpture::is_alike(const Sculpture& other) const noexcept {
  return std::equal(bodies_.begin(), bodies_.end(), other.bodies_.begin(), other.bodies_.end(), [](const Body& a, const Body& b) {
    return a.object == b.object && a.settings == b.settings && a.field.nodes() == b.field.nodes() &&
           a.field.origin_m() == b.field.origin_m() && a.rest_hash == b.rest_hash;
  });
}

void Sculpture::carve(std::size_t body, const Carve& carve) noexcept {
  if (!bodies_[body].field.would_change(carve)) return;
  bodies_[body].field.carve(carve);
  carve_of_step_ = MadeCarve{.object = bodies_[body].object,
                             .serial = ++newest_,
                             .carve = rounded(carve),
                             .begins = std::exchange(has_new_press_, false) || newest_ == 1};
}

void Sculpture::exchange_shapes(Sculpture& other, std::uint32_t newest) noexcept {
  std::swap(bodies_, other.bodies_);
  newest_ = newest;
  carve_of_step_.reset();
}

}  // namespace hapton
