#include "scene/normal_relief.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <numbers>

#include "tests/scene/made_pictures.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

constexpr double kFullTurn = 2.0 * std::numbers::pi;

// The slopes of a relief along u and v. normal_map() asks for them at the centre of each texel, with u and v from 0 to 1.
struct Slopes {
  double u = 0.0, v = 0.0;
};

template <class SlopesAt>
ImageTexels normal_map(int width, int height, SlopesAt slopes_at) {
  ImageTexels texels{width, height, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Slopes slopes = slopes_at((x + 0.5) / width, (y + 0.5) / height);
      const Vec3 normal = Vec3(-slopes.u, slopes.v, 1.0).normalized();  // the green channel counts upwards, v downwards
      for (int k = 0; k < 3; ++k) texels.values.push_back(static_cast<std::uint8_t>(std::lround(127.5 * (normal[k] + 1.0))));
    }
  }
  return texels;
}

// The sum of two waves over an image of 80 x 50 mm.
const Eigen::Vector2d kImageM(0.08, 0.05);
double wave_m(double u, double v) { return 0.0008 * std::sin(3.0 * kFullTurn * u) + 0.0005 * std::cos(kFullTurn * (2.0 * u - v)); }
Slopes wave_slopes(double u, double v) {
  const double second_wave_slope = -0.0005 * kFullTurn * std::sin(kFullTurn * (2.0 * u - v));
  return {(0.0008 * 3.0 * kFullTurn * std::cos(3.0 * kFullTurn * u) + 2.0 * second_wave_slope) / kImageM.x(),
          -second_wave_slope / kImageM.y()};
}

// The largest difference of relief and wave in metres, when the highest point of each is at height 0.
double error_of(const Relief& relief, double scale) {
  double highest = -1.0;
  for (int i = 0; i < 400 * 400; ++i) highest = std::max(highest, wave_m(i % 400 / 400.0, i / 400 / 400.0));
  double worst = 0.0;
  for (int y = 0; y < relief.image.height(); ++y) {
    for (int x = 0; x < relief.image.width(); ++x) {
      const double u = (x + 0.5) / relief.image.width();
      const double v = (y + 0.5) / relief.image.height();
      const float texel = relief.image.texels()[static_cast<std::size_t>(y * relief.image.width() + x)];
      worst = std::max(worst, std::fabs((texel - 1.0) * relief.height_m - scale * (wave_m(u, v) - highest)));
    }
  }
  return worst;
}

TEST(NormalRelief, HasTheHeightsWhoseNormalsTheMapHas) {
  const ImageTexels map = normal_map(128, 96, wave_slopes);
  const auto relief = relief_of_normals(map, kImageM, 1.0);
  ASSERT_TRUE(relief) << relief.error().what;
  EXPECT_EQ(relief->image.width(), 128);
  EXPECT_EQ(relief->image.height(), 96);
  EXPECT_LT(error_of(*relief, 1.0), 0.01 * relief->height_m) << "8 bits a value";
  const auto doubled = relief_of_normals(map, kImageM, 2.0);
  ASSERT_TRUE(doubled);
  EXPECT_LT(error_of(*doubled, 2.0), 0.01 * doubled->height_m);
}

TEST(NormalRelief, OddSidesAndSingleRowsWorkToo) {
  const auto odd = relief_of_normals(normal_map(63, 41, wave_slopes), kImageM, 1.0);
  ASSERT_TRUE(odd);
  EXPECT_LT(error_of(*odd, 1.0), 0.02 * odd->height_m);
  const auto row = relief_of_normals(normal_map(64, 1,
                                                [](double u, double) {
                                                  return Slopes{0.3 * std::cos(kFullTurn * u), 0.0};
                                                }),
                                     {0.1, 0.1}, 1.0);
  ASSERT_TRUE(row);
  EXPECT_NEAR(row->height_m, 2.0 * 0.3 * 0.1 / kFullTurn, 0.02 * row->height_m);
}

TEST(NormalRelief, ATiltOfTheWholeMapIsLeftOut) {
  const auto tilted = [](double u, double v) { return Slopes{wave_slopes(u, v).u + 0.1, wave_slopes(u, v).v - 0.05}; };
  const auto relief = relief_of_normals(normal_map(128, 96, tilted), kImageM, 1.0);
  ASSERT_TRUE(relief);
  EXPECT_LT(error_of(*relief, 1.0), 0.015 * relief->height_m);
}

TEST(NormalRelief, LargeMapsAreAveraged) {
  const auto relief = relief_of_normals(normal_map(4096, 64, wave_slopes), kImageM, 1.0);
  ASSERT_TRUE(relief);
  EXPECT_EQ(relief->image.width(), 2048);
  EXPECT_EQ(relief->image.height(), 32);
  EXPECT_LT(error_of(*relief, 1.0), 0.02 * relief->height_m);
}

TEST(NormalRelief, SaysWhatIsNoNormalMap) {
  ImageTexels picture{16, 16, std::vector<std::uint8_t>(3 * 256, 40)};
  EXPECT_THAT(relief_of_normals(picture, kImageM, 1.0).error().what, HasSubstr("not a normal map"));
  picture.values.assign(3 * 256, 128);
  EXPECT_THAT(relief_of_normals(picture, kImageM, 1.0).error().what, HasSubstr("not a normal map"));
  const auto flat = normal_map(16, 16, [](double, double) { return Slopes(); });
  EXPECT_THAT(relief_of_normals(flat, kImageM, 1.0).error().what, HasSubstr("flat"));
}

// A chunk of a PNG file: length, type, data, checksum.
std::string chunk(const std::string& type, const std::string& data) {
  const auto number = [](std::uint32_t n) {
    return std::string{static_cast<char>(n >> 24U), static_cast<char>(n >> 16U), static_cast<char>(n >> 8U), static_cast<char>(n)};
  };
  const std::string body = type + data;
  const auto sum = crc32(0, reinterpret_cast<const unsigned char*>(body.data()), static_cast<unsigned>(body.size()));
  return number(static_cast<std::uint32_t>(data.size())) + body + number(static_cast<std::uint32_t>(sum));
}

TEST(NormalRelief, NumbersAreReadAsTheyAreWhateverTheirColourSpace) {
  const ImageTexels map = normal_map(32, 16, wave_slopes);
  const std::string plain = picture::png_of(32, 16, map.values, PNG_FORMAT_RGB);
  constexpr std::size_t kBeforeChunks = 8 + 25;  // the signature and IHDR
  const std::string linear =
      plain.substr(0, kBeforeChunks) + chunk("gAMA", std::string("\x00\x01\x86\xA0", 4)) + plain.substr(kBeforeChunks);
  for (const std::string& file : {plain, linear}) {
    const auto read = decode_image(file, TexelKind::numbers);
    ASSERT_TRUE(read) << read.error().what;
    EXPECT_EQ(read->width, 32);
    EXPECT_EQ(read->height, 16);
    EXPECT_EQ(read->values, map.values);
  }
  EXPECT_FALSE(decode_image(plain.substr(0, plain.size() / 2), TexelKind::numbers));
  EXPECT_FALSE(decode_image(plain.substr(0, 40), TexelKind::numbers));
}

}  // namespace
}  // namespace hapton
