#include "patch/patch_maker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/force/force_method.h"
#include "runtime/clock.h"

namespace hapton {
namespace {

constexpr double kLeadS = 0.01;       // how far ahead of the hand the next patch is centred: about as long as a small one takes to make
constexpr double kLeaveShare = 0.35;  // of its radius from the centre: another one is due
constexpr double kGrowth = 1.3;       // so much more is known: another one is due
constexpr std::size_t kMoreTriangles = 2;  // so many times more can be made by now: another one is due
constexpr double kLiftSteps = 4.0;         // of the grid: a vertex moves by 0.87 of one at most
constexpr double kVelocityS = 0.02;        // over which the hand's velocity is a mean
constexpr double kLeastSpeed = 0.05;       // m/s: a hand at rest may start
constexpr double kTimeShare = 0.5;         // of the time until the hand is out, for making the next one
constexpr double kMakeShare = 0.3;         // of the newest duration in the mean
constexpr double kWayShare = 1.5;          // of the ball about the way: the proxy may go round
constexpr double kWiden = 2.0;
constexpr std::int64_t kPatienceNs = 50 * kNanosecondsPerMillisecond;  // for a patch over the way to be taken and followed

}  // namespace

void PatchMaker::note_hand(const PatchHand& hand) noexcept {
  if (!hand.p_SD.allFinite() || !hand.way.p_SC.allFinite()) return;
  const PatchHand before = std::exchange(hand_, hand);
  const double dt_s = 1e-9 * static_cast<double>(hand.time_ns - before.time_ns);
  if (has_hand_ && dt_s > 0.0) v_SD_ += std::min(dt_s / kVelocityS, 1.0) * ((hand.p_SD - before.p_SD) / dt_s - v_SD_);
  has_hand_ = true;
  if (!hand.is_beyond) widening_ = 1.0;
}

void PatchMaker::note_made(double seconds) noexcept {
  if (triangles_ < few_ / 2 || !(seconds > 0.0)) return;
  triangle_s_ += kMakeShare * (seconds / static_cast<double>(triangles_) - triangle_s_);
}

bool PatchMaker::is_left() const noexcept { return !p_SC_ || (std::isfinite(radius_m_) && distance_m() >= kLeaveShare * radius_m_); }

// How many triangles can be made into a patch before the hand is out of the newest one.
std::size_t PatchMaker::affordable() const noexcept {
  if (!p_SC_) return few_;
  const double room_m = std::max(radius_m_ - distance_m(), 0.0);
  const double count = kTimeShare * room_m / std::max(v_SD_.norm(), kLeastSpeed) / triangle_s_;
  return static_cast<std::size_t>(std::clamp(count, static_cast<double>(few_), static_cast<double>(kMostTriangles)));
}

bool PatchMaker::can_grow() const noexcept { return is_limited_ && affordable() >= kMoreTriangles * triangles_; }

std::unique_ptr<Patch> PatchMaker::make_if_due(const PatchStore& store, std::uint32_t generation) {
  if (!has_hand_ || !store.has_begun()) return nullptr;
  return hand_.is_beyond ? make_over_way(store, generation) : make_if_left(store, generation);
}

std::unique_ptr<Patch> PatchMaker::make_if_left(const PatchStore& store, std::uint32_t generation) {
  if (!is_left() && !can_grow() && made_from_ == store.revision()) return nullptr;
  made_from_ = store.revision();
  const Vec3 ahead = hand_.p_SD + kLeadS * v_SD_;
  const double here_m = store.known_radius(hand_.p_SD);
  const double ahead_m = store.known_radius(ahead);
  const bool leads = ahead_m >= here_m && ahead_m > (ahead - hand_.p_SD).norm();
  const double known_m = leads ? ahead_m : here_m;
  const bool has_grown = known_m > kGrowth * radius_m_ && (!is_limited_ || can_grow());
  if (!(known_m > 0.0) || !(is_left() || has_grown)) return nullptr;
  return make(store, leads ? ahead : hand_.p_SD, known_m, 0.0, generation);
}

std::unique_ptr<Patch> PatchMaker::make_over_way(const PatchStore& store, std::uint32_t generation) {
  const PatchWay& way = hand_.way;
  const double known_m = store.known_radius(way.p_SC);
  if (known_m < kWayShare * way.radius_m) return make_beside_way(store, generation);
  const bool covers = p_SC_ && radius_m_ >= (way.p_SC - *p_SC_).norm() + widening_ * kWayShare * way.radius_m;
  if (covers && hand_.time_ns - made_ns_ < kPatienceNs) return nullptr;
  if (covers) widening_ *= kWiden;
  return make(store, way.p_SC, known_m, widening_ * kWayShare * way.radius_m, generation);
}

// Parts of the way have not come: touch may go on from above the plane where the hand is.
std::unique_ptr<Patch> PatchMaker::make_beside_way(const PatchStore& store, std::uint32_t generation) {
  if (!is_way_unknown_) p_SC_.reset();
  auto patch = make_if_left(store, generation);
  if (patch != nullptr) patch->is_way_unknown = is_way_unknown_ = true;
  return patch;
}

// least_m: with as many triangles as that takes.
std::unique_ptr<Patch> PatchMaker::make(const PatchStore& store, const Vec3& p_SC, double known_m, double least_m,
                                        std::uint32_t generation) {
  std::size_t most = affordable();
  PatchStore::Piece piece = store.make_piece(p_SC, known_m, most);
  while (piece.radius_m < std::min(least_m, known_m) && most < kMostTriangles) piece = store.make_piece(p_SC, known_m, most *= 2);
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
    patch->objects = std::move(piece.objects);
  }
  p_SC_ = p_SC;
  radius_m_ = piece.radius_m;
  triangles_ = piece.triangles;
  is_limited_ = piece.radius_m < known_m;
  made_from_ = store.revision();
  made_ns_ = hand_.time_ns;
  is_way_unknown_ = false;
  return patch;
}

}  // namespace hapton
