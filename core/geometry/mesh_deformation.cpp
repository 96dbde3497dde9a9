#include "core/geometry/mesh_deformation.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hapton {

MeshDeformation::MeshDeformation(std::vector<MorphTarget> targets, std::vector<MorphKey> keys, bool loops)
    : targets_(std::move(targets)), keys_(std::move(keys)), loops_(loops) {
  for (const MorphTarget& target : targets_) moved_vertices_.insert(moved_vertices_.end(), target.vertices.begin(), target.vertices.end());
  std::sort(moved_vertices_.begin(), moved_vertices_.end());
  moved_vertices_.erase(std::unique(moved_vertices_.begin(), moved_vertices_.end()), moved_vertices_.end());
  displacements_.assign(targets_.size() * moved_vertices_.size(), Vec3::Zero());
  for (std::size_t j = 0; j < targets_.size(); ++j) {
    double longest = 0.0;
    for (std::size_t k = 0; k < targets_[j].vertices.size(); ++k) {
      const auto at = std::lower_bound(moved_vertices_.begin(), moved_vertices_.end(), targets_[j].vertices[k]) - moved_vertices_.begin();
      displacements_[j * moved_vertices_.size() + static_cast<std::size_t>(at)] = targets_[j].displacements[k];
      longest = std::max(longest, targets_[j].displacements[k].norm());
    }
    longest_displacement_.push_back(longest);
  }
}

double MeshDeformation::time_in_loop(double time_s) const noexcept {
  return loops_ && time_s > duration_s() ? std::fmod(time_s, duration_s()) : std::clamp(time_s, 0.0, duration_s());
}

MeshDeformation::Weights MeshDeformation::weights_at(double time_s) const noexcept {
  const double time = time_in_loop(time_s);
  const auto later = [](double t, const MorphKey& key) { return t < key.time_s; };
  const auto after = std::upper_bound(keys_.begin(), keys_.end(), time, later);
  const MorphKey& to = after == keys_.end() ? keys_.back() : *after;
  const MorphKey& from = after == keys_.begin() ? keys_.front() : *(after - 1);
  const double length = to.time_s - from.time_s;
  const double share = length > 0.0 ? (time - from.time_s) / length : 0.0;
  Weights weights = {};
  // In this form a weight that is equal at both keys is the same between them, to the last bit.
  for (std::size_t j = 0; j < targets_.size(); ++j) weights[j] = from.weights[j] + share * (to.weights[j] - from.weights[j]);
  return weights;
}

std::vector<Vec3> MeshDeformation::vertices_at(std::span<const Vec3> rest, const Weights& weights) const {
  std::vector<Vec3> vertices(rest.begin(), rest.end());
  for (std::size_t i = 0; i < moved_vertices_.size(); ++i) vertices[moved_vertices_[i]] = position_of(i, rest[moved_vertices_[i]], weights);
  return vertices;
}

double MeshDeformation::most_displacement(const Weights& a, const Weights& b) const noexcept {
  double most = 0.0;
  for (std::size_t j = 0; j < targets_.size(); ++j) most += std::fabs(a[j] - b[j]) * longest_displacement_[j];
  return most;
}

double MeshDeformation::fastest_per_s(std::size_t i) const {
  double most = 0.0;
  for (std::size_t v = 0; v < moved_vertices_.size(); ++v) {
    Vec3 motion = Vec3::Zero();
    for (std::size_t j = 0; j < targets_.size(); ++j) {
      motion += (keys_[i + 1].weights[j] - keys_[i].weights[j]) * displacements_[j * moved_vertices_.size() + v];
    }
    most = std::max(most, motion.norm());
  }
  return most / (keys_[i + 1].time_s - keys_[i].time_s);
}

bool operator==(const MeshDeformation& a, const MeshDeformation& b) {
  const auto same = [](const MorphTarget& s, const MorphTarget& t) {
    return s.vertices == t.vertices && s.displacements == t.displacements;
  };
  return a.loops() == b.loops() && a.keys() == b.keys() && std::ranges::equal(a.targets(), b.targets(), same);
}

}  // namespace hapton
