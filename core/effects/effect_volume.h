#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/math/types.h"

namespace hapton {

// Where an effect acts: everywhere, in a ball, or in a box along the axes of S. The boundary belongs to it. Units: m. RT: yes.
class EffectVolume {
 public:
  static EffectVolume everywhere() noexcept { return {}; }
  static EffectVolume ball(const Vec3& centre, double radius_m) noexcept { return {Shape::ball, centre, Vec3::Constant(radius_m)}; }
  static EffectVolume box(const Vec3& low, const Vec3& high) noexcept { return {Shape::box, 0.5 * (low + high), 0.5 * (high - low)}; }

  bool is_everywhere() const noexcept { return shape_ == Shape::everywhere; }
  bool contains(const Vec3& p) const noexcept {
    switch (shape_) {
      case Shape::everywhere:
        return true;
      case Shape::ball:
        return (p - centre_).squaredNorm() <= half_size_.x() * half_size_.x();
      case Shape::box:
        return ((p - centre_).cwiseAbs().array() <= half_size_.array()).all();
    }
    return false;
  }

  // The point of the volume that is nearest to p: p itself if it is inside.
  Vec3 nearest(const Vec3& p) const noexcept {
    if (contains(p)) return p;
    const Vec3 from = p - centre_;
    if (shape_ == Shape::ball) return centre_ + half_size_.x() / from.norm() * from;
    return centre_ + from.cwiseMax(-half_size_).cwiseMin(half_size_);
  }
  // The centre of a ball or box; meaningless for everywhere().
  const Vec3& centre() const noexcept { return centre_; }

  // The volume with these numbers, in the order in which for_each_number visits them. Nothing: no volume has these numbers.
  static std::optional<EffectVolume> from_numbers(const std::array<double, 7>& numbers) noexcept {
    const double shape = numbers[0];
    if (shape != 0.0 && shape != 1.0 && shape != 2.0) return std::nullopt;
    const Vec3 centre(numbers[1], numbers[2], numbers[3]);
    const Vec3 half_size(numbers[4], numbers[5], numbers[6]);
    if (!centre.allFinite() || !(half_size.array() >= 0.0).all() || !half_size.allFinite()) return std::nullopt;
    return EffectVolume(static_cast<Shape>(static_cast<int>(shape)), centre, half_size);
  }
  // Calls visit(number) for the seven numbers that define the volume.
  template <class Visit>
  void for_each_number(Visit&& visit) const {
    visit(static_cast<double>(shape_));
    for (int k = 0; k < 3; ++k) visit(centre_[k]);
    for (int k = 0; k < 3; ++k) visit(half_size_[k]);
  }

 private:
  enum class Shape : std::uint8_t { everywhere, ball, box };

  EffectVolume() = default;
  EffectVolume(Shape shape, const Vec3& centre, const Vec3& half_size) : shape_(shape), centre_(centre), half_size_(half_size) {}

  Shape shape_ = Shape::everywhere;
  Vec3 centre_ = Vec3::Zero();
  Vec3 half_size_ = Vec3::Zero();
};

}  // namespace hapton
