#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/math/types.h"

namespace hapton {

// Displacements of some vertices of a mesh: a morph target of glTF 2.0.
struct MorphTarget {
  std::vector<std::uint32_t> vertices;  // indices into the vertices of the mesh, ascending; the other vertices stay at rest
  std::vector<Vec3> displacements;      // one for each of `vertices`, at a weight of 1
};

// The weight of each target at one time.
struct MorphKey {
  double time_s = 0.0;
  std::vector<double> weights;  // one for each target

  friend bool operator==(const MorphKey&, const MorphKey&) = default;
};

// The deformation of a mesh that is known beforehand: vertex v is at rest(v) + sum of weight_j * displacement_j(v). Between two keys the
// weights change linearly (LINEAR samplers of glTF 2.0), so every vertex moves straight. Before the first key the weights are those of
// that key; after the last they stay, or begin again if it loops. A function of time alone. Frame and units: the mesh's. RT: yes, except
// construction, vertices_at, fastest_per_s and ==, which are set-up only. Threads: const calls from any number.
class MeshDeformation {
 public:
  // A free choice: the time that a step takes grows in proportion to the number of targets whose weight is not 0.
  static constexpr std::size_t kMaxTargets = 16;
  using Weights = std::array<double, kMaxTargets>;  // of the targets, in order; unused ones are 0

  // Pre: 1 to kMaxTargets targets, none with a vertex twice; one key or more, at times from 0 on, each later than the one before. If the
  // motion loops, the first and the last key have the same weights.
  MeshDeformation(std::vector<MorphTarget> targets, std::vector<MorphKey> keys, bool loops);

  // The weights at a time. Pre: the time is finite. A time before 0 counts as 0.
  Weights weights_at(double time_s) const noexcept;
  // The time since the motion last began again; if it does not loop, at most the time of the last key. Pre: a loop has duration_s() > 0.
  double time_in_loop(double time_s) const noexcept;

  // All vertices that any target moves, ascending.
  std::span<const std::uint32_t> moved() const { return moved_vertices_; }
  // The position of moved()[i], whose position at rest is `rest`.
  Vec3 position_of(std::size_t i, const Vec3& rest, const Weights& weights) const noexcept {
    Vec3 p = rest;
    for (std::size_t j = 0; j < targets_.size(); ++j) {
      if (weights[j] != 0.0) p += weights[j] * displacements_[j * moved_vertices_.size() + i];
    }
    return p;
  }
  // The positions of all vertices of the mesh.
  std::vector<Vec3> vertices_at(std::span<const Vec3> rest, const Weights& weights) const;

  // An upper bound of the distance between the positions of any one vertex with weights `a` and with weights `b`.
  double most_displacement(const Weights& a, const Weights& b) const noexcept;
  // The largest speed of a vertex between keys i and i + 1. Pre: there is a key i + 1.
  double fastest_per_s(std::size_t i) const;

  const std::vector<MorphTarget>& targets() const { return targets_; }
  const std::vector<MorphKey>& keys() const { return keys_; }
  bool loops() const { return loops_; }
  // The time until the motion ends or begins again.
  double duration_s() const { return keys_.back().time_s; }

 private:
  std::vector<MorphTarget> targets_;
  std::vector<MorphKey> keys_;
  bool loops_;
  std::vector<std::uint32_t> moved_vertices_;
  std::vector<Vec3> displacements_;  // of the vertices moved_vertices_, target by target; 0 for a vertex that the target does not move
  std::vector<double> longest_displacement_;  // the largest displacement of a vertex, for each target
};

// Whether all numbers are equal, and both loop or neither does.
bool operator==(const MeshDeformation& a, const MeshDeformation& b);

}  // namespace hapton
