#pragma once

// Images in memory, as the bytes of PNG and JPEG files.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <jpeglib.h>
#include <png.h>

namespace hapton::picture {

// value_at(x, y): 0 to 255; (0, 0) is the upper left corner.
template <class ValueAt>
std::vector<std::uint8_t> grey_rows(int width, int height, ValueAt value_at) {
  std::vector<std::uint8_t> rows;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) rows.push_back(static_cast<std::uint8_t>(value_at(x, y)));
  }
  return rows;
}

inline std::string png_of(int width, int height, const std::vector<std::uint8_t>& rows, unsigned format = PNG_FORMAT_GRAY) {
  png_image png = {};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(width);
  png.height = static_cast<png_uint_32>(height);
  png.format = format;
  png_alloc_size_t size = 0;
  if (png_image_write_get_memory_size(png, size, 0, rows.data(), 0, nullptr) == 0) return {};
  std::string bytes(size, '\0');
  return png_image_write_to_memory(&png, bytes.data(), &size, 0, rows.data(), 0, nullptr) == 0 ? std::string() : bytes.substr(0, size);
}

// Grey with 16 bits per value, the upper byte first, without a statement of the colour space.
inline std::string grey_16_png_of(int width, int height, const std::vector<std::uint8_t>& rows) {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  const auto append = [](png_structp to, png_bytep data, std::size_t size) {
    static_cast<std::string*>(png_get_io_ptr(to))->append(reinterpret_cast<const char*>(data), size);
  };
  png_set_write_fn(png, &bytes, append, [](png_structp) {});
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), 16, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  for (int y = 0; y < height; ++y) png_write_row(png, rows.data() + 2 * static_cast<std::size_t>(y) * static_cast<std::size_t>(width));
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

inline std::string jpeg_of(int width, int height, std::vector<std::uint8_t> rows) {
  jpeg_error_mgr errors = {};
  jpeg_compress_struct jpeg = {};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &bytes, &size);
  jpeg.image_width = static_cast<JDIMENSION>(width);
  jpeg.image_height = static_cast<JDIMENSION>(height);
  jpeg.input_components = 1;
  jpeg.in_color_space = JCS_GRAYSCALE;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 95, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  for (int y = 0; y < height; ++y) {
    JSAMPROW row = rows.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  std::string made(reinterpret_cast<const char*>(bytes), size);
  jpeg_destroy_compress(&jpeg);
  std::free(bytes);
  return made;
}

}  // namespace hapton::picture
