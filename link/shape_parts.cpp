#include "link/shape_parts.h"

#include <algorithm>

namespace hapton {

bool ShapeParts::add(const ShapePart& part) noexcept {
  if (part.total != total() || part.first >= part.total) return false;
  std::copy_n(part.displacements_m.begin(), part.count(), displacements_m_.begin() + part.first);
  received_.set(part.number());
  return true;
}

std::uint32_t ShapeParts::first_missing() const noexcept {
  for (std::uint32_t part = 0; part < ShapePart::count_parts(total()); ++part) {
    if (!received_[part]) return part * ShapePart::kVerticesPerPart;
  }
  return total();
}

ShapePart make_shape_part(std::span<const ShapePart::Displacement> displacements_m, std::uint32_t first) noexcept {
  ShapePart part{.total = static_cast<std::uint32_t>(displacements_m.size()), .first = first};
  std::copy_n(displacements_m.begin() + first, part.count(), part.displacements_m.begin());
  return part;
}

}  // namespace hapton
