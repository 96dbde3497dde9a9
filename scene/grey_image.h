#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"
#include "core/effects/surface_image.h"

namespace hapton {

// A picture as a grey image: 0 black, 1 white, of colours their luminance. PNG or JPEG, 8 bits a channel (of more, the upper 8), at most
// 4,096 on a side. The file's content decides, not its name. Error: one line with the path: it cannot be read, is neither of them, broken
// or too large. RT: set-up only.
Result<SurfaceImage> read_grey_image(const std::filesystem::path& path);

// The same of bytes in memory; the error has no path.
Result<SurfaceImage> decode_grey_image(const std::string& bytes);

}  // namespace hapton
