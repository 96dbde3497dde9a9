#pragma once

#include <cmath>
#include <numbers>

namespace hapton {

// Dimensions of the tour's own scenes, m. Frame S, which equals W at the start.

// meshes/groove.obj: a block with its front towards the hand, and a V groove whose middle is a sine wave along x.
namespace demo_groove {
constexpr double kFrontM = 0.015;       // z of the front
constexpr double kAmplitudeM = 0.006;   // amplitude of the sine
constexpr double kWavelengthM = 0.050;  // wavelength of the sine
constexpr double kDepthM = 0.008;       // depth of the V, equal to its half width: its walls stand at 45 degrees
constexpr double kHalfWidthM = 0.008;   // half width of the V
constexpr double kHalfLengthM = 0.100;  // half length of the block along x
// y of the groove's middle.
inline double centre_m(double x_m) { return kAmplitudeM * std::sin(2.0 * std::numbers::pi * x_m / kWavelengthM); }
}  // namespace demo_groove

// meshes/thin_wall.obj.
namespace demo_wall {
constexpr double kThicknessM = 0.0001;         // thickness of the wall
constexpr double kFrontM = 0.5 * kThicknessM;  // z of the front
constexpr double kHalfSideM = 0.070;           // half of the wall's side
}  // namespace demo_wall

// The ball that the step with the heavy mesh generates, because it is too large for a shipped file.
namespace demo_heavy {
constexpr double kRadiusM = 0.060;             // radius of the ball
constexpr double kCurvatureRadiusM = 0.008;    // curvature_radius_m of make_rough_sphere; a free choice
constexpr double kWavelengthM = 0.012;         // wavelength_m of make_rough_sphere; a free choice
constexpr std::size_t kTriangles = 1'000'000;  // at least so many; the smallest such icosphere has 1,310,720
}  // namespace demo_heavy

}  // namespace hapton
