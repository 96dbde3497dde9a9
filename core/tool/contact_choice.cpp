#include "core/tool/contact_choice.h"

#include <algorithm>
#include <array>

namespace hapton {
namespace {

// The bounds that are chosen so far, from all bounds.
class ChosenBounds {
 public:
  ChosenBounds(std::span<const MotionBound> all, const LocalContacts& metric, std::span<std::uint32_t> numbers)
      : all_(all), metric_(metric), numbers_(numbers.first(std::min(numbers.size(), LocalContacts::kMax))) {
    roots_[kCurved] = metric.inverse_root;
    roots_[kPlain] = metric.plain_inverse_root.asDiagonal();
  }

  std::size_t count() const noexcept { return count_; }
  std::size_t free_places() const noexcept { return numbers_.size() - count_; }
  bool has(std::uint32_t number) const noexcept {
    const auto end = numbers_.begin() + static_cast<std::ptrdiff_t>(count_);
    return std::find(numbers_.begin(), end, number) != end;
  }
  void add(std::uint32_t number) noexcept {
    for (std::size_t m = 0; m < roots_.size(); ++m) bounds_[m][count_] = {roots_[m].transpose() * all_[number].row, least_of(number)};
    numbers_[count_++] = number;
  }

  // Adds bounds until the motion to `goal` within the chosen bounds is that within all bounds, or most_cuts are added in each metric, or no
  // place is left. False: the chosen bounds contradicted each other and were lowered, so those added for earlier goals may not suffice.
  bool add_bounds_for(const Vec6& goal, int most_cuts) noexcept {
    if (is_free(goal) && !add_violated(goal)) return true;
    for (const Metric metric : {kCurved, kPlain}) {
      LeastMotion least;
      for (int cut = 0; cut <= most_cuts; ++cut) {
        const Vec6 pull = roots_[metric].transpose() * metric_.stiffness.cwiseProduct(goal);
        least = find_least_motion(pull, {bounds_[metric].data(), count_}, metric_.tolerance);
        if (!least.solved) return !relax();
        if (cut == most_cuts || !add_violated(roots_[metric] * least.y)) break;
      }
      if (least.active_count > 0) break;
    }
    return true;
  }

 private:
  enum Metric : std::size_t { kCurved, kPlain };

  double least_of(std::uint32_t number) const noexcept { return is_relaxed_ ? std::min(all_[number].least, 0.0) : all_[number].least; }
  bool is_free(const Vec6& motion) const noexcept {
    return std::all_of(numbers_.begin(), numbers_.begin() + static_cast<std::ptrdiff_t>(count_),
                       [&](std::uint32_t number) { return all_[number].row.dot(motion) >= least_of(number) - metric_.tolerance; });
  }
  // Adds the bound that the motion violates most, of all bounds. False: none was added; none is violated, or no place is left.
  bool add_violated(const Vec6& motion) noexcept {
    if (free_places() == 0) return false;
    std::uint32_t worst = 0;
    double most = metric_.tolerance;
    for (std::uint32_t i = 0; i < all_.size(); ++i) {
      const double violation = least_of(i) - all_[i].row.dot(motion);
      if (violation > most) {
        most = violation;
        worst = i;
      }
    }
    if (!(most > metric_.tolerance) || has(worst)) return false;
    add(worst);
    return true;
  }
  // Lowers the bounds so that zero motion satisfies them. False: they are lowered already, and contradict each other by rounding.
  bool relax() noexcept {
    if (is_relaxed_) return false;
    is_relaxed_ = true;
    for (auto& bounds : bounds_) {
      for (std::size_t i = 0; i < count_; ++i) bounds[i].least = std::min(bounds[i].least, 0.0);
    }
    return true;
  }

  std::span<const MotionBound> all_;
  const LocalContacts& metric_;
  std::array<Mat6, 2> roots_;
  std::span<std::uint32_t> numbers_;
  std::array<std::array<MotionBound, LocalContacts::kMax>, 2> bounds_;  // in the coordinates of each metric
  std::size_t count_ = 0;
  bool is_relaxed_ = false;
};

void choose_for_all(std::span<const Vec6> goals, ChosenBounds& chosen) noexcept {
  if (goals.empty()) return;
  // Searches the first goal again at the end, with as many cuts as there are places. Begins anew if bounds were lowered.
  for (std::size_t g = 0; g <= goals.size();) {
    const bool is_last = g == goals.size();
    const bool is_held = chosen.add_bounds_for(goals[is_last ? 0 : g], is_last ? static_cast<int>(LocalContacts::kMax) : kMaxCuts);
    g = is_held ? g + 1 : 0;
  }
}

}  // namespace

std::size_t choose_contacts(std::span<const MotionBound> bounds, std::span<const Vec6> goals, const LocalContacts& metric,
                            std::span<std::uint32_t> numbers) noexcept {
  ChosenBounds chosen(bounds, metric, numbers);
  choose_for_all(goals, chosen);
  std::array<std::uint32_t, LocalContacts::kMax> nearest;
  std::size_t count = 0;
  const std::size_t most = chosen.free_places();
  const auto is_nearer_bound = [&](std::uint32_t a, std::uint32_t b) { return bounds[a].least > bounds[b].least; };
  for (std::uint32_t i = 0; i < bounds.size() && most > 0; ++i) {  // a heap, the bound with the most room at its front
    if (count == most && !is_nearer_bound(i, nearest[0])) continue;
    if (chosen.has(i)) continue;
    if (count == most) std::pop_heap(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(count--), is_nearer_bound);
    nearest[count++] = i;
    std::push_heap(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(count), is_nearer_bound);
  }
  for (std::size_t i = 0; i < count; ++i) chosen.add(nearest[i]);
  return chosen.count();
}

}  // namespace hapton
