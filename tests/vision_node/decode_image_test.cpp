#include "vision_node/decode_image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/vision_node/made_images.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

std::array<int, 3> texel(const Texels& texels, int x, int y) {
  const auto at = 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(texels.width) + static_cast<std::size_t>(x));
  return {texels.rgba[at], texels.rgba[at + 1], texels.rgba[at + 2]};
}

std::string error_of(const TextureImage& image) {
  const auto decoded = decode_image(image);
  return decoded ? "it was decoded" : decoded.error().what;
}

TEST(DecodeImage, ReadsPngFromTheUpperLeftCorner) {
  const auto texels = decode_image({"quarters", make_quarters_png(8)});
  ASSERT_TRUE(texels) << texels.error().what;
  ASSERT_EQ(texels->width, 8);
  ASSERT_EQ(texels->rgba.size(), 4U * 64U);
  EXPECT_EQ(texel(*texels, 0, 0), (std::array{255, 0, 0}));
  EXPECT_EQ(texel(*texels, 7, 0), (std::array{0, 255, 0}));
  EXPECT_EQ(texel(*texels, 0, 7), (std::array{0, 0, 255}));
  EXPECT_EQ(texel(*texels, 7, 7), (std::array{255, 255, 255}));
}

TEST(DecodeImage, ReadsJpeg) {
  const auto texels = decode_image({"sky", make_image<vtkJPEGWriter>(16, 8, [](int, int y) {
                                      return y < 4 ? Eigen::Vector3i(40, 90, 200) : Eigen::Vector3i(200, 180, 20);
                                    })});
  ASSERT_TRUE(texels) << texels.error().what;
  EXPECT_EQ(texels->width, 16);
  EXPECT_EQ(texels->height, 8);
  EXPECT_NEAR(texel(*texels, 8, 1)[2], 200, 12);
  EXPECT_NEAR(texel(*texels, 8, 6)[0], 200, 12);
}

TEST(DecodeImage, SaysWhatIsWrong) {
  EXPECT_THAT(error_of({"a.tga", "something else"}), AllOf(HasSubstr("a.tga"), HasSubstr("neither PNG nor JPEG")));
  const std::string whole = make_quarters_png(64);
  for (const std::size_t bytes_left : {std::size_t{8}, std::size_t{20}, whole.size() / 2}) {
    EXPECT_THAT(error_of({"cut.png", whole.substr(0, bytes_left)}), HasSubstr("cut.png")) << bytes_left;
  }
  const std::string jpeg = make_image<vtkJPEGWriter>(64, 64, [](int x, int y) { return Eigen::Vector3i(2 * x, 2 * y, 100); });
  for (const std::size_t bytes_left : {std::size_t{3}, std::size_t{40}, std::size_t{200}}) {
    EXPECT_THAT(error_of({"cut.jpg", jpeg.substr(0, bytes_left)}), HasSubstr("cut.jpg")) << bytes_left;
  }
}

TEST(DecodeImage, ResizesByTheMean) {
  const auto texels = decode_image({"quarters", make_quarters_png(8)});
  ASSERT_TRUE(texels);
  const Texels one = resize_image(*texels, 1, 1);
  EXPECT_THAT(texel(one, 0, 0), (std::array{128, 128, 128}));
  const Texels large = resize_image(*texels, 32, 16);
  EXPECT_EQ(texel(large, 0, 0), (std::array{255, 0, 0}));
  EXPECT_EQ(texel(large, 31, 15), (std::array{255, 255, 255}));
}

}  // namespace
}  // namespace hapton
