#include "core/effects/texture_voice.h"

#include <algorithm>
#include <cmath>

#include "core/effects/texture_models.h"
#include "core/effects/white_noise.h"

namespace hapton {
namespace {

// Far beyond any model. This bound keeps the memory of a filter finite, however fast the filter changes.
constexpr double kMaxAcceleration = 1e6;  // m/s^2

}  // namespace

void TextureVoice::begin() noexcept {
  if (is_fresh_) return;
  const std::uint64_t noise_count = noise_count_;
  const double interval_s = interval_s_;
  *this = {};
  noise_count_ = noise_count;
  interval_s_ = interval_s;
}

void TextureVoice::advance(const RecordedTexture& texture, double speed_m_per_s, double dt_s) noexcept {
  const TextureModels& models = *texture.models;
  since_newest_ += dt_s * models.rate_hz();
  if (since_newest_ < 1.0) return;
  TextureModels::Blend blend;
  models.blend(speed_m_per_s, pressed_n_, triangle_, blend);
  const auto ar = models.ar(blend);
  const auto ma = models.ma(blend);
  const double due = std::floor(since_newest_);
  since_newest_ -= due;
  const int count = static_cast<int>(std::min(due, double{kMaxSamples}));
  for (int n = 0; n < count; ++n) {
    const double noise = blend.deviation * white_noise(texture.seed, noise_count_++);
    const double shaped = noise + noises_.sum(ma);
    noises_.push(noise);
    const double acceleration = std::clamp(shaped - accelerations_.sum(ar), -kMaxAcceleration, kMaxAcceleration);
    accelerations_.push(acceleration);
    signal_.push(acceleration);
  }
}

Vec3 TextureVoice::force(const RecordedTexture& texture, const Vec3& v_SD, const Vec3& normal, double pressed_n, double dt_s) noexcept {
  dt_s = std::max(dt_s, 0.0);
  if (interval_s_ == 0.0) interval_s_ = dt_s;
  is_fresh_ = false;
  const double share = dt_s / (dt_s + kSmoothS);
  velocity_ += share * (v_SD - v_SD.dot(normal) * normal - velocity_);
  pressed_n_ += share * (pressed_n - pressed_n_);
  const double interval_s = std::min(dt_s, 2.0 * interval_s_);  // a longer gap counts as one missed step
  interval_s_ += interval_s / (interval_s + kIntervalS) * (interval_s - interval_s_);
  const Vec3 across = normal.cross(velocity_);
  const double speed_m_per_s = across.norm();
  advance(texture, speed_m_per_s, dt_s);
  if (!(speed_m_per_s > RecordedTexture::kRestMPerS)) return Vec3::Zero();
  const double acceleration = signal_.at(since_newest_, BandLimitedSignal::stride_for(interval_s_ * texture.models->rate_hz()));
  const double speed_gain = std::min(1.0, speed_m_per_s / RecordedTexture::kRestMPerS - 1.0);
  const double most_n = std::min(texture.max_force_n, pressed_n);
  return (std::clamp(texture.mass_kg * speed_gain * acceleration, -most_n, most_n) / speed_m_per_s) * across;
}

}  // namespace hapton
