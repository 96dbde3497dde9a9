#include "core/tool/voxel_tool.h"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

namespace hapton {
namespace {

std::size_t index_of(const Eigen::Vector3i& cell, const Eigen::Vector3i& cells) {
  return (static_cast<std::size_t>(cell.z()) * static_cast<std::size_t>(cells.y()) + static_cast<std::size_t>(cell.y())) *
             static_cast<std::size_t>(cells.x()) +
         static_cast<std::size_t>(cell.x());
}

Placement in_scene(const ToolInput& input) {
  const Pose X_SD = input.X_WS.inverse(Eigen::Isometry) * input.X_WD;
  return {X_SD.translation(), Quat(X_SD.linear()).normalized()};
}

}  // namespace

Result<std::unique_ptr<VoxelTool>> VoxelTool::make(const TriangleMesh& tool, const std::vector<std::shared_ptr<const TriangleMesh>>& scene,
                                                   const ToolCoupling& coupling, double voxel_m) {
  // ToolStep::make checks the tool, the scene and the coupling.
  const auto checked = ToolStep::make(tool, scene, coupling);
  if (!checked) return tl::unexpected(checked.error());
  if (!(voxel_m > 0.0) || !std::isfinite(voxel_m)) return fail("a voxel of {} m: give a positive size", voxel_m);
  std::unique_ptr<VoxelTool> made(new VoxelTool);
  made->coupling_ = (*checked)->coupling();
  made->squared_lever_m2_ = made->coupling_.rotational_stiffness_nm_per_rad / made->coupling_.stiffness_n_per_m;

  Box box;
  for (const auto& mesh : scene) box.grow(Box::of(mesh->vertices));
  made->grid_ = {box.low - Vec3::Constant(voxel_m), voxel_m};  // one cell of margin
  const Vec3 cells = ((box.high - box.low) / voxel_m).array().floor() + 3.0;
  if (!(cells.prod() <= kMaxCells)) {
    return fail("a voxel of {:.3g} m makes a grid of {:.3g} cells; {:.3g} m fits", voxel_m, cells.prod(),
                voxel_m * std::cbrt(cells.prod() / kMaxCells) * 1.05);
  }
  made->cells_ = cells.cast<int>();
  made->is_surface_.assign((static_cast<std::size_t>(cells.prod()) + 63) / 64, 0);
  for (const auto& mesh : scene) {
    const auto voxels = find_surface_voxels(*mesh, made->grid_);
    if (!voxels) return tl::unexpected(voxels.error());
    for (const SurfaceVoxel& voxel : *voxels) {
      if ((voxel.cell.array() < 0).any() || (voxel.cell.array() >= made->cells_.array()).any()) continue;
      const std::size_t n = index_of(voxel.cell, made->cells_);
      made->is_surface_[n / 64] |= std::uint64_t{1} << n % 64;
    }
  }

  const VoxelGrid tool_grid{Vec3::Zero(), voxel_m};
  const auto shell = find_surface_voxels(tool, tool_grid);
  if (!shell) return tl::unexpected(shell.error());
  for (const SurfaceVoxel& voxel : *shell) {
    if (voxel.normal.isZero(0.0)) continue;
    made->points_.push_back({tool_grid.centre_m(voxel.cell), -voxel.normal});
    made->radius_m_ = std::max(made->radius_m_, made->points_.back().r_m.norm());
  }
  if (made->points_.empty()) return fail("a tool of these voxels has no points; give a smaller voxel than {:.3g} m", voxel_m);
  return made;
}

bool VoxelTool::is_surface(const Eigen::Vector3i& cell) const noexcept {
  const std::size_t n = index_of(cell, cells_);
  return (is_surface_[n / 64] >> n % 64 & 1U) != 0;
}

// Sums up the springs that act on the proxy: for a small displacement x (translation and rotation) their energy is
// 1/2 x^T hessian x - pull^T x. Returns the number of points in contact.
int VoxelTool::gather(const Placement& device, Mat6& hessian, Vec6& pull) const noexcept {
  const Mat3 R = proxy_.orientation.toRotationMatrix();
  Mat6 contacts = Mat6::Zero();
  Vec6 push = Vec6::Zero();
  int count = 0;
  for (const Point& point : points_) {
    const Vec3 r = R * point.r_m;
    const Vec3 p = proxy_.position + r;
    const Vec3 in_cells = ((p - grid_.origin_m) / grid_.voxel_m).array().floor();
    if (!((in_cells.array() >= 0.0).all() && (in_cells.array() < cells_.cast<double>().array()).all())) continue;
    const Eigen::Vector3i cell = in_cells.cast<int>();
    if (!is_surface(cell)) continue;
    const Vec3 n = R * point.inward;
    const double depth_m = (grid_.centre_m(cell) - p).dot(n);
    if (!(depth_m > 0.0)) continue;
    ++count;
    Vec6 motion;
    motion << n, r.cross(n);
    contacts += motion * motion.transpose();
    push += depth_m * motion;
  }
  const double stiffness = coupling_.stiffness_n_per_m * kContactStiffness / std::max(1.0, count / kFullContacts);
  hessian = stiffness * contacts;
  hessian.diagonal().head<3>().array() += coupling_.stiffness_n_per_m;
  hessian.diagonal().tail<3>().array() += coupling_.rotational_stiffness_nm_per_rad;
  pull = stiffness * push;
  pull.head<3>() += coupling_.stiffness_n_per_m * (device.position - proxy_.position);
  pull.tail<3>() += coupling_.rotational_stiffness_nm_per_rad * turn_between(proxy_.orientation, device.orientation);
  return count;
}

void VoxelTool::reset(const ToolInput& input) noexcept {
  if (!input.X_WD.matrix().allFinite() || !input.X_WS.matrix().allFinite()) return;
  proxy_ = in_scene(input);
}

ToolOutput VoxelTool::step(const ToolInput& input) noexcept {
  ToolOutput output;
  output.X_WP = input.X_WD;
  if (!input.X_WD.matrix().allFinite() || !input.X_WS.matrix().allFinite()) return output;
  const Placement device = in_scene(input);
  Mat6 hessian;
  Vec6 pull;
  const int contacts = gather(device, hessian, pull);
  const Vec6 balance = Eigen::LDLT<Mat6>(hessian).solve(pull);
  RigidMotion motion{proxy_, balance.head<3>(), balance.tail<3>()};
  if (const double length = motion.length(radius_m_), most = 0.5 * grid_.voxel_m; length > most) motion = motion.scaled(most / length);
  proxy_ = motion.at(1.0);

  output.contact = contacts > 0;
  output.proxy.haptons = contacts;
  if (!output.contact) return output;
  const Mat3 R_WS = input.X_WS.linear();
  const Vec3 shift_m = proxy_.position - device.position;
  const Vec3 turn = turn_between(device.orientation, proxy_.orientation);
  output.force_n = coupling_.stiffness_n_per_m * (R_WS * shift_m);
  output.torque_nm = torque_share(turn) * coupling_.rotational_stiffness_nm_per_rad * (R_WS * turn);
  output.X_WP.translation() = input.X_WS * proxy_.position;
  output.X_WP.linear() = R_WS * proxy_.orientation.toRotationMatrix();
  return output;
}

std::string VoxelTool::describe() const {
  return fmt::format("tool by voxels of {:.4g} mm: {} points over a grid of {} x {} x {}\n", 1e3 * grid_.voxel_m, points_.size(),
                     cells_.x(), cells_.y(), cells_.z());
}

}  // namespace hapton
