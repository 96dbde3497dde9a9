#include "patch/patch_maker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/force/force_method.h"

namespace hapton {
namespace {

constexpr double kLeadS = 0.01;       // how far ahead of the hand the next patch is centred: about as long as it takes to make
constexpr double kLeaveShare = 0.35;  // of its radius from the centre: another one is due
constexpr double kGrowth = 1.3;       // so much more is known: another one is due
constexpr double kLiftSteps = 4.0;    // of the grid: a vertex moves by 0.87 of one at most
constexpr double kVelocityS = 0.02;   // over which the hand's velocity is a mean

}  // namespace

void PatchMaker::note_hand(const Vec3& p_SD, std::int64_t time_ns) noexcept {
  if (!p_SD.allFinite()) return;
  const double dt_s = 1e-9 * static_cast<double>(time_ns - std::exchange(time_ns_, time_ns));
  const Vec3 moved = p_SD - std::exchange(p_SD_, p_SD);
  if (has_hand_ && dt_s > 0.0) v_SD_ += std::min(dt_s / kVelocityS, 1.0) * (moved / dt_s - v_SD_);
  has_hand_ = true;
}

bool PatchMaker::is_left() const noexcept { return !p_SC_ || (p_SD_ - *p_SC_).norm() >= kLeaveShare * radius_m_; }

std::unique_ptr<Patch> PatchMaker::make_if_due(const PatchStore& store, std::uint32_t generation) {
  if (!has_hand_ || !store.has_begun()) return nullptr;
  if (!is_left() && made_from_ == store.revision()) return nullptr;
  made_from_ = store.revision();
  const Vec3 ahead = p_SD_ + kLeadS * v_SD_;
  const double here_m = store.known_radius(p_SD_);
  const double ahead_m = store.known_radius(ahead);
  const bool leads = ahead_m >= here_m && ahead_m > (ahead - p_SD_).norm();
  const double known_m = leads ? ahead_m : here_m;
  const bool has_grown = known_m > kGrowth * radius_m_ && !is_limited_;
  if (!(known_m > 0.0) || !(is_left() || has_grown)) return nullptr;
  return make(store, leads ? ahead : p_SD_, known_m, generation);
}

std::unique_ptr<Patch> PatchMaker::make(const PatchStore& store, const Vec3& p_SC, double known_m, std::uint32_t generation) {
  PatchStore::Piece piece = store.make_piece(p_SC, known_m, kMostTriangles);
  auto patch = std::make_unique<Patch>();
  patch->p_SC = p_SC;
  patch->radius_m = piece.radius_m;
  patch->lift_m = kLiftSteps * store.begin().step_m;
  patch->generation = generation;
  if (!piece.scene.objects.empty()) {
    MethodSettings settings;
    settings.probe_radius_m = store.begin().probe_radius_m;
    auto method = make_method(settings, piece.scene);
    if (!method) return nullptr;
    patch->step = std::make_unique<TouchStep>(std::move(*method));
  }
  p_SC_ = p_SC;
  radius_m_ = piece.radius_m;
  triangles_ = piece.triangles;
  is_limited_ = piece.radius_m < known_m;
  return patch;
}

}  // namespace hapton
