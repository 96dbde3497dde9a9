#include "scene/grey_image.h"

#include <csetjmp>
#include <cstdint>
#include <cstdio>
#include <utility>
#include <vector>

#include <jpeglib.h>
#include <png.h>

#include "scene/file_bytes.h"
#include "scene/text_cursor.h"

namespace hapton {
namespace {

constexpr std::size_t kMaxImageFileBytes = std::size_t{1} << 28;
constexpr unsigned kMaxImageSide = 4096;

Error broken_image() { return {"is a broken image: export it again"}; }
Error large_image(unsigned width, unsigned height) {
  return {fmt::format("is {} x {} texels: make it at most {} on a side", width, height, kMaxImageSide)};
}

SurfaceImage to_surface(unsigned width, unsigned height, const std::vector<std::uint8_t>& grey) {
  std::vector<float> texels;
  texels.reserve(grey.size());
  for (const std::uint8_t value : grey) texels.push_back(static_cast<float>(value) / 255.0F);
  return {static_cast<int>(width), static_cast<int>(height), std::move(texels)};
}

Result<SurfaceImage> decode_grey_png(const std::string& bytes) {
  png_image png = {};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()) == 0) return tl::unexpected(broken_image());
  if (png.width == 0 || png.height == 0 || png.width > kMaxImageSide || png.height > kMaxImageSide) {
    const Error error = large_image(png.width, png.height);
    png_image_free(&png);
    return tl::unexpected(error);
  }
  png.format = PNG_FORMAT_GRAY;
  std::vector<std::uint8_t> grey(PNG_IMAGE_SIZE(png));
  const bool is_read = png_image_finish_read(&png, nullptr, grey.data(), 0, nullptr) != 0;
  png_image_free(&png);
  if (!is_read) return tl::unexpected(broken_image());
  return to_surface(png.width, png.height, grey);
}

// libjpeg reports an error by a call that must not return.
struct JpegFault {
  jpeg_error_mgr manager;
  std::jmp_buf back;
};

[[noreturn]] void leave_jpeg(j_common_ptr jpeg) { std::longjmp(reinterpret_cast<JpegFault*>(jpeg->err)->back, 1); }
void ignore_message(j_common_ptr) {}

// Rows of grey. Nothing with a destructor is made between setjmp and what may jump back to it. False: broken.
bool read_jpeg_rows(jpeg_decompress_struct& jpeg, JpegFault& fault, const std::string& bytes, std::vector<std::uint8_t>& grey) {
  if (setjmp(fault.back) != 0) return false;
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<unsigned long>(bytes.size()));
  jpeg_read_header(&jpeg, TRUE);
  if (jpeg.image_width > kMaxImageSide || jpeg.image_height > kMaxImageSide) return true;  // the caller sees the size
  jpeg.out_color_space = JCS_GRAYSCALE;
  jpeg_start_decompress(&jpeg);
  grey.resize(static_cast<std::size_t>(jpeg.output_width) * jpeg.output_height);
  while (jpeg.output_scanline < jpeg.output_height) {
    JSAMPROW row = grey.data() + static_cast<std::size_t>(jpeg.output_scanline) * jpeg.output_width;
    jpeg_read_scanlines(&jpeg, &row, 1);
  }
  // A file cut short gives grey rows and a warning.
  return jpeg.err->num_warnings == 0;
}

Result<SurfaceImage> decode_grey_jpeg(const std::string& bytes) {
  JpegFault fault = {};
  jpeg_decompress_struct jpeg = {};
  jpeg.err = jpeg_std_error(&fault.manager);
  fault.manager.error_exit = &leave_jpeg;
  fault.manager.output_message = &ignore_message;
  jpeg_create_decompress(&jpeg);
  std::vector<std::uint8_t> grey;
  const bool is_read = read_jpeg_rows(jpeg, fault, bytes, grey);
  const unsigned width = jpeg.image_width;
  const unsigned height = jpeg.image_height;
  jpeg_destroy_decompress(&jpeg);
  if (width > kMaxImageSide || height > kMaxImageSide) return tl::unexpected(large_image(width, height));
  if (!is_read || grey.empty()) return tl::unexpected(broken_image());
  return to_surface(width, height, grey);
}

}  // namespace

Result<SurfaceImage> decode_grey_image(const std::string& bytes) {
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return decode_grey_png(bytes);
  if (bytes.starts_with("\xFF\xD8\xFF")) return decode_grey_jpeg(bytes);
  return fail("is neither PNG nor JPEG: export it as one of them");
}

Result<SurfaceImage> read_grey_image(const std::filesystem::path& path) {
  const Result<std::string> bytes = read_file_bytes(path, kMaxImageFileBytes);
  if (!bytes) return tl::unexpected(bytes.error());
  auto image = decode_grey_image(*bytes);
  if (!image) return fail("{}: {}", path.string(), image.error().what);
  return image;
}

}  // namespace hapton
