#pragma once

#include <filesystem>
#include <string_view>

#include "scene/raw_mesh.h"

namespace hapton {

// Reads an OBJ file's material library into the materials of raw.appearance with the same names: colours (Kd), opacities (d, or Tr = 1 - d;
// d wins) and images (map_Kd, with -clamp on, -s and -o; file names may have blanks and quotes; a missing file is also searched beside the
// library). An image replaces the colour, because the colour beside it is an exporter's default. All material names are added to
// raw.mtl_materials. folder: paths of images are relative to it. raw.notes say which images are missing, how many images of bumps or
// normals and how many materials that emit light are ignored. RT: set-up only.
void read_mtl(std::string_view bytes, const std::filesystem::path& folder, RawMesh& raw);

// A file name without the quotes that may be around it. RT: yes.
std::string_view without_quotes(std::string_view name);

// Adds an image file to raw.appearance.images once; returns its index. None, and a line in raw.notes: it cannot be read. RT: set-up only.
std::optional<std::size_t> add_image_file(const std::filesystem::path& file, RawMesh& raw);

}  // namespace hapton
