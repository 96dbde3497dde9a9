#include "patch/deforming_parts.h"

#include <algorithm>
#include <cmath>

#include "core/math/commanded_motion.h"

namespace hapton {
namespace {

constexpr double kSpeedRounding = 1e-6;     // more than the tolerance of scenes (1e-9, scene/object_deformation.cpp)
constexpr double kFloatRounding = 0x1p-23;  // relative, of a displacement, which is received as a float

bool is_same_deformation(const PatchDeformation& a, const PatchDeformation& b) {
  return a.first_tile == b.first_tile && a.tile_count == b.tile_count && a.displaced_count == b.displaced_count &&
         a.target_count == b.target_count && a.loops == b.loops && a.all_keys == b.all_keys;
}

double longest_of(const MorphTarget& target) {
  double longest = 0.0;
  for (const Vec3& by : target.displacements) longest = std::max(longest, by.norm());
  return longest;
}

bool is_slow_enough(const MeshDeformation& deformation) {
  const std::vector<MorphKey>& keys = deformation.keys();
  for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
    const double time_s = keys[i + 1].time_s - keys[i].time_s;
    double rounding = 0.0;
    for (std::size_t j = 0; j < deformation.targets().size(); ++j) {
      rounding += kFloatRounding * std::abs(keys[i + 1].weights[j] - keys[i].weights[j]) * longest_of(deformation.targets()[j]) / time_s;
    }
    if (!(deformation.fastest_per_s(i) <= kMaxSurfaceSpeed * (1.0 + kSpeedRounding) + rounding)) return false;
  }
  return true;
}

}  // namespace

bool DeformingParts::accept(const PatchDeformation& part) {
  if (!has_begun()) {
    head_ = part;
    keys_.assign(part.all_keys, MorphKey());
  }
  if (!is_same_deformation(head_, part)) return false;
  const std::size_t each = PatchDeformation::numbers_of_key(part.target_count);
  for (std::size_t n = 0; n < part.key_count; ++n) {
    MorphKey& key = keys_[part.first_key + n];
    received_keys_ += key.weights.empty() ? 1 : 0;
    const double* const numbers = part.keys.data() + n * each;
    key = {numbers[0], std::vector<double>(numbers + 1, numbers + each)};
  }
  return true;
}

bool DeformingParts::is_in_order() const {
  const auto is_later = [](const MorphKey& a, const MorphKey& b) { return !(a.time_s < b.time_s); };
  if (std::adjacent_find(keys_.begin(), keys_.end(), is_later) != keys_.end()) return false;
  return !head_.loops || (keys_.size() > 1 && keys_.front().weights == keys_.back().weights);
}

std::shared_ptr<const MeshDeformation> DeformingParts::make(std::span<const DisplacedTile> tiles) const {
  if (!is_in_order()) return nullptr;
  std::vector<std::map<std::uint32_t, Vec3>> moved(head_.target_count);
  for (const DisplacedTile& tile : tiles) {
    for (std::size_t v = 0; v < tile.vertices.size(); ++v) {
      const float* const by = tile.displaced->displacements_m.data() + 3 * v;
      const Vec3 by_m(static_cast<double>(by[0]), static_cast<double>(by[1]), static_cast<double>(by[2]));
      if (!by_m.isZero(0.0)) moved[tile.displaced->target].try_emplace(tile.vertices[v], by_m);
    }
  }
  std::vector<MorphTarget> targets(head_.target_count);
  for (std::size_t j = 0; j < targets.size(); ++j) {
    for (const auto& [vertex, by_m] : moved[j]) {
      targets[j].vertices.push_back(vertex);
      targets[j].displacements.push_back(by_m);
    }
  }
  auto deformation = std::make_shared<const MeshDeformation>(std::move(targets), keys_, head_.loops);
  return is_slow_enough(*deformation) ? deformation : nullptr;
}

}  // namespace hapton
