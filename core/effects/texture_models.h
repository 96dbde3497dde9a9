#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/effects/line_spectrum.h"

namespace hapton {

// The acceleration of a tool that slides over a surface at one speed and one normal force, as a random signal: white noise of this variance
// through the filter gain B(z) / A(z). Line spectral frequencies, in radians a sample, define A and B.
struct TextureModel {
  double speed_m_per_s = 0.0;
  double force_n = 0.0;
  std::vector<double> ar;  // line spectral frequencies of A
  std::vector<double> ma;  // line spectral frequencies of B; empty: B = 1
  double variance = 0.0;   // (m/s^2)^2
  double gain = 1.0;
};

using TextureTriangle = std::array<std::size_t, 3>;  // numbers of models, from 0

// Recorded models of one surface, with triangles over the plane of speed and force. Between models, line spectral frequencies, variance and
// gain are interpolated linearly over the triangle, so that every filter is stable: the frequencies of A keep at least kMinGap from 0, from
// pi and from each other, as in the models. Beyond the triangles the model is that of a nearby border. Threads: any may call blend.
// Source: Culbertson, Unger, Lopez Delgado and Kuchenbecker (2014), Modeling and rendering realistic textures from unconstrained
// tool-surface interactions, IEEE Transactions on Haptics 7(3).
class TextureModels {
 public:
  // Free choices that bound the memory and the time of a search.
  static constexpr std::size_t kMaxModels = 256;
  static constexpr std::size_t kMaxTriangles = 512;
  static constexpr double kMinRateHz = 100.0;
  static constexpr double kMaxRateHz = 10000.0;
  static constexpr double kMinGap = 0.01;    // rad
  static constexpr double kMaxRms = 1000.0;  // m/s^2

  // Error: what is wrong with which model or triangle, counted from 1: numbers that are not finite or out of range, different orders, a
  // filter that is not stable, one that is louder than kMaxRms, a triangle without area or with a model that does not exist, no model, no
  // triangle, too many of either. RT: set-up only.
  static Result<TextureModels> make(double rate_hz, std::vector<TextureModel> models, std::vector<TextureTriangle> triangles);

  // The model at one place of the plane.
  struct Blend {
    std::array<double, kMaxLines> a, b;  // coefficients of A and B after the first, which is 1
    double deviation = 0.0;              // standard deviation of the noise times the gain, m/s^2
  };

  // The model at a speed and force. triangle: that of the last blend, where the search begins; any number. RT: yes.
  void blend(double speed_m_per_s, double force_n, std::size_t& triangle, Blend& result) const noexcept;
  std::span<const double> ar(const Blend& blend) const noexcept { return std::span(blend.a).first(ar_order_); }
  std::span<const double> ma(const Blend& blend) const noexcept { return std::span(blend.b).first(ma_order_); }

  double rate_hz() const noexcept { return rate_hz_; }
  std::span<const TextureModel> models() const noexcept { return models_; }
  std::span<const TextureTriangle> triangles() const noexcept { return triangles_; }
  // Root mean square of the loudest model, m/s^2.
  double loudest_m_per_s2() const noexcept { return max_rms_; }

 private:
  // Shares of a triangle's first and second model, as linear functions of speed and force: constant, by speed, by force.
  struct Shares {
    std::array<double, 3> first, second;
  };
  using Weights = std::array<double, 3>;

  TextureModels() = default;
  Weights weights_at(std::size_t triangle, double speed_m_per_s, double force_n) const noexcept;
  Weights find(double speed_m_per_s, double force_n, std::size_t& triangle) const noexcept;

  double rate_hz_ = 0.0;
  std::size_t ar_order_ = 0;
  std::size_t ma_order_ = 0;
  double max_rms_ = 0.0;
  double max_speed_ = 0.0;
  double max_force_ = 0.0;
  std::vector<TextureModel> models_;
  std::vector<TextureTriangle> triangles_;
  std::vector<Shares> shares_;       // by triangle
  std::vector<double> frequencies_;  // by model: line spectral frequencies of A, then of B
};

}  // namespace hapton
