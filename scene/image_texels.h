#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace hapton {

// What decode_image returns for each texel.
enum class TexelKind : std::uint8_t {
  grey,    // the luminance of colours, 1 value
  numbers  // red, green and blue as they stand in the file, whatever its alpha, 3 values: for images that are not pictures, such as normal
           // maps
};

// A decoded image, 8 bits for each value (16-bit values are rounded to 8).
struct ImageTexels {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> values;  // row by row from the upper left corner
};

// Decodes PNG or JPEG, at most 4,096 texels on a side. The content decides the format, not the name. Error: one line without the path:
// neither format, damaged or too large. RT: set-up only.
Result<ImageTexels> decode_image(const std::string& bytes, TexelKind kind);

// The bytes of an image file. Error: one line with the path: it cannot be read.
Result<std::string> read_image_bytes(const std::filesystem::path& path);

}  // namespace hapton
