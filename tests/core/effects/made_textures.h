#pragma once

#include <cmath>
#include <complex>
#include <memory>
#include <numbers>
#include <span>
#include <vector>

#include "core/effects/texture_models.h"

namespace hapton::made {

using Complex = std::complex<double>;

// A polynomial 1 + c_1 z^-1 + ... from its line spectral frequencies, multiplied out just as line_spectrum.h defines it.
inline std::vector<double> coefficients(std::span<const double> frequencies) {
  const auto times = [](const std::vector<double>& a, const std::vector<double>& b) {
    std::vector<double> product(a.size() + b.size() - 1, 0.0);
    for (std::size_t i = 0; i < a.size(); ++i) {
      for (std::size_t j = 0; j < b.size(); ++j) product[i + j] += a[i] * b[j];
    }
    return product;
  };
  std::vector<double> q = {1.0}, p = {1.0};
  for (std::size_t i = 0; i < frequencies.size(); ++i) {
    auto& side = i % 2 == 0 ? q : p;
    side = times(side, {1.0, -2.0 * std::cos(frequencies[i]), 1.0});
  }
  const bool is_even = frequencies.size() % 2 == 0;
  if (is_even) q = times(q, {1.0, 1.0});
  p = times(p, is_even ? std::vector<double>{1.0, -1.0} : std::vector<double>{1.0, 0.0, -1.0});
  std::vector<double> made;
  for (std::size_t i = 0; i <= frequencies.size(); ++i) made.push_back(0.5 * (q[i] + p[i]));
  return made;
}

inline double power_gain(std::span<const double> polynomial, double radians) {
  Complex sum = 0.0;
  for (std::size_t i = 0; i < polynomial.size(); ++i) sum += polynomial[i] * std::polar(1.0, -radians * static_cast<double>(i));
  return std::norm(sum);
}

// Power density of a model, (m/s^2)^2 / Hz, one-sided.
inline double density(const TextureModel& model, double rate_hz, double frequency_hz) {
  const double radians = 2.0 * std::numbers::pi * frequency_hz / rate_hz;
  const double filter = power_gain(coefficients(model.ma), radians) / power_gain(coefficients(model.ar), radians);
  return 2.0 * model.variance * model.gain * model.gain * filter / rate_hz;
}

// `order` line spectral frequencies over the band, shifted towards `peak` (0 to 1) by `sharpness`, and towards zero by `tilt`.
// With a sharpness of 0.3 to 0.6 and a tilt of 0.3 there is a resonance, and a fall by 50 dB over the band, as in recordings.
inline std::vector<double> frequencies(std::size_t order, double peak, double sharpness, double tilt = 0.0) {
  std::vector<double> made;
  for (std::size_t i = 1; i <= order; ++i) {
    const double uniform = static_cast<double>(i) / static_cast<double>(order + 1);
    const double distance = (uniform - peak) / 0.15;
    const double shifted = uniform - sharpness * (uniform - peak) * std::exp(-distance * distance);
    made.push_back(std::numbers::pi * (shifted - tilt * shifted * (1.0 - shifted)));
  }
  return made;
}

// Nine models over 0 to 0.2 m/s and 0 to 4 N, in eight triangles; silent at rest and without force. A higher speed is louder and higher.
inline std::vector<TextureModel> nine_models(std::size_t ar, std::size_t ma) {
  std::vector<TextureModel> models;
  for (int f = 0; f < 3; ++f) {
    for (int s = 0; s < 3; ++s) {
      models.push_back({.speed_m_per_s = 0.1 * s,
                        .force_n = 2.0 * f,
                        .ar = frequencies(ar, 0.15 + 0.15 * s, 0.3 + 0.15 * f, 0.3),
                        .ma = frequencies(ma, 0.8 - 0.1 * f, 0.3),
                        .variance = 0.05 * s * f,
                        .gain = 1.0 + 0.5 * s});
    }
  }
  return models;
}

inline std::vector<TextureTriangle> eight_triangles() {
  std::vector<TextureTriangle> triangles;
  for (std::size_t f = 0; f < 2; ++f) {
    for (std::size_t s = 0; s < 2; ++s) {
      const std::size_t corner = 3 * f + s;
      triangles.push_back({corner, corner + 1, corner + 3});
      triangles.push_back({corner + 1, corner + 4, corner + 3});
    }
  }
  return triangles;
}

inline std::shared_ptr<const TextureModels> texture(double rate_hz, std::size_t ar, std::size_t ma) {
  auto models = TextureModels::make(rate_hz, nine_models(ar, ma), eight_triangles());
  return models ? std::make_shared<const TextureModels>(std::move(*models)) : nullptr;
}

// The model at one speed and force, interpolated by the definition: linear over the triangle that contains them.
inline TextureModel interpolated(const TextureModels& models, double speed_m_per_s, double force_n) {
  TextureModel made;
  for (const TextureTriangle& triangle : models.triangles()) {
    const TextureModel& a = models.models()[triangle[0]];
    const TextureModel& b = models.models()[triangle[1]];
    const TextureModel& c = models.models()[triangle[2]];
    const auto area = [](double s0, double f0, double s1, double f1) { return s0 * f1 - s1 * f0; };
    const auto share = [&](const TextureModel& p, const TextureModel& q) {
      const double whole_area =
          area(a.speed_m_per_s - c.speed_m_per_s, a.force_n - c.force_n, b.speed_m_per_s - c.speed_m_per_s, b.force_n - c.force_n);
      return area(p.speed_m_per_s - speed_m_per_s, p.force_n - force_n, q.speed_m_per_s - speed_m_per_s, q.force_n - force_n) / whole_area;
    };
    const double wa = share(b, c), wb = share(c, a), wc = share(a, b);
    if (wa < -1e-9 || wb < -1e-9 || wc < -1e-9) continue;
    made = a;
    for (std::size_t i = 0; i < a.ar.size(); ++i) made.ar[i] = wa * a.ar[i] + wb * b.ar[i] + wc * c.ar[i];
    for (std::size_t i = 0; i < a.ma.size(); ++i) made.ma[i] = wa * a.ma[i] + wb * b.ma[i] + wc * c.ma[i];
    made.variance = wa * a.variance + wb * b.variance + wc * c.variance;
    made.gain = wa * a.gain + wb * b.gain + wc * c.gain;
    made.speed_m_per_s = speed_m_per_s;
    made.force_n = force_n;
    return made;
  }
  return made;
}

}  // namespace hapton::made
