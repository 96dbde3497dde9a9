#pragma once

#include <vector>

namespace hapton::gltf {

// Numbers over time, as an animation's sampler has them [3.11]: a row of the same length at each time, linear in between.
struct NumberTrack {
  std::vector<double> times;                // at least one, increasing
  std::vector<std::vector<double>> values;  // one row a time
};

// A CUBICSPLINE sampler as straight pieces: the rows of its keyframes stay, and between two of them as many more lie on the curve as keep
// the pieces within a 256th of the range of the numbers, at most kMaxPieces - 1. rows: for each time the tangent before it, the value and
// the tangent after it. Pre: three rows a time, all finite and of the same length. RT: set-up only. Source: glTF 2.0, appendix C.5,
// Hermite.
constexpr int kMaxPieces = 16;
NumberTrack straighten_spline(const std::vector<double>& times, const std::vector<std::vector<double>>& rows);

}  // namespace hapton::gltf
