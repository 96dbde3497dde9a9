#include "patch/patch_maker.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/force/deforming_method.h"
#include "core/force/force_method.h"
#include "runtime/clock.h"

namespace hapton {
namespace {

constexpr double kLeadS = 0.01;  // how far ahead of the hand the next patch is centred: about the time that a small one takes to make
// A new patch is due when the hand's distance from the centre of the newest one is more than this share of its radius, ...
constexpr double kLeaveShare = 0.35;
constexpr double kGrowth = 1.3;            // ... when the scene is known in a radius that is larger by this factor, ...
constexpr std::size_t kMoreTriangles = 2;  // ... or when there is time for this many times its triangles
constexpr double kLiftSteps = 4.0;         // lift_m in steps of the grid; rounding to it moves a vertex by at most 0.87 steps
constexpr double kVelocityS = 0.02;        // time constant of the hand's velocity
constexpr std::int64_t kRetryNs = 50 * kNanosecondsPerMillisecond;  // after a shape that no patch could be made of; a free choice
constexpr double kMinSpeed = 0.05;                                  // m/s: a hand at rest may start to move
constexpr double kTimeShare = 0.5;     // share of the time until the hand leaves a patch that making the next one may take
constexpr double kNewestWeight = 0.3;  // weight of the newest duration in the mean
constexpr double kPathRatio = 1.5;     // ratio of a patch's radius to PathBall::radius_m: the proxy may go around an obstacle
constexpr double kWiden = 2.0;         // factor on that radius for each patch that did not reach the hand
constexpr std::int64_t kPatienceNs = 50 * kNanosecondsPerMillisecond;  // then a patch over the path counts as not reaching the hand

}  // namespace

void PatchMaker::note_hand(const PatchHandState& hand) noexcept {
  if (!hand.p_SD.allFinite() || !hand.path.p_SC.allFinite()) return;
  const PatchHandState before = std::exchange(hand_, hand);
  const double dt_s = 1e-9 * static_cast<double>(hand.time_ns - before.time_ns);
  if (has_hand_ && dt_s > 0.0) v_SD_ += std::min(dt_s / kVelocityS, 1.0) * ((hand.p_SD - before.p_SD) / dt_s - v_SD_);
  has_hand_ = true;
  if (!hand.is_beyond) widening_ = 1.0;
}

void PatchMaker::note_made(double seconds) noexcept {
  if (triangles_ < few_triangles_ / 2 || !(seconds > 0.0)) return;
  s_per_triangle_ += kNewestWeight * (seconds / static_cast<double>(triangles_) - s_per_triangle_);
}

bool PatchMaker::is_hand_leaving() const noexcept {
  return !p_SC_ || (std::isfinite(radius_m_) && distance_m() >= kLeaveShare * radius_m_);
}

// The number of triangles for which there is time before the hand leaves the newest patch.
std::size_t PatchMaker::affordable() const noexcept {
  if (!p_SC_) return few_triangles_;
  const double room_m = std::max(radius_m_ - distance_m(), 0.0);
  const double count = kTimeShare * room_m / std::max(v_SD_.norm(), kMinSpeed) / s_per_triangle_;
  return static_cast<std::size_t>(std::clamp(count, static_cast<double>(few_triangles_), static_cast<double>(kMaxTriangles)));
}

bool PatchMaker::can_grow() const noexcept { return is_limited_ && affordable() >= kMoreTriangles * triangles_; }

std::unique_ptr<Patch> PatchMaker::make_if_due(const PatchStore& store, std::uint32_t generation) {
  if (!has_hand_ || !store.has_begun() || (failed_at_ == store.revision() && hand_.scene_time_ns < retry_ns_)) return nullptr;
  return hand_.is_beyond ? make_over_path(store, generation) : make_if_leaving(store, generation);
}

std::unique_ptr<Patch> PatchMaker::make_if_leaving(const PatchStore& store, std::uint32_t generation) {
  if (!is_hand_leaving() && !can_grow() && made_revision_ == store.revision()) return nullptr;
  made_revision_ = store.revision();
  const Vec3 ahead = hand_.p_SD + kLeadS * v_SD_;
  const double known_here_m = store.known_radius(hand_.p_SD, body_);
  const double known_ahead_m = store.known_radius(ahead, body_);
  const bool is_ahead = known_ahead_m >= known_here_m && known_ahead_m > (ahead - hand_.p_SD).norm();
  const double known_m = is_ahead ? known_ahead_m : known_here_m;
  const bool has_grown = known_m > kGrowth * radius_m_ && (!is_limited_ || can_grow());
  if (!(known_m > 0.0) || !(is_hand_leaving() || has_grown)) return nullptr;
  return make(store, is_ahead ? ahead : hand_.p_SD, known_m, 0.0, generation);
}

std::unique_ptr<Patch> PatchMaker::make_over_path(const PatchStore& store, std::uint32_t generation) {
  const PathBall& ball = hand_.path;
  const double known_m = store.known_radius(ball.p_SC, body_);
  if (known_m < kPathRatio * ball.radius_m) return make_without_path(store, generation);
  const bool covers = p_SC_ && radius_m_ >= (ball.p_SC - *p_SC_).norm() + widening_ * kPathRatio * ball.radius_m;
  if (covers && hand_.time_ns - made_ns_ < kPatienceNs) return nullptr;
  if (covers) widening_ *= kWiden;
  return make(store, ball.p_SC, known_m, widening_ * kPathRatio * ball.radius_m, generation);
}

// Parts of the scene along the path are missing: makes a patch at the hand; contact continues from above the plane (see PatchTouch).
std::unique_ptr<Patch> PatchMaker::make_without_path(const PatchStore& store, std::uint32_t generation) {
  if (!is_path_incomplete_) p_SC_.reset();
  auto patch = make_if_leaving(store, generation);
  if (patch != nullptr) patch->is_path_incomplete = is_path_incomplete_ = true;
  return patch;
}

// Null: the present shape of the surface is not known.
Result<std::unique_ptr<ForceMethod>> PatchMaker::make_touch(const PatchStore& store, const TouchScene& scene, Patch& patch) {
  MethodSettings settings;
  settings.probe_radius_m = store.begin().probe_radius_m;
  const StreamedParts* const stream = store.find_stream(body_);
  if (stream == nullptr) return scene.has_deformation() ? DeformingMethod::make(settings, scene) : make_method(settings, scene);
  auto streamed = shaper_.make(settings, scene.objects.front(), *stream, store.shapes(), hand_.scene_time_ns);
  if (!streamed) return tl::unexpected(streamed.error());
  patch.streamed = streamed->get();
  patch.number = shaper_.number();
  return std::move(*streamed);
}

std::unique_ptr<PatchShape> PatchMaker::make_stage_if_due(const PatchStore& store) {
  const StreamedParts* const stream = store.has_begun() ? store.find_stream(body_) : nullptr;
  return stream != nullptr ? shaper_.make_next(*stream, store.shapes(), hand_.scene_time_ns) : nullptr;
}

// min_radius_m: the patch gets all triangles that this radius needs, even if there is no time for so many.
std::unique_ptr<Patch> PatchMaker::make(const PatchStore& store, const Vec3& p_SC, double known_m, double min_radius_m,
                                        std::uint32_t generation) {
  std::size_t max_triangles = affordable();
  PatchStore::Piece piece = store.make_piece(p_SC, known_m, max_triangles, body_);
  while (piece.radius_m < std::min(min_radius_m, known_m) && max_triangles < kMaxTriangles)
    piece = store.make_piece(p_SC, known_m, max_triangles *= 2, body_);
  auto patch = std::make_unique<Patch>();
  patch->p_SC = p_SC;
  patch->radius_m = piece.radius_m;
  patch->lift_m = kLiftSteps * store.begin().step_m;
  patch->generation = generation;
  if (!piece.scene.objects.empty()) {
    for (const TouchObject& object : piece.scene.objects) patch->materials.push_back(object.material);
    patch->shared = patch->materials;
    for (Material& material : patch->shared) material = shared_material(material);
    auto method = make_touch(store, piece.scene, *patch);
    if (!method || *method == nullptr) {
      failed_at_ = store.revision();
      // Another shape of a body that programs deform may begin without another part.
      const bool may_change = store.find_stream(body_) != nullptr;
      retry_ns_ = may_change ? hand_.scene_time_ns + kRetryNs : std::numeric_limits<std::int64_t>::max();
      return nullptr;
    }
    patch->step = std::make_unique<TouchStep>(std::move(*method));
    patch->objects = std::move(piece.objects);
    patch->deforms = piece.scene.has_deformation();
    patch->material_version = store.material_version();
  }
  p_SC_ = p_SC;
  radius_m_ = piece.radius_m;
  triangles_ = piece.triangles;
  is_limited_ = piece.radius_m < known_m;
  made_revision_ = store.revision();
  made_ns_ = hand_.time_ns;
  is_path_incomplete_ = false;
  return patch;
}

}  // namespace hapton
