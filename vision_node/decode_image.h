#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "scene/mesh_appearance.h"

namespace hapton {

// A decoded image: red, green, blue and alpha of each texel, by rows from the upper left corner, sRGB.
struct Texels {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;
};

// Decodes PNG and JPEG. Error: one line that names the image: neither of them, broken, or larger than 8,192 on a side. RT: set-up only.
Result<Texels> decode_image(const TextureImage& image);

// Returns the same image in another size: averaged when it shrinks, linear between texels when it grows. Pre: both sizes are positive.
Texels resize_image(const Texels& image, int width, int height);

}  // namespace hapton
