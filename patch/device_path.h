#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "core/math/types.h"

namespace hapton {

// Positions of the device through which the proxy has not followed it yet, oldest first. If the path is full, every second position is
// removed, and from then on later positions are kept as far apart as those that remain. So the path gets coarser, uniformly, but never
// shorter. The newest position is always kept. Frame: S. Units: SI. RT: yes. Threads: one.
class DevicePath {
 public:
  static constexpr std::size_t kMax = 1024;  // a second at 1 kHz

  struct Place {
    Vec3 p_SD = Vec3::Zero();
    double dt_s = 0.0;    // since the position before
    double time_s = 0.0;  // scene time
  };

  bool empty() const noexcept { return size_ == 0; }
  std::size_t size() const noexcept { return size_; }
  const Place& front() const noexcept { return places_[first_]; }
  const Place& operator[](std::size_t i) const noexcept { return places_[(first_ + i) % kMax]; }

  void clear() noexcept {
    first_ = size_ = 0;
    spacing_m_ = 0.0;
  }
  void pop() noexcept {
    first_ = (first_ + 1) % kMax;
    if (--size_ == 0) clear();
  }
  // Keeps only positions that are younger than this; the age of the newest is 0. An age_s of 0 or less keeps none.
  void keep_newest(double age_s) noexcept {
    std::size_t kept = 0;
    for (double ago_s = 0.0; kept < size_ && ago_s < age_s; ++kept) ago_s += at(size_ - 1 - kept).dt_s;
    while (size_ > kept) pop();
  }
  // Pre: not empty.
  void replace_newest(const Vec3& p_SD) noexcept { at(size_ - 1).p_SD = p_SD; }
  void push(const Place& place) noexcept {
    if (size_ >= 2 && (place.p_SD - at(size_ - 2).p_SD).norm() <= spacing_m_) {
      at(size_ - 1) = {place.p_SD, at(size_ - 1).dt_s + place.dt_s, place.time_s};
      return;
    }
    if (size_ == kMax) thin_out();
    at(size_++) = place;
  }

 private:
  static_assert(kMax % 2 == 0, "the newest place stays");

  Place& at(std::size_t i) noexcept { return places_[(first_ + i) % kMax]; }
  void thin_out() noexcept {
    double length_m = 0.0;
    for (std::size_t i = 1; i < size_; ++i) length_m += (at(i).p_SD - at(i - 1).p_SD).norm();
    spacing_m_ = 2.0 * std::max(spacing_m_, length_m / static_cast<double>(size_));
    for (std::size_t i = 0; i < size_ / 2; ++i) at(i) = {at(2 * i + 1).p_SD, at(2 * i).dt_s + at(2 * i + 1).dt_s, at(2 * i + 1).time_s};
    size_ /= 2;
  }

  std::array<Place, kMax> places_;
  std::size_t first_ = 0;
  std::size_t size_ = 0;
  double spacing_m_ = 0.0;  // least distance of positions that are added
};

}  // namespace hapton
