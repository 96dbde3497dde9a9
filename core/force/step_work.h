#pragma once

namespace hapton {

// The work of a step of `proxy`, in units of about 0.1 us on a processor of 2023. A unit is a triangle queried or gathered, a round of a
// search, or an event on walkable triangles. In the slow steps of all meshes a unit takes 0.05 to 0.2 us (decision 154).
//
// A step has kMax units, whatever the motion, and completes the event that it has begun: about 0.06 ms. On all meshes of the project a few
// steps in a million take more than 0.1 ms (docs/benchmarks.md). What is left of the motion is carried into the next step
// (ForceMethod::carried_from).
//
// An event costs a few units for each triangle near it, of which there are at most NearTriangles::kCapacity. Where there are more, sweeps
// continue the motion; these can be interrupted anywhere.
struct StepWork {
  static constexpr int kMax = 500;
  // A step and the event that it completes, where thousands of triangles meet. Measured, not proved: no tested mesh needs over half of it.
  static constexpr int kMaxWithLastEvent = 16'384;
};

}  // namespace hapton
