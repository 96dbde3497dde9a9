#pragma once

#include <array>
#include <cstddef>

#include "core/math/types.h"

namespace hapton {

// Places of the device that are still to be felt, oldest first. Where there is no room for another, every second one is left out: the path
// gets coarser, never shorter. Frame: S. Units: SI. RT: all. Threads: one.
class DevicePath {
 public:
  static constexpr std::size_t kMost = 1024;  // a second at 1 kHz

  struct Place {
    Vec3 p_SD = Vec3::Zero();
    double dt_s = 0.0;  // since the one before
  };

  bool empty() const noexcept { return size_ == 0; }
  std::size_t size() const noexcept { return size_; }
  const Place& front() const noexcept { return places_[first_]; }
  const Place& operator[](std::size_t i) const noexcept { return places_[(first_ + i) % kMost]; }

  void clear() noexcept { first_ = size_ = 0; }
  void pop() noexcept {
    first_ = (first_ + 1) % kMost;
    --size_;
  }
  void push(const Place& place) noexcept {
    if (size_ == kMost) thin_out();
    at(size_++) = place;
  }

 private:
  static_assert(kMost % 2 == 0, "the newest place stays");

  Place& at(std::size_t i) noexcept { return places_[(first_ + i) % kMost]; }
  void thin_out() noexcept {
    for (std::size_t i = 0; i < size_ / 2; ++i) at(i) = {at(2 * i + 1).p_SD, at(2 * i).dt_s + at(2 * i + 1).dt_s};
    size_ /= 2;
  }

  std::array<Place, kMost> places_;
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

}  // namespace hapton
