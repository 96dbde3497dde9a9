#include "core/tool/contact_choice.h"

#include <algorithm>

#include "core/tool/local_contacts.h"

namespace hapton {
namespace {

// The bounds that are chosen so far.
class Chosen {
 public:
  explicit Chosen(std::span<std::uint32_t> numbers) : numbers_(numbers.first(std::min(numbers.size(), LocalContacts::kMost))) {}

  bool is_full() const noexcept { return count_ == numbers_.size(); }
  bool has(std::uint32_t number) const noexcept {
    const auto end = numbers_.begin() + static_cast<std::ptrdiff_t>(count_);
    return std::find(numbers_.begin(), end, number) != end;
  }
  void add(std::uint32_t number, const MotionBound& bound) noexcept {
    bounds_[count_] = bound;
    numbers_[count_++] = number;
  }
  std::span<const MotionBound> bounds() const noexcept { return {bounds_.data(), count_}; }
  std::size_t count() const noexcept { return count_; }

 private:
  std::span<std::uint32_t> numbers_;
  std::array<MotionBound, LocalContacts::kMost> bounds_;
  std::size_t count_ = 0;
};

void choose_for(const Vec6& goal, std::span<const MotionBound> bounds, double tolerance, Chosen& chosen) noexcept {
  for (int cut = 0; cut < kMostCuts && !chosen.is_full(); ++cut) {
    const LeastMotion least = find_least_motion(goal, chosen.bounds(), tolerance);
    if (!least.solved) return;
    std::uint32_t worst = 0;
    double most = tolerance;
    for (std::uint32_t i = 0; i < bounds.size(); ++i) {
      const double violation = bounds[i].least - bounds[i].row.dot(least.y);
      if (violation > most) {
        most = violation;
        worst = i;
      }
    }
    if (!(most > tolerance) || chosen.has(worst)) return;
    chosen.add(worst, bounds[worst]);
  }
}

}  // namespace

std::size_t choose_contacts(std::span<const MotionBound> bounds, std::span<const Vec6> goals, double tolerance,
                            std::span<std::uint32_t> numbers) noexcept {
  Chosen chosen(numbers);
  for (const Vec6& goal : goals) choose_for(goal, bounds, tolerance, chosen);
  std::array<std::uint32_t, LocalContacts::kMost> nearest;
  std::size_t count = 0;
  const std::size_t most = std::min(numbers.size(), LocalContacts::kMost) - chosen.count();
  const auto has_less_room = [&](std::uint32_t a, std::uint32_t b) { return bounds[a].least > bounds[b].least; };
  for (std::uint32_t i = 0; i < bounds.size() && most > 0; ++i) {  // a heap with the one that has most room at its front
    if (count == most && !has_less_room(i, nearest[0])) continue;
    if (chosen.has(i)) continue;
    if (count == most) std::pop_heap(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(count--), has_less_room);
    nearest[count++] = i;
    std::push_heap(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(count), has_less_room);
  }
  for (std::size_t i = 0; i < count; ++i) chosen.add(nearest[i], bounds[nearest[i]]);
  return chosen.count();
}

}  // namespace hapton
