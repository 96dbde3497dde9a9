#include "scene/normal_relief.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>
#include <vector>

#include <unsupported/Eigen/FFT>

namespace hapton {
namespace {

constexpr double kMinBlue = 0.1;          // least z of a unit normal: a slope of 10
constexpr double kHeightSteps = 65535.0;  // heights are rounded to this many steps, so that they are the same on every machine
constexpr int kMaxSide = 2048;            // largest side of the image that is transformed
constexpr double kMaxLengthError = 0.25;  // an image is no normal map if the mean length of its normals differs from 1 by more than this,
constexpr double kMinMeanZ = 0.3;         // or if their mean z is below this

// Slopes of the relief along u (the real part) and along v (the imaginary part), so that one transform handles both.
struct SlopeField {
  int width = 0;
  int height = 0;
  std::vector<std::complex<double>> slopes;

  std::complex<double>& at(int x, int y) {
    return slopes[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
};

Result<SlopeField> read_slopes(const ImageTexels& numbers, double scale) {
  SlopeField field{numbers.width, numbers.height, {}};
  field.slopes.reserve(numbers.values.size() / 3);
  double length = 0.0;
  double upright = 0.0;
  for (std::size_t i = 0; i + 2 < numbers.values.size(); i += 3) {
    const Vec3 normal = Vec3(numbers.values[i], numbers.values[i + 1], numbers.values[i + 2]) * (2.0 / 255.0) - Vec3::Ones();
    length += normal.norm();
    upright += normal.z();
    const double up = std::max(normal.z(), kMinBlue * std::max(normal.norm(), kMinBlue));
    field.slopes.emplace_back(-scale * normal.x() / up, scale * normal.y() / up);  // plus, because v increases downwards
  }
  const auto count = static_cast<double>(field.slopes.size());
  if (std::fabs(length / count - 1.0) > kMaxLengthError || upright / count < kMinMeanZ) {
    return fail("is not a normal map: most of its texels should be near red 128, green 128, blue 255");
  }
  return field;
}

SlopeField halve(SlopeField& field) {
  SlopeField half{std::max(1, field.width / 2), std::max(1, field.height / 2), {}};
  half.slopes.resize(static_cast<std::size_t>(half.width) * static_cast<std::size_t>(half.height));
  const int right = field.width > 1 ? 1 : 0;
  const int down = field.height > 1 ? 1 : 0;
  for (int y = 0; y < half.height; ++y) {
    for (int x = 0; x < half.width; ++x) {
      const int left = (1 + right) * x;
      const int top = (1 + down) * y;
      half.at(x, y) =
          0.25 * (field.at(left, top) + field.at(left + right, top) + field.at(left, top + down) + field.at(left + right, top + down));
    }
  }
  return half;
}

// Fourier transform in place, along both axes.
void transform(SlopeField& field, bool is_inverse) {
  Eigen::FFT<double> fft;
  const auto line = [&](int count, auto&& at) {
    if (count == 1) return;
    std::vector<std::complex<double>> in(static_cast<std::size_t>(count));
    std::vector<std::complex<double>> out;
    for (int i = 0; i < count; ++i) in[static_cast<std::size_t>(i)] = at(i);
    if (is_inverse) {
      fft.inv(out, in);
    } else {
      fft.fwd(out, in);
    }
    for (int i = 0; i < count; ++i) at(i) = out[static_cast<std::size_t>(i)];
  };
  for (int y = 0; y < field.height; ++y) line(field.width, [&](int x) -> std::complex<double>& { return field.at(x, y); });
  for (int x = 0; x < field.width; ++x) line(field.height, [&](int y) -> std::complex<double>& { return field.at(x, y); });
}

// Radians per metre of the wave number k. The highest wave number of an even count has no direction, so it gives 0.
double frequency(int k, int count, double length_m) {
  if (2 * k == count) return 0.0;
  return 2.0 * std::numbers::pi * (2 * k < count ? k : k - count) / length_m;
}

// Turns the transform of both slopes into that of the height H: for each wave, i wu H and i wv H come nearest to the two slopes.
void integrate(SlopeField& field, const Eigen::Vector2d& image_m) {
  constexpr std::complex<double> kI(0.0, 1.0);
  const auto height_of = [&](const std::complex<double>& here, const std::complex<double>& opposite, double wu, double wv) {
    const double squared = wu * wu + wv * wv;
    if (squared == 0.0) return std::complex<double>(0.0);
    const std::complex<double> along_u = 0.5 * (here + std::conj(opposite));
    const std::complex<double> along_v = -0.5 * kI * (here - std::conj(opposite));
    return -kI * (wu * along_u + wv * along_v) / squared;
  };
  for (int y = 0; y < field.height; ++y) {
    for (int x = 0; x < field.width; ++x) {
      const int other_x = (field.width - x) % field.width;
      const int other_y = (field.height - y) % field.height;
      if (other_y < y || (other_y == y && other_x < x)) continue;  // already done together with its opposite, because the height is real
      const std::complex<double> here = field.at(x, y);
      const std::complex<double> opposite = field.at(other_x, other_y);
      const double wu = frequency(x, field.width, image_m.x());
      const double wv = frequency(y, field.height, image_m.y());
      const std::complex<double> height = height_of(here, opposite, wu, wv);
      field.at(x, y) = height;
      field.at(other_x, other_y) = std::conj(height);
    }
  }
}

}  // namespace

Result<Relief> relief_of_normals(const ImageTexels& numbers, const Eigen::Vector2d& image_m, double scale) {
  auto field = read_slopes(numbers, scale);
  if (!field) return tl::unexpected(field.error());
  while (std::max(field->width, field->height) > kMaxSide) field = halve(*field);
  transform(*field, false);
  integrate(*field, image_m);
  transform(*field, true);
  const auto is_lower = [](const std::complex<double>& a, const std::complex<double>& b) { return a.real() < b.real(); };
  const auto [lowest, highest] = std::minmax_element(field->slopes.begin(), field->slopes.end(), is_lower);
  const auto height_m = static_cast<double>(static_cast<float>(highest->real() - lowest->real()));
  // For a flat map, only rounding errors remain.
  if (!(height_m > 0x1p-40 * image_m.maxCoeff())) return fail("is flat: all of its normals are the same");
  std::vector<float> texels;
  texels.reserve(field->slopes.size());
  for (const std::complex<double>& height : field->slopes) {
    texels.push_back(
        static_cast<float>(std::round(kHeightSteps * std::clamp((height.real() - lowest->real()) / height_m, 0.0, 1.0)) / kHeightSteps));
  }
  return Relief{SurfaceImage(field->width, field->height, std::move(texels)), height_m};
}

}  // namespace hapton
