#pragma once

#include <filesystem>
#include <string_view>

#include "core/base/result.h"
#include "core/effects/texture_models.h"

namespace hapton {

// Reads recorded texture models in the format of the Penn Haptic Texture Toolkit: XML with AR or ARMA models, their line spectral
// frequencies, and triangles over speed and force (docs/effects.md describes the elements). The toolkit's friction coefficient and pictures
// are not used, nor its polynomial coefficients, which say the same as the line spectral frequencies. Units: mm/s and N in the file. RT:
// set-up only. Error: one line with the path, the line in the file if there is one, what is wrong and how to fix it: not XML or not such a
// model, elements that are missing or not finite numbers, counts that do not match, whatever TextureModels::make rejects.
Result<TextureModels> read_texture_file(const std::filesystem::path& path);

// The same for the content of a file; the error has no path.
Result<TextureModels> parse_texture(std::string_view xml);

}  // namespace hapton
