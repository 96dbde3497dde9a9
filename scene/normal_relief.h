#pragma once

#include "core/base/result.h"
#include "core/effects/surface_image.h"
#include "scene/image_texels.h"

namespace hapton {

// A relief as an image of heights: white is the surface of the mesh, black is height_m below it.
struct Relief {
  SurfaceImage image;
  double height_m = 0.0;
};

// Computes the relief whose slopes are nearest, by least squares, to those of a normal map, among the reliefs that repeat like the image
// (Frankot & Chellappa 1988). A texel of a normal map is the unit normal (2 red - 1, 2 green - 1, 2 blue - 1): x to the right, y upwards in
// the image, z away from the surface, as in glTF. The mean slope is left out, because the image repeats.
//
// numbers: TexelKind::numbers. image_m: width and height of the image on the surface, m. scale: factor of the slopes, not 0. Normals at
// less than 6 degrees to the surface count as 6 degrees. Images of more than 2,048 texels on a side are averaged to half the resolution.
// Error: the texels are not unit normals, or the relief is flat because all normals are the same. RT: set-up only.
Result<Relief> relief_of_normals(const ImageTexels& numbers, const Eigen::Vector2d& image_m, double scale);

}  // namespace hapton
