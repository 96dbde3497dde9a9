#pragma once

#include <bitset>
#include <cstdint>
#include <span>
#include <vector>

#include "link/messages.h"

namespace hapton {

// A shape of an object that programs deform, as its parts come, in any order. RT: yes, except construction. Threads: one.
class ShapeParts {
 public:
  // total: vertices of the mesh. Takes the memory for all.
  explicit ShapeParts(std::uint32_t total = 0) : displacements_m_(total) {}

  // Forgets what has come.
  void clear() noexcept { received_.reset(); }
  // False: it is not of a shape of so many vertices. Pre: as protobuf_codec reads it.
  bool add(const ShapePart& part) noexcept;

  std::uint32_t total() const noexcept { return static_cast<std::uint32_t>(displacements_m_.size()); }
  bool is_whole() const noexcept { return received_.count() == ShapePart::count_parts(total()); }
  // Nothing has come yet.
  bool is_empty() const noexcept { return received_.none(); }
  // The first vertex of the first part that is missing; total() if it is whole.
  std::uint32_t first_missing() const noexcept;
  bool has(std::uint32_t part) const noexcept { return received_[part]; }
  // By vertex of the mesh; of what is missing, any.
  std::span<const ShapePart::Displacement> displacements_m() const noexcept { return displacements_m_; }

 private:
  std::vector<ShapePart::Displacement> displacements_m_;
  std::bitset<ShapePart::kMaxParts> received_;
};

// The part that begins at that vertex. Pre: first is below the number of displacements, and a multiple of ShapePart::kMaxHere. RT: yes.
ShapePart make_shape_part(std::span<const ShapePart::Displacement> displacements_m, std::uint32_t first) noexcept;

}  // namespace hapton
