#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"
#include "core/effects/surface_image.h"

namespace hapton {

// Reads an image as grey values: 0 black, 1 white, colours by their luma. PNG or JPEG, 8 bits per channel (16 bits are rounded to 8), at
// most 4,096 texels on a side. The content decides the format, not the name. Error: one line with the path: the file cannot be read, has
// neither format, is damaged or too large. RT: set-up only.
Result<SurfaceImage> read_grey_image(const std::filesystem::path& path);

// The same for bytes in memory; the error has no path.
Result<SurfaceImage> decode_grey_image(const std::string& bytes);

}  // namespace hapton
