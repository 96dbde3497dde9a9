#pragma once

#include <cmath>
#include <numbers>

namespace hapton {

// Shapes of the tour's own scenes, m: frame S, which is W at the start.

// meshes/groove.obj: a block, its front towards the hand, with a V groove along a sine in x.
namespace demo_groove {
constexpr double kFrontM = 0.015;
constexpr double kSwingM = 0.006;  // of the sine, to each side; the next is its wavelength
constexpr double kWaveM = 0.050;
constexpr double kDepthM = 0.008;  // of the V; with the next its walls stand at 45 degrees
constexpr double kHalfWidthM = 0.008;
constexpr double kHalfLengthM = 0.100;  // of the block along x
inline double centre_m(double x_m) { return kSwingM * std::sin(2.0 * std::numbers::pi * x_m / kWaveM); }
}  // namespace demo_groove

// meshes/thin_wall.obj.
namespace demo_wall {
constexpr double kThicknessM = 0.0001;  // of the wall in the mesh file
constexpr double kFrontM = 0.5 * kThicknessM;
constexpr double kHalfSideM = 0.070;  // of the wall
}  // namespace demo_wall

// The mesh that is made when the tour comes to it.
namespace demo_heavy {
constexpr double kRadiusM = 0.060;     // of the ball
constexpr double kCurvatureM = 0.008;  // radius of its bumps and their length, as make_rough_sphere takes them; free choices
constexpr double kWaveM = 0.012;
constexpr std::size_t kTriangles = 1'000'000;  // at least; the next icosphere has 1,310,720
}  // namespace demo_heavy

}  // namespace hapton
