#include "scene/image_texels.h"

#include <csetjmp>
#include <cstdio>
#include <string_view>

#include <jpeglib.h>
#include <png.h>

#include "scene/file_bytes.h"
#include "scene/text_cursor.h"

namespace hapton {
namespace {

constexpr std::size_t kMaxImageFileBytes = std::size_t{1} << 28;
constexpr unsigned kMaxImageSide = 4096;
constexpr std::string_view kPngBegin = "\x89PNG\r\n\x1a\n";

Error broken_image() { return {"is a broken image: export it again"}; }
Error large_image(unsigned width, unsigned height) {
  return {fmt::format("is {} x {} texels: make it at most {} on a side", width, height, kMaxImageSide)};
}

// A PNG file without the chunks that say how its values become colours: with these chunks, libpng would convert the values to sRGB.
std::string without_colour_space(const std::string& bytes) {
  constexpr std::size_t kChunkOverheadBytes = 12;  // length, type and checksum of a chunk
  std::string filtered(kPngBegin);
  for (std::size_t at = kPngBegin.size(); at + kChunkOverheadBytes <= bytes.size();) {
    std::size_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) length = length << 8U | static_cast<std::uint8_t>(bytes[at + i]);
    const std::size_t size = std::min(length + kChunkOverheadBytes, bytes.size() - at);
    const std::string_view type = std::string_view(bytes).substr(at + 4, 4);
    if (type != "gAMA" && type != "cHRM" && type != "iCCP" && type != "sRGB") filtered.append(bytes, at, size);
    at += size;
  }
  return filtered;
}

// Removes alpha, the last of the channels of each texel.
void drop_alpha(std::vector<std::uint8_t>& values, std::size_t channels) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i % channels != channels - 1) values[kept++] = values[i];
  }
  values.resize(kept);
}

Result<ImageTexels> decode_png(const std::string& bytes, TexelKind kind) {
  png_image png = {};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()) == 0) return tl::unexpected(broken_image());
  if (png.width == 0 || png.height == 0 || png.width > kMaxImageSide || png.height > kMaxImageSide) {
    const Error error = large_image(png.width, png.height);
    png_image_free(&png);
    return tl::unexpected(error);
  }
  // Without this, libpng takes 16-bit values for linear light if the file does not say what they are, and makes them brighter.
  png.flags |= PNG_IMAGE_FLAG_16BIT_sRGB;
  // With alpha in the output: without it, libpng would multiply grey values and colours by it.
  png.format = kind == TexelKind::grey ? PNG_FORMAT_GA : PNG_FORMAT_RGBA;
  ImageTexels texels{static_cast<int>(png.width), static_cast<int>(png.height), std::vector<std::uint8_t>(PNG_IMAGE_SIZE(png))};
  const bool is_read = png_image_finish_read(&png, nullptr, texels.values.data(), 0, nullptr) != 0;
  png_image_free(&png);
  if (!is_read) return tl::unexpected(broken_image());
  drop_alpha(texels.values, kind == TexelKind::grey ? 2 : 4);
  return texels;
}

// libjpeg reports an error by a call that must not return.
struct JpegFault {
  jpeg_error_mgr manager;
  std::jmp_buf return_point;
};

[[noreturn]] void leave_jpeg(j_common_ptr jpeg) { std::longjmp(reinterpret_cast<JpegFault*>(jpeg->err)->return_point, 1); }
void ignore_message(j_common_ptr) {}

// No object with a destructor is created between setjmp and the calls that may jump back to it. False: the file is broken.
bool read_jpeg_rows(jpeg_decompress_struct& jpeg, JpegFault& fault, const std::string& bytes, TexelKind kind,
                    std::vector<std::uint8_t>& values) {
  if (setjmp(fault.return_point) != 0) return false;
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<unsigned long>(bytes.size()));
  jpeg_read_header(&jpeg, TRUE);
  if (jpeg.image_width > kMaxImageSide || jpeg.image_height > kMaxImageSide) return true;  // the caller sees the size
  jpeg.out_color_space = kind == TexelKind::grey ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_start_decompress(&jpeg);
  const std::size_t row_size = static_cast<std::size_t>(jpeg.output_width) * static_cast<std::size_t>(jpeg.output_components);
  values.resize(row_size * jpeg.output_height);
  while (jpeg.output_scanline < jpeg.output_height) {
    JSAMPROW row = values.data() + jpeg.output_scanline * row_size;
    jpeg_read_scanlines(&jpeg, &row, 1);
  }
  // For a file that is cut short, libjpeg returns grey rows and counts a warning.
  return jpeg.err->num_warnings == 0;
}

Result<ImageTexels> decode_jpeg(const std::string& bytes, TexelKind kind) {
  JpegFault fault = {};
  jpeg_decompress_struct jpeg = {};
  jpeg.err = jpeg_std_error(&fault.manager);
  fault.manager.error_exit = &leave_jpeg;
  fault.manager.output_message = &ignore_message;
  jpeg_create_decompress(&jpeg);
  std::vector<std::uint8_t> values;
  const bool is_read = read_jpeg_rows(jpeg, fault, bytes, kind, values);
  const unsigned width = jpeg.image_width;
  const unsigned height = jpeg.image_height;
  jpeg_destroy_decompress(&jpeg);
  if (width > kMaxImageSide || height > kMaxImageSide) return tl::unexpected(large_image(width, height));
  if (!is_read || values.empty()) return tl::unexpected(broken_image());
  return ImageTexels{static_cast<int>(width), static_cast<int>(height), std::move(values)};
}

}  // namespace

Result<ImageTexels> decode_image(const std::string& bytes, TexelKind kind) {
  if (bytes.starts_with(kPngBegin)) return decode_png(kind == TexelKind::numbers ? without_colour_space(bytes) : bytes, kind);
  if (bytes.starts_with("\xFF\xD8\xFF")) return decode_jpeg(bytes, kind);
  return fail("is neither PNG nor JPEG: export it as one of them");
}

Result<std::string> read_image_bytes(const std::filesystem::path& path) { return read_file_bytes(path, kMaxImageFileBytes); }

}  // namespace hapton
