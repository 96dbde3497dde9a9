#include "tools/bench/patch_method.h"

#include <fmt/format.h>

#include <utility>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/seal_cracks.h"
#include "patch/tile_partition.h"
#include "runtime/clock.h"

namespace hapton {
namespace {

constexpr int kMaxPatchesPerSample = 64;  // patches tried for one sample; each is wider than the one before
constexpr double kRepeatedStepS = 1e-9;   // duration of a step that is repeated on a larger patch: too short for any motion
// Longer than the maker waits for a patch to reach the hand.
constexpr std::int64_t kTimePerPatchNs = 100 * kNanosecondsPerMillisecond;
constexpr double kReportedMakeS = 1e3;  // reported as the time to make a patch, so that the maker keeps patches small

TriangleMesh on_grid(TriangleMesh mesh, const PatchGrid& grid) {
  for (Vec3& vertex : mesh.vertices) vertex = grid.at(grid.round(vertex));
  return mesh;
}

}  // namespace

PatchMethod::PatchMethod(const MethodSettings& settings, const TouchScene& scene) : maker_(kTrianglesPerPatch) {
  const TiledScene tiled = make_tiles(scene);
  std::uint32_t serial = 1;
  store_.accept(PatchBegin{1, serial++, tiled.grid.origin_m, tiled.grid.step_m, settings.probe_radius_m, 0});
  for (const TileCell& cell : tiled.cells) store_.accept(to_message(cell, 1, serial++));
  for (PatchTile tile : tiled.tiles) {
    tile.epoch = 1;
    tile.serial = serial++;
    store_.accept(tile);
  }
}

void PatchMethod::make_patch(const Vec3& p_SD) {
  now_ns_ += kTimePerPatchNs;
  maker_.note_hand(touch_.hand_at(p_SD, now_ns_));
  (void)touch_.take_retired();
  if (auto patch = maker_.make_if_due(store_, 0)) {
    maker_.note_made(kReportedMakeS);
    (void)touch_.offer(std::move(patch));
  }
}

MethodOutput PatchMethod::step(const MethodInput& input) noexcept {
  if (!input.p_SD.allFinite()) return {};
  make_patch(input.p_SD);
  auto touched = touch_.step({.p_WD = input.p_SD, .dt_s = input.dt_s});
  for (int n = 0; n < kMaxPatchesPerSample && (!touched || touched->is_beyond); ++n) {
    make_patch(input.p_SD);
    touched = touch_.step({.p_WD = input.p_SD, .dt_s = kRepeatedStepS});
  }
  if (!touched) return {.p_SP = input.p_SD};
  return {.force_n = touched->force_n, .p_SP = input.p_SD + touched->visual_offset_m, .contact = touched->contact};
}

void PatchMethod::reset(const Vec3& p_SD) noexcept {
  touch_.forget();
  touch_.start_at(p_SD, Vec3::Zero());
}

std::string PatchMethod::describe() const {
  const PatchTouch::Counts& counts = touch_.counts();
  return fmt::format("patches of about {} triangles: {} taken over in {} steps, {} times past the edge of one\n", kTrianglesPerPatch,
                     counts.handed_over, counts.steps, counts.beyond);
}

StressBody on_patch_grid(StressBody body) {
  SealReport sealed;
  body.touched = seal_cracks(std::move(body.touched), sealed);
  const MeshBounds bounds = compute_bounds(body.touched);
  const PatchGrid grid = PatchGrid::around({bounds.low, bounds.high});
  body.touched = on_grid(std::move(body.touched), grid);
  body.solid = on_grid(std::move(body.solid), grid);
  return body;
}

}  // namespace hapton
