#include "scene/grey_image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scene/made_pictures.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

int ramp_at(int x, int y) { return 3 * x + 2 * y; }

TEST(GreyImage, ReadsGreyPngAsItIs) {
  const auto image = decode_grey_image(picture::png_of(16, 8, picture::grey_rows(16, 8, ramp_at)));
  ASSERT_TRUE(image) << image.error().what;
  ASSERT_EQ(image->width(), 16);
  ASSERT_EQ(image->height(), 8);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 16; ++x)
      EXPECT_FLOAT_EQ(image->texels()[static_cast<std::size_t>(16 * y + x)], static_cast<float>(ramp_at(x, y)) / 255.0F);
  }
}

// If a file does not say what its values mean, libpng would interpret values of 16 bits as linear light and convert them.
TEST(GreyImage, RoundsSixteenBitsToEight) {
  const auto image = decode_grey_image(picture::grey_16_png_of(4, 1, {0x00, 0x00, 0x40, 0x40, 0x80, 0x80, 0xFF, 0xFF}));
  ASSERT_TRUE(image) << image.error().what;
  EXPECT_FLOAT_EQ(image->texels()[0], 0.0F);
  EXPECT_FLOAT_EQ(image->texels()[1], 64.0F / 255.0F);
  EXPECT_FLOAT_EQ(image->texels()[2], 128.0F / 255.0F);
  EXPECT_FLOAT_EQ(image->texels()[3], 1.0F);
}

TEST(GreyImage, IgnoresAlpha) {
  const auto grey = decode_grey_image(picture::png_of(3, 1, {255, 255, 255, 128, 255, 0}, PNG_FORMAT_GA));
  const auto colour = decode_grey_image(picture::png_of(2, 1, {255, 255, 255, 255, 255, 255, 255, 10}, PNG_FORMAT_RGBA));
  ASSERT_TRUE(grey && colour);
  for (const float value : grey->texels()) EXPECT_FLOAT_EQ(value, 1.0F);
  for (const float value : colour->texels()) EXPECT_FLOAT_EQ(value, 1.0F);
}

TEST(GreyImage, ReadsColoursAsTheirLuminance) {
  const std::vector<std::uint8_t> rows = {255, 255, 255, 0, 0, 0, 0, 255, 0, 0, 0, 255};  // white, black, green, blue
  const auto image = decode_grey_image(picture::png_of(4, 1, rows, PNG_FORMAT_RGB));
  ASSERT_TRUE(image) << image.error().what;
  EXPECT_FLOAT_EQ(image->texels()[0], 1.0F);
  EXPECT_FLOAT_EQ(image->texels()[1], 0.0F);
  EXPECT_GT(image->texels()[2], image->texels()[3]);
}

TEST(GreyImage, ReadsJpeg) {
  const auto image = decode_grey_image(picture::jpeg_of(32, 16, picture::grey_rows(32, 16, ramp_at)));
  ASSERT_TRUE(image) << image.error().what;
  ASSERT_EQ(image->width(), 32);
  ASSERT_EQ(image->height(), 16);
  for (int x = 0; x < 32; ++x) EXPECT_NEAR(image->texels()[static_cast<std::size_t>(32 * 5 + x)], ramp_at(x, 5) / 255.0, 0.03);
}

TEST(GreyImage, SaysWhatIsWrong) {
  EXPECT_THAT(decode_grey_image("GIF89a").error().what, HasSubstr("neither PNG nor JPEG"));
  EXPECT_THAT(decode_grey_image("").error().what, HasSubstr("neither PNG nor JPEG"));
  const auto rows = picture::grey_rows(64, 64, ramp_at);
  for (const std::string& whole : {picture::png_of(64, 64, rows), picture::jpeg_of(64, 64, rows)}) {
    for (const std::size_t byte_count : {std::size_t{8}, std::size_t{20}, whole.size() / 2, whole.size() - 40}) {
      const auto image = decode_grey_image(whole.substr(0, byte_count));
      ASSERT_FALSE(image) << byte_count;
      EXPECT_THAT(image.error().what, HasSubstr("broken"));
    }
  }
  const auto wide = decode_grey_image(picture::png_of(4097, 1, picture::grey_rows(4097, 1, ramp_at)));
  ASSERT_FALSE(wide);
  EXPECT_THAT(wide.error().what, HasSubstr("4097 x 1"));
  EXPECT_THAT(decode_grey_image(picture::jpeg_of(1, 4097, picture::grey_rows(1, 4097, ramp_at))).error().what, HasSubstr("1 x 4097"));
}

TEST(GreyImage, ErrorsOfAFileNameIt) {
  const ScratchFolder folder;
  EXPECT_THAT(read_grey_image(folder.path() / "none.png").error().what, HasSubstr("none.png"));
  EXPECT_THAT(read_grey_image(folder.write("odd.png", "text")).error().what, HasSubstr("odd.png: is neither"));
  EXPECT_TRUE(read_grey_image(folder.write("good.txt", picture::png_of(2, 2, {0, 1, 2, 3}))));
}

}  // namespace
}  // namespace hapton
