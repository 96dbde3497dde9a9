#include "vision_node/stroke_thinner.h"

#include <algorithm>
#include <utility>

namespace hapton {
namespace {

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double squared = along.squaredNorm();
  const double t = squared > 0.0 ? std::clamp((p - a).dot(along) / squared, 0.0, 1.0) : 0.0;
  return (p - a - t * along).norm();
}

}  // namespace

bool StrokeThinner::covers_window(const Vec3& from, const Vec3& to) const {
  return std::ranges::all_of(window_, [&](const Vec3& p) { return distance_to_segment(p, from, to) <= 0.5 * bound_m_; });
}

bool StrokeThinner::add(const Vec3& p) {
  if (points_.empty()) {
    points_.push_back(p);
    return true;
  }
  if ((p - points_.back()).norm() <= 0.5 * bound_m_) return false;
  const bool goes_on = !std::exchange(is_last_kept_, false) && points_.size() > 1 && window_.size() < kMaxWindow &&
                       covers_window(points_[points_.size() - 2], p);
  if (goes_on) {
    points_.back() = p;
  } else {
    window_.clear();
    points_.push_back(p);
  }
  window_.push_back(p);
  return true;
}

}  // namespace hapton
