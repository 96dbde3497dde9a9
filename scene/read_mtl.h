#pragma once

#include <filesystem>
#include <string_view>

#include "scene/raw_mesh.h"

namespace hapton {

// Reads the colours (Kd), opacities (d, or Tr = 1 - d; d wins) and images (map_Kd, with -clamp on, -s and -o; names may have blanks and
// quotes; what is not there is searched beside the library) of an OBJ file's material library into the materials of raw.appearance that
// have these names. An image replaces the colour, since the colour that exporters write beside it is a default. The names of all materials
// are added to raw.mtl_materials. folder: paths of images are relative to it. raw.notes say which images are missing, and how many images
// of bumps and emissions are ignored. RT: set-up only.
void read_mtl(std::string_view bytes, const std::filesystem::path& folder, RawMesh& raw);

// A file name without the quotes that may be around it. RT: yes.
std::string_view without_quotes(std::string_view name);

// Adds an image file to raw.appearance.images; returns its number there. None, and a line in raw.notes: it cannot be read. RT: set-up only.
std::optional<std::size_t> add_image_file(const std::filesystem::path& file, RawMesh& raw);

}  // namespace hapton
