#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/tool/surface_voxels.h"
#include "core/tool/tool_step.h"

namespace hapton {

// A rigid tool by voxels and a shell of points, a method used in industry since 1999; for comparison only, as `sweep` is for a point probe.
//
// McNeely, Puterbaugh and Troy, "Six Degree-of-Freedom Haptic Rendering Using Voxel Sampling" (1999): the scene becomes the voxels that its
// surface crosses, the tool the centres of the voxels that its own surface crosses, each with a normal. A point in a voxel of the scene is
// pushed by a spring along the point's normal, towards the plane through the voxel's centre (tangent-plane force), so the bodies come to
// rest about a voxel apart at most. These springs and the coupling to the device hold the tool's proxy. As in Wan and McNeely,
// "Quasi-Static Approximation for 6 Degrees-of-Freedom Haptic Rendering" (2003), the proxy has no mass: each step it moves to where the
// linearized springs balance, but no point of it farther than half a voxel, so that no point skips a voxel. Frames and units: as ToolStep.
// RT: step and reset yes, make set-up only.
class VoxelTool {
 public:
  // Stiffness of a contact point, as a multiple of the coupling's; with more than kFullContacts points in contact, they share the
  // stiffness of kFullContacts (the paper's section 7.3 limits the stiffness of many contacts in this way).
  static constexpr double kContactStiffness = 10.0;
  static constexpr double kFullContacts = 10.0;
  // Largest number of voxels of the scene's grid, a bit each: 128 MB.
  static constexpr double kMaxCells = 1 << 30;

  // voxel_m: side of a voxel, the same for scene and tool. Error: as ToolStep::make, and a voxel size that is impossible.
  static Result<std::unique_ptr<VoxelTool>> make(const TriangleMesh& tool, const std::vector<std::shared_ptr<const TriangleMesh>>& scene,
                                                 const ToolCoupling& coupling, double voxel_m);

  // In ToolOutput::proxy only `haptons` is set: the number of points in contact.
  ToolOutput step(const ToolInput& input) noexcept;
  void reset(const ToolInput& input) noexcept;

  // As ToolStep::set_stiffness.
  void set_stiffness(double n_per_m) noexcept {
    coupling_ = {.stiffness_n_per_m = n_per_m, .rotational_stiffness_nm_per_rad = n_per_m * squared_lever_m2_};
  }

  // Where the tool is, frame S, metres.
  const Placement& placement() const { return proxy_; }
  const ToolCoupling& coupling() const { return coupling_; }  // with the rotational stiffness that is used
  // A line for users.
  std::string describe() const;

 private:
  struct Point {
    Vec3 r_m;     // from the grip point, along the tool's axes
    Vec3 inward;  // unit normal, into the tool, along the tool's axes
  };

  VoxelTool() = default;
  bool is_surface(const Eigen::Vector3i& cell) const noexcept;  // Pre: within the grid
  int gather(const Placement& device, Mat6& hessian, Vec6& pull) const noexcept;

  ToolCoupling coupling_;
  double squared_lever_m2_ = 0.0;  // rotational stiffness over stiffness
  VoxelGrid grid_;
  Eigen::Vector3i cells_ = Eigen::Vector3i::Zero();
  std::vector<std::uint64_t> is_surface_;  // one bit for each cell
  std::vector<Point> points_;
  double radius_m_ = 0.0;  // of the points about the grip point
  Placement proxy_;
};

}  // namespace hapton
