#include "remote_touch/deadband_coder.h"

#include <algorithm>

namespace hapton {

void PredictedSignal::update(const SignalUpdate& update, std::int64_t now_ns) noexcept {
  last_ = update;
  updated_ns_ = now_ns;
  has_value_ = true;
}

std::optional<Vec3> PredictedSignal::predict(std::int64_t now_ns) const noexcept {
  if (!has_value_) return std::nullopt;
  return last_.value + static_cast<double>(std::min(now_ns - updated_ns_, kLongestNs)) * last_.per_ns;
}

bool DeadbandCoder::note(const Vec3& value, std::int64_t now_ns) noexcept {
  recent_[count_++ % kSlopeRows] = {value, now_ns};
  const std::optional<Vec3> predicted = receiver_.predict(now_ns);
  return !predicted || (value - *predicted).norm() >= fraction_ * std::max(receiver_.value().norm(), min_norm_);
}

SignalUpdate DeadbandCoder::send() noexcept {
  const TimedValue& last = recent_[(count_ - 1) % kSlopeRows];
  const TimedValue& first = count_ < kSlopeRows ? recent_.front() : recent_[count_ % kSlopeRows];
  SignalUpdate update{last.value};
  const std::int64_t passed_ns = last.time_ns - first.time_ns;
  if (prediction_ == Prediction::linear && passed_ns > 0) update.per_ns = (last.value - first.value) / static_cast<double>(passed_ns);
  receiver_.update(update, last.time_ns);
  return update;
}

}  // namespace hapton
