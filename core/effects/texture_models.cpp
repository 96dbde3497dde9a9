#include "core/effects/texture_models.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/effects/sample_history.h"

namespace hapton {
namespace {

// Far beyond any recording.
constexpr double kMaxTextureSpeed = 10.0;   // m/s
constexpr double kMaxTextureForce = 100.0;  // N
constexpr double kMaxTextureNumber = 1e6;   // any other number of a model
// As a share of the largest speed times the largest force. The weights of the corners divide by the area: in a smaller triangle, fewer than
// seven of their digits would be left. Models have such a triangle only by mistake.
constexpr double kMinTextureArea = 1e-9;
// Samples of the impulse response whose energy counts.
constexpr int kResponseSamples = 8192;

// Within 1e-9 of the cosine for 0 to pi: the series of the sine of pi / 2 - x. Unlike the cosine of a library, the same on every machine.
double cosine(double x) noexcept {
  const double t = 0.5 * std::numbers::pi - x;
  const double s = t * t;
  const double series =
      1.0 + s * (-1.0 / 6 + s * (1.0 / 120 + s * (-1.0 / 5040 + s * (1.0 / 362880 + s * (-1.0 / 39916800 + s * (1.0 / 6227020800))))));
  return t * series;
}

bool is_within(double value, double most) noexcept { return value >= 0.0 && value <= most; }

// gap: the least distance between neighbours, and of each frequency from 0 and pi.
bool ascends(const std::vector<double>& frequencies, double gap) noexcept {
  double before = 0.0;
  for (const double frequency : frequencies) {
    if (!(frequency - before >= gap)) return false;
    before = frequency;
  }
  return frequencies.empty() || std::numbers::pi - before >= gap;
}

// Root mean square of the signal: that of the noise times the square root of the energy of the impulse response.
double rms_of(const TextureModel& model) {
  const auto cosines = [](const std::vector<double>& frequencies) {
    std::vector<double> made;
    for (const double frequency : frequencies) made.push_back(cosine(frequency));
    return made;
  };
  std::vector<double> a(model.ar.size());
  std::vector<double> b(model.ma.size());
  multiply_out({cosines(model.ar), a}, {cosines(model.ma), b});
  SampleHistory inputs, outputs;
  double energy = 0.0;
  for (int n = 0; n < kResponseSamples; ++n) {
    const double in = n == 0 ? 1.0 : 0.0;
    const double out = in + inputs.sum(b) - outputs.sum(a);
    inputs.push(in);
    outputs.push(out);
    energy += out * out;
  }
  return model.gain * std::sqrt(model.variance * energy);
}

Result<void> check_model(const TextureModel& model, const TextureModel& first, std::size_t number) {
  if (!is_within(model.speed_m_per_s, kMaxTextureSpeed))
    return fail("model {}: its speed is {} m/s: it must be 0 to {}", number, model.speed_m_per_s, kMaxTextureSpeed);
  if (!is_within(model.force_n, kMaxTextureForce))
    return fail("model {}: its force is {} N: it must be 0 to {}", number, model.force_n, kMaxTextureForce);
  if (!is_within(model.variance, kMaxTextureNumber))
    return fail("model {}: its variance is {}: it must be 0 to {}", number, model.variance, kMaxTextureNumber);
  if (!is_within(model.gain, kMaxTextureNumber))
    return fail("model {}: its gain is {}: it must be 0 to {}", number, model.gain, kMaxTextureNumber);
  if (model.ar.size() != first.ar.size() || model.ma.size() != first.ma.size())
    return fail("model {} has {} AR and {} MA coefficients, model 1 has {} and {}: make them equal", number, model.ar.size(),
                model.ma.size(), first.ar.size(), first.ma.size());
  if (!ascends(model.ar, TextureModels::kMinGap))
    return fail("model {} is not stable: its AR line spectral frequencies must ascend from 0 to pi, {} or more apart", number,
                TextureModels::kMinGap);
  if (!ascends(model.ma, 0.0)) return fail("model {}: its MA line spectral frequencies must ascend from 0 to pi", number);
  return {};
}

}  // namespace

Result<TextureModels> TextureModels::make(double rate_hz, std::vector<TextureModel> models, std::vector<TextureTriangle> triangles) {
  if (!(rate_hz >= kMinRateHz && rate_hz <= kMaxRateHz))
    return fail("the sample rate is {} Hz: it must be {} to {}", rate_hz, kMinRateHz, kMaxRateHz);
  if (models.empty() || models.size() > kMaxModels) return fail("there are {} models: give 1 to {}", models.size(), kMaxModels);
  if (triangles.empty() || triangles.size() > kMaxTriangles)
    return fail("there are {} triangles: give 1 to {}, so that models can be interpolated", triangles.size(), kMaxTriangles);
  TextureModels made;
  made.rate_hz_ = rate_hz;
  made.ar_order_ = models.front().ar.size();
  made.ma_order_ = models.front().ma.size();
  if (made.ar_order_ < 1 || made.ar_order_ > kMaxLines || made.ma_order_ > kMaxLines)
    return fail("model 1 has {} AR and {} MA coefficients: give 1 to {} and at most {}", made.ar_order_, made.ma_order_, kMaxLines,
                kMaxLines);
  for (std::size_t m = 0; m < models.size(); ++m) {
    const TextureModel& model = models[m];
    if (const auto fits = check_model(model, models.front(), m + 1); !fits) return tl::unexpected(fits.error());
    const double rms = rms_of(model);
    if (!(rms <= kMaxRms)) return fail("model {} has {} m/s^2 root mean square: it must be at most {}", m + 1, rms, kMaxRms);
    made.max_rms_ = std::max(made.max_rms_, rms);
    made.max_speed_ = std::max(made.max_speed_, model.speed_m_per_s);
    made.max_force_ = std::max(made.max_force_, model.force_n);
    made.frequencies_.insert(made.frequencies_.end(), model.ar.begin(), model.ar.end());
    made.frequencies_.insert(made.frequencies_.end(), model.ma.begin(), model.ma.end());
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (const std::size_t corner : triangles[t]) {
      if (corner >= models.size())
        return fail("triangle {} names model {} of {}: name models that exist", t + 1, corner + 1, models.size());
    }
    const TextureModel& a = models[triangles[t][0]];
    const TextureModel& b = models[triangles[t][1]];
    const TextureModel& c = models[triangles[t][2]];
    // Any place is c + shares of (a - c) and (b - c). Cramer's rule gives these shares.
    const double as = a.speed_m_per_s - c.speed_m_per_s, af = a.force_n - c.force_n;
    const double bs = b.speed_m_per_s - c.speed_m_per_s, bf = b.force_n - c.force_n;
    const double area = as * bf - af * bs;
    if (!(std::abs(area) > kMinTextureArea * made.max_speed_ * made.max_force_))
      return fail("triangle {} has no area: its models must differ in speed and force, and not be in one line", t + 1);
    const double cs = c.speed_m_per_s, cf = c.force_n;
    made.shares_.push_back(
        {.first = {(-bf * cs + bs * cf) / area, bf / area, -bs / area}, .second = {(af * cs - as * cf) / area, -af / area, as / area}});
  }
  made.models_ = std::move(models);
  made.triangles_ = std::move(triangles);
  return made;
}

TextureModels::Weights TextureModels::weights_at(std::size_t triangle, double speed_m_per_s, double force_n) const noexcept {
  const auto& [first, second] = shares_[triangle];
  const double a = first[0] + first[1] * speed_m_per_s + first[2] * force_n;
  const double b = second[0] + second[1] * speed_m_per_s + second[2] * force_n;
  return {a, b, 1.0 - a - b};
}

// Finds the triangle whose least weight is largest: it contains the place, or is one at the border. Negative weights become zero.
TextureModels::Weights TextureModels::find(double speed_m_per_s, double force_n, std::size_t& triangle) const noexcept {
  const auto least = [](const Weights& w) { return std::min({w[0], w[1], w[2]}); };
  if (triangle >= triangles_.size()) triangle = 0;
  Weights best = weights_at(triangle, speed_m_per_s, force_n);
  for (std::size_t t = 0; t < triangles_.size() && least(best) < 0.0; ++t) {
    const Weights weights = weights_at(t, speed_m_per_s, force_n);
    if (!(least(weights) > least(best))) continue;
    best = weights;
    triangle = t;
  }
  double sum = 0.0;
  for (double& weight : best) sum += weight = std::max(weight, 0.0);
  for (double& weight : best) weight /= sum;
  return best;
}

void TextureModels::blend(double speed_m_per_s, double force_n, std::size_t& triangle, Blend& result) const noexcept {
  const Weights weights = find(std::clamp(speed_m_per_s, 0.0, max_speed_), std::clamp(force_n, 0.0, max_force_), triangle);
  const TextureTriangle& corners = triangles_[triangle];
  const std::size_t count = ar_order_ + ma_order_;
  const double* a = frequencies_.data() + corners[0] * count;
  const double* b = frequencies_.data() + corners[1] * count;
  const double* c = frequencies_.data() + corners[2] * count;
  std::array<double, 2 * kMaxLines> cosines;
  for (std::size_t i = 0; i < count; ++i) cosines[i] = cosine(weights[0] * a[i] + weights[1] * b[i] + weights[2] * c[i]);
  multiply_out({std::span(cosines).first(ar_order_), std::span(result.a).first(ar_order_)},
               {std::span(cosines).subspan(ar_order_, ma_order_), std::span(result.b).first(ma_order_)});
  double variance = 0.0;
  double gain = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    variance += weights[k] * models_[corners[k]].variance;
    gain += weights[k] * models_[corners[k]].gain;
  }
  result.deviation = gain * std::sqrt(variance);
}

}  // namespace hapton
