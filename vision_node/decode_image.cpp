#include "vision_node/decode_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include <png.h>

#include <vtkImageData.h>
#include <vtkJPEGReader.h>
#include <vtkNew.h>

#include "scene/text_cursor.h"

namespace hapton {
namespace {

constexpr int kMaxSide = 8192;  // texels; a free choice: 256 MiB in RGBA

std::string name_of(const TextureImage& image) { return printable(std::filesystem::path(image.name).filename().string()); }

Error broken(const TextureImage& image) { return {fmt::format("texture {}: is broken", name_of(image))}; }
Error too_large(const TextureImage& image) { return {fmt::format("texture {}: is larger than {} on a side", name_of(image), kMaxSide)}; }

// Calls libpng itself: VTK's reader ends the program if a file in memory is cut short.
Result<Texels> decode_png(const TextureImage& image) {
  png_image png = {};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&png, image.bytes.data(), image.bytes.size()) == 0) return tl::unexpected(broken(image));
  if (png.width > kMaxSide || png.height > kMaxSide) {
    png_image_free(&png);
    return tl::unexpected(too_large(image));
  }
  png.format = PNG_FORMAT_RGBA;
  Texels texels{static_cast<int>(png.width), static_cast<int>(png.height), std::vector<std::uint8_t>(PNG_IMAGE_SIZE(png))};
  const bool is_read = png_image_finish_read(&png, nullptr, texels.rgba.data(), 0, nullptr) != 0;
  png_image_free(&png);
  return is_read ? Result<Texels>(std::move(texels)) : tl::unexpected(broken(image));
}

// Silences VTK, which writes its own lines about a broken file to stderr.
class QuietVtk {
 public:
  QuietVtk() : previous_display_(vtkObject::GetGlobalWarningDisplay()) { vtkObject::GlobalWarningDisplayOff(); }
  ~QuietVtk() { vtkObject::SetGlobalWarningDisplay(previous_display_); }
  QuietVtk(const QuietVtk&) = delete;
  QuietVtk& operator=(const QuietVtk&) = delete;

 private:
  int previous_display_;
};

// Copies an image in grey or in colours. VTK's first row is the lowest.
Texels copy_texels(vtkImageData* data) {
  const int* size = data->GetDimensions();
  const int components = data->GetNumberOfScalarComponents();
  Texels texels{size[0], size[1], {}};
  texels.rgba.reserve(4 * static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]));
  for (int y = size[1] - 1; y >= 0; --y) {
    const auto* row = static_cast<const std::uint8_t*>(data->GetScalarPointer(0, y, 0));
    for (int x = 0; x < size[0]; ++x) {
      for (int k = 0; k < 3; ++k) texels.rgba.push_back(row[x * components + (components < 3 ? 0 : k)]);
      texels.rgba.push_back(255);
    }
  }
  return texels;
}

Result<Texels> decode_jpeg(const TextureImage& image) {
  const QuietVtk quiet;
  vtkNew<vtkJPEGReader> reader;
  reader->SetMemoryBuffer(image.bytes.data());
  reader->SetMemoryBufferLength(static_cast<vtkIdType>(image.bytes.size()));
  reader->UpdateInformation();
  const int* extent = reader->GetDataExtent();
  const int width = extent[1] - extent[0] + 1;
  const int height = extent[3] - extent[2] + 1;
  if (reader->GetErrorCode() != 0 || width < 1 || height < 1) return tl::unexpected(broken(image));
  if (width > kMaxSide || height > kMaxSide) return tl::unexpected(too_large(image));
  reader->Update();
  vtkImageData* data = reader->GetOutput();
  const int* size = data->GetDimensions();
  const bool is_read = reader->GetErrorCode() == 0 && size[0] == width && size[1] == height && data->GetScalarPointer() != nullptr;
  if (!is_read || data->GetScalarType() != VTK_UNSIGNED_CHAR) return tl::unexpected(broken(image));
  const int components = data->GetNumberOfScalarComponents();
  if (components != 1 && components != 3) {
    return fail("texture {}: is a JPEG with {} components (CMYK?): save it in RGB or grey", name_of(image), components);
  }
  return copy_texels(data);
}

}  // namespace

Result<Texels> decode_image(const TextureImage& image) {
  if (image.bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) return tl::unexpected(too_large(image));
  if (image.bytes.starts_with("\x89PNG\r\n\x1a\n")) return decode_png(image);
  if (image.bytes.starts_with("\xFF\xD8\xFF")) return decode_jpeg(image);
  return fail("texture {}: is neither PNG nor JPEG", name_of(image));
}

Texels resize_image(const Texels& image, int width, int height) {
  Texels resized{width, height, std::vector<std::uint8_t>(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height))};
  const double step_x = static_cast<double>(image.width) / width;
  const double step_y = static_cast<double>(image.height) / height;
  const auto channel_at = [&](int x, int y, int k) {
    const int cx = std::clamp(x, 0, image.width - 1);
    const int cy = std::clamp(y, 0, image.height - 1);
    return static_cast<double>(
        image.rgba[4 * (static_cast<std::size_t>(cy) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(cx)) +
                   static_cast<std::size_t>(k)]);
  };
  // Number of samples in a new texel's square, each interpolated linearly between four texels.
  const int samples_x = std::max(1, static_cast<int>(std::ceil(step_x)));
  const int samples_y = std::max(1, static_cast<int>(std::ceil(step_y)));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      std::array<double, 4> sum = {};
      for (int j = 0; j < samples_y; ++j) {
        for (int i = 0; i < samples_x; ++i) {
          const double px = (x + (i + 0.5) / samples_x) * step_x - 0.5;
          const double py = (y + (j + 0.5) / samples_y) * step_y - 0.5;
          const int left = static_cast<int>(std::floor(px));
          const int top = static_cast<int>(std::floor(py));
          const double u = px - left;
          const double v = py - top;
          for (int k = 0; k < 4; ++k) {
            sum[static_cast<std::size_t>(k)] += (1 - v) * ((1 - u) * channel_at(left, top, k) + u * channel_at(left + 1, top, k)) +
                                                v * ((1 - u) * channel_at(left, top + 1, k) + u * channel_at(left + 1, top + 1, k));
          }
        }
      }
      for (std::size_t k = 0; k < 4; ++k) {
        resized.rgba[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) + k] =
            static_cast<std::uint8_t>(std::lround(sum[k] / (samples_x * samples_y)));
      }
    }
  }
  return resized;
}

}  // namespace hapton
