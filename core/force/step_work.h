#pragma once

namespace hapton {

// The work of a step of `proxy`, in units of some 0.1 us on a processor of 2023: a triangle queried or gathered, a round of a search, an
// event on walkable triangles. In the slow steps of all meshes a unit takes 0.05 to 0.2 us (decision 154).
//
// A step has kMax units, whatever the motion, and ends the event that it has begun: some 0.06 ms. On all meshes of the project some steps
// in a million take more than 0.1 ms (docs/benchmarks.md). What is left of the motion is carried into the next step
// (ForceMethod::carried_from).
//
// An event costs a few units for each triangle near it, of which there are at most NearTriangles::kCapacity; where more are, sweeps go on,
// which end anywhere.
struct StepWork {
  static constexpr int kMax = 500;
  static constexpr int kMaxWithLastEvent = 16'384;  // of what is counted; no mesh that was tested needs more, which is no proof
};

}  // namespace hapton
