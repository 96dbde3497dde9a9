#pragma once

#include "core/base/result.h"
#include "core/effects/surface_image.h"
#include "scene/image_texels.h"

namespace hapton {

// A relief by an image of heights: white is the surface of the mesh, black height_m below it.
struct Relief {
  SurfaceImage image;
  double height_m = 0.0;
};

// The relief whose slopes are nearest to those of a normal map, in the sense of least squares, of all that repeat as images do (Frankot &
// Chellappa 1988). A normal map has in a texel the unit normal (2 red - 1, 2 green - 1, 2 blue - 1): red to the right, green up in the
// image, blue away from the surface, as in glTF. Its mean slope is left out: images repeat.
//
// numbers: TexelKind::numbers. image_m: length and height of the image on the surface, m. scale: multiplies the slopes, not 0. Normals
// nearer than 6 degrees to the surface are taken as 6 degrees. Images of more than 2,048 texels on a side are averaged to half that
// resolution. Error: the texels are not unit normals, or all of them are the same. RT: set-up only.
Result<Relief> relief_of_normals(const ImageTexels& numbers, const Eigen::Vector2d& image_m, double scale);

}  // namespace hapton
