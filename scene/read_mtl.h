#pragma once

#include <filesystem>
#include <string_view>

#include "scene/raw_mesh.h"

namespace hapton {

// The colours (Kd), opacities (d, or Tr = 1 - d; d wins) and images (map_Kd, with -clamp on) of an OBJ file's material library. An image
// replaces the colour, since the colour that exporters write beside it is a default. folder: where the images' addresses begin. Fills those
// materials of the look that it names; notes say which images are missing. RT: set-up only.
void read_mtl(std::string_view bytes, const std::filesystem::path& folder, RawMesh& raw);

// An image beside a mesh file. None, and a note, where it cannot be read.
std::optional<std::size_t> add_image_file(const std::filesystem::path& file, RawMesh& raw);

}  // namespace hapton
