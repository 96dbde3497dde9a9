#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "link/messages.h"
#include "patch/patch_shaper.h"
#include "patch/patch_store.h"
#include "patch/patch_touch.h"

namespace hapton {

// Decides when the hand needs a new patch, and makes it. Its centre is where the hand will be when the patch is ready. Its radius is the
// one within which the scene is known there, but no larger than can be made before the hand leaves the present patch. So patches grow,
// from a small first one up to the whole scene. If the hand is past the edge of its patch, the new one covers its path since the edge.
// Frame: that of the body, which is S if it stands still. Units: SI. RT: no. Threads: one.
class PatchMaker {
 public:
  static constexpr std::size_t kFewTriangles = 8192;  // triangles that a patch may have at any speed of the hand: 5 ms to make
  static constexpr std::size_t kMaxTriangles = PatchStore::kMaxTiles * PatchTile::kMaxTriangles;  // of the largest scene
  static constexpr double kFirstMakeS = 1e-6;  // time to make a patch, for each triangle, before the first measurement

  // few_triangles: the value to use for kFewTriangles. body: its number in the scene; the hand is given in its frame.
  explicit PatchMaker(std::size_t few_triangles = kFewTriangles, std::uint32_t body = 0) : few_triangles_(few_triangles), body_(body) {}

  // Takes the position of the hand. Pre: times of one clock, in ascending order.
  void note_hand(const PatchHandState& hand) noexcept;
  // Takes the time from the start of making the newest patch until it was offered to the device loop.
  void note_made(double seconds) noexcept;
  // Forgets the newest patch, for a new scene.
  void forget() noexcept {
    p_SC_.reset();
    failed_at_.reset();
    shaper_.forget();
  }
  // Makes a patch if one is due. Null: the newest suffices, no part of the scene is known there, or none can be made of the known parts.
  std::unique_ptr<Patch> make_if_due(const PatchStore& store, std::uint32_t generation);

  // Makes the next stage of the newest patch if programs deform the body; null: there is none.
  std::unique_ptr<PatchShape> make_stage_if_due(const PatchStore& store);

  // These two are of the newest patch.
  std::size_t triangles() const noexcept { return triangles_; }
  double radius_m() const noexcept { return radius_m_; }

 private:
  std::unique_ptr<Patch> make_if_leaving(const PatchStore& store, std::uint32_t generation);
  std::unique_ptr<Patch> make_over_path(const PatchStore& store, std::uint32_t generation);
  std::unique_ptr<Patch> make_without_path(const PatchStore& store, std::uint32_t generation);
  std::unique_ptr<Patch> make(const PatchStore& store, const Vec3& p_SC, double known_m, double min_radius_m, std::uint32_t generation);
  Result<std::unique_ptr<ForceMethod>> make_touch(const PatchStore& store, const TouchScene& scene, Patch& patch);
  double distance_m() const noexcept { return (hand_.p_SD - *p_SC_).norm(); }
  bool is_hand_leaving() const noexcept;
  bool can_grow() const noexcept;
  std::size_t affordable() const noexcept;

  std::size_t few_triangles_;
  std::uint32_t body_;
  PatchHandState hand_;
  Vec3 v_SD_ = Vec3::Zero();
  bool has_hand_ = false;
  // Down to is_path_incomplete_: of the newest patch.
  std::optional<Vec3> p_SC_;  // centre; none: there is no patch
  double radius_m_ = 0.0;
  std::size_t triangles_ = 0;
  bool is_limited_ = false;                 // there was no time for all triangles that were known
  std::uint64_t made_revision_ = 0;         // PatchStore::revision() when it was made
  std::int64_t made_ns_ = 0;                // PatchHandState::time_ns when it was made
  bool is_path_incomplete_ = false;         // Patch::is_path_incomplete
  std::optional<std::uint64_t> failed_at_;  // PatchStore::revision() at which no patch could be made
  std::int64_t retry_ns_ = 0;               // the scene time from which it is tried again at that revision
  double widening_ = 1.0;                   // power of kWiden
  PatchShaper shaper_;                      // makes the stages of a body that programs deform
  double s_per_triangle_ = kFirstMakeS;     // mean time to make a patch, for each triangle
};

}  // namespace hapton
