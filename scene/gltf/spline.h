#pragma once

#include <vector>

namespace hapton::gltf {

// Numbers over time, as a sampler of a glTF animation has them (glTF 2.0, 3.11): one row for each time; linear between two times.
struct NumberTrack {
  std::vector<double> times;                // at least one, increasing
  std::vector<std::vector<double>> values;  // one row for each time, all of the same length
};

// Converts a CUBICSPLINE sampler to straight pieces. The values at its keyframes stay. Between two keyframes, rows on the curve are added:
// as many as keep the straight pieces within 1/256 of the range of the numbers, but at most kMaxPieces - 1. rows: three for each time: the
// tangent before it, the value, the tangent after it. Pre: at least one time, times increase, three rows for each time, all finite and of
// the same length. RT: set-up only. Source: glTF 2.0, appendix C.5 (Hermite).
constexpr int kMaxPieces = 16;
NumberTrack straighten_spline(const std::vector<double>& times, const std::vector<std::vector<double>>& rows);

}  // namespace hapton::gltf
