#pragma once

#include "core/math/types.h"

// Colours of the background, sRGB: sky, haze, grid, box and shadow. Those of the probe and its force arrow are in probe_figure.h.
namespace hapton {

inline const Vec3 kSceneLow(0.055, 0.07, 0.095);
inline const Vec3 kSceneHigh(0.30, 0.36, 0.44);
inline const Vec3 kSceneHaze(0.19, 0.23, 0.29);
inline const Vec3 kSceneEven(0.12, 0.15, 0.19);
inline const Vec3 kSceneGrid(0.20, 0.24, 0.30);
inline const Vec3 kSceneBox(0.34, 0.40, 0.48);
inline const Vec3 kSceneShadow(0.045, 0.05, 0.06);

}  // namespace hapton
