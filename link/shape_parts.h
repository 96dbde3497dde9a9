#pragma once

#include <bitset>
#include <cstdint>
#include <span>
#include <vector>

#include "link/messages.h"

namespace hapton {

// Collects the parts of a shape of an object that programs deform, in any order. RT: yes, except construction. Threads: one.
class ShapeParts {
 public:
  // total: number of vertices of the mesh, at most ShapePart::kMaxVertices. Allocates the memory for all of them.
  explicit ShapeParts(std::uint32_t total = 0) : displacements_m_(total) {}

  // Forgets what has come.
  void clear() noexcept { received_.reset(); }
  // False: the part belongs to a shape with another number of vertices. Pre: protobuf_codec has checked the part.
  bool add(const ShapePart& part) noexcept;

  std::uint32_t total() const noexcept { return static_cast<std::uint32_t>(displacements_m_.size()); }
  bool is_whole() const noexcept { return received_.count() == ShapePart::count_parts(total()); }
  // True while no part has come.
  bool is_empty() const noexcept { return received_.none(); }
  // The first vertex of the first part that is missing; total() if none is.
  std::uint32_t first_missing() const noexcept;
  bool has(std::uint32_t part) const noexcept { return received_[part]; }
  // One for each vertex of the mesh; any value where a part is missing.
  std::span<const ShapePart::Displacement> displacements_m() const noexcept { return displacements_m_; }

 private:
  std::vector<ShapePart::Displacement> displacements_m_;
  std::bitset<ShapePart::kMaxParts> received_;
};

// Makes the part that begins at `first`. Pre: `first` is a vertex, and a multiple of ShapePart::kVerticesPerPart. RT: yes.
ShapePart make_shape_part(std::span<const ShapePart::Displacement> displacements_m, std::uint32_t first) noexcept;

}  // namespace hapton
