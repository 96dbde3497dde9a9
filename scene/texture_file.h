#pragma once

#include <filesystem>
#include <string_view>

#include "core/base/result.h"
#include "core/effects/texture_models.h"

namespace hapton {

// Reads recorded texture models as the Penn Haptic Texture Toolkit has them: XML with AR or ARMA models, their line spectral frequencies,
// and triangles over speed and force (docs/effects.md has the elements). The toolkit's friction coefficient, pictures and polynomial
// coefficients, which its line spectral frequencies repeat, are not used. Units: mm/s and N in the file. RT: set-up only. Error: one line
// with the path, where there is one the line in the file, what is wrong and how to fix it: what is not XML or no such model, elements that
// are missing or not finite numbers, counts that do not match, whatever TextureModels::make rejects.
Result<TextureModels> read_texture_file(const std::filesystem::path& path);

// The same for the file's content; the error has no path.
Result<TextureModels> parse_texture(std::string_view xml);

}  // namespace hapton
