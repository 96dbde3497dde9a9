#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/collision/sweep_line.h"
#include "core/collision/uniform_grid.h"
#include "core/collision/visit_stamps.h"
#include "core/force/force_method.h"

namespace hapton {

// Counters over all steps; "step 1" to "step 5" are the steps of the memo's algorithm, at which a test of a triangle or cell may end.
struct SweepCounters {
  std::uint64_t cells_visited = 0;
  std::uint64_t empty_cells = 0;         // ended at step 1
  std::uint64_t repeated_triangles = 0;  // found again in another cell, not tested again
  std::uint64_t triangles_tested = 0;    // reached step 2
  std::uint64_t parallel = 0;            // ended at step 2
  std::uint64_t out_of_length = 0;       // ended at step 3
  std::uint64_t out_of_triangle = 0;     // ended at step 4
  std::uint64_t from_behind = 0;         // collisions rejected: with the back of a one-sided triangle
  std::uint64_t collisions = 0;          // stored at step 5: the memo's M
};

// The complete method of the HP memo: tests the line between two samples against the triangles in the grid cells that its box meets. The
// collision with the greatest penetration depth gives a Hooke force along the triangle's normal, towards the side that the probe came from.
// Choices that the memo leaves open: docs/decisions/0001-memo-sweep.md. The probe is a point. TouchStep adds damping and friction
// (unrendered_drag). Frame S, SI units.
// Source: memo 4.2.2.
// RT: step, reset, set_materials, unrendered_drag and counters yes; make and describe set-up only. Threads: one.
class SweepMethod final : public ForceMethod {
 public:
  // Error: an impossible grid division or offset, a probe with a radius, a scene in which no triangle has an area.
  static Result<std::unique_ptr<ForceMethod>> make(const MethodSettings& settings, const TouchScene& scene);

  MethodOutput step(const MethodInput& input) noexcept override;
  void reset(const Vec3& p_SD) noexcept override;
  void set_materials(std::span<const Material> materials) noexcept override;
  std::span<const Material> unrendered_drag() const noexcept override { return triangles_.materials; }
  std::string describe() const override;

  const UniformGrid& grid() const { return grid_; }
  const SweepCounters& counters() const { return counters_; }
  std::uint64_t steps() const { return steps_; }

 private:
  // The collision with the greatest depth, measured along the line.
  struct Deepest {
    SweepCollision collision;
    std::uint32_t triangle = 0;
    bool found = false;
  };

  // The scene's triangles that have an area, with their objects.
  struct Triangles {
    std::vector<TrianglePlane> planes;
    std::vector<std::uint32_t> object_of;
    std::vector<Material> materials;  // of each object
    std::size_t degenerate = 0;       // triangles without an area, left out
  };

  SweepMethod(UniformGrid grid, Triangles triangles, double offset_m)
      : grid_(std::move(grid)), triangles_(std::move(triangles)), offset_m_(offset_m), stamps_(triangles_.planes.size()) {}
  static Triangles gather(const TouchScene& scene, std::vector<std::array<Vec3, 3>>& corners);
  Vec3 within_limits(const Vec3& p_SD) const noexcept;
  Deepest find_deepest(const SweepLine& line) noexcept;
  void test_cell(const SweepLine& line, std::span<const std::uint32_t> triangles, Deepest& deepest) noexcept;
  void test_triangle(const SweepLine& line, std::uint32_t triangle, Deepest& deepest) noexcept;

  UniformGrid grid_;
  Triangles triangles_;
  double offset_m_;
  VisitStamps stamps_;
  bool has_started_ = false;
  Vec3 line_start_ = Vec3::Zero();  // start of the next sweep line, frame S
  SweepCounters counters_;
  std::uint64_t steps_ = 0;
};

}  // namespace hapton
