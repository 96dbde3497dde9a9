#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "link/messages.h"
#include "patch/patch_store.h"
#include "patch/patch_touch.h"

namespace hapton {

// Decides when the hand needs a new patch, and makes it. Its centre is where the hand will be when the patch is ready. It is as wide as the
// scene is known there, but has no more triangles than can be processed before the hand leaves the present patch. So patches grow, from a
// small first one up to the whole scene. For a hand past the edge the patch covers the whole path since the edge.
// Frame: S. Units: SI. RT: no. Threads: one.
class PatchMaker {
 public:
  static constexpr std::size_t kFewTriangles = 8192;                                                 // about 5 ms to make
  static constexpr std::size_t kMostTriangles = PatchStore::kMostTiles * PatchTile::kMostTriangles;  // all that can be known
  static constexpr double kFirstMakeS = 1e-6;                                                        // time per triangle, until it is known

  // few: triangles that a patch may always have.
  explicit PatchMaker(std::size_t few = kFewTriangles) : few_(few) {}

  // Where the hand is. Times of one clock, in order.
  void note_hand(const PatchHand& hand) noexcept;
  // How long the newest patch took to make, and to be handed to the device.
  void note_made(double seconds) noexcept;
  // Earlier patches are no longer valid.
  void forget() noexcept { p_SC_.reset(); }
  // Null: the newest patch suffices, or nothing is known there.
  std::unique_ptr<Patch> make_if_due(const PatchStore& store, std::uint32_t generation);

  std::size_t triangles() const noexcept { return triangles_; }  // of the newest
  double radius_m() const noexcept { return radius_m_; }

 private:
  std::unique_ptr<Patch> make_if_left(const PatchStore& store, std::uint32_t generation);
  std::unique_ptr<Patch> make_over_way(const PatchStore& store, std::uint32_t generation);
  std::unique_ptr<Patch> make_beside_way(const PatchStore& store, std::uint32_t generation);
  std::unique_ptr<Patch> make(const PatchStore& store, const Vec3& p_SC, double known_m, double least_m, std::uint32_t generation);
  double distance_m() const noexcept { return (hand_.p_SD - *p_SC_).norm(); }
  bool is_left() const noexcept;
  bool can_grow() const noexcept;
  std::size_t affordable() const noexcept;

  std::size_t few_;
  PatchHand hand_;
  Vec3 v_SD_ = Vec3::Zero();
  bool has_hand_ = false;
  std::optional<Vec3> p_SC_;  // of the newest patch
  double radius_m_ = 0.0;
  std::size_t triangles_ = 0;
  bool is_limited_ = false;      // by its triangles: more was known
  std::uint64_t made_from_ = 0;  // the store's revision then
  std::int64_t made_ns_ = 0;     // the hand's time then
  bool is_way_unknown_ = false;  // of the newest
  double widening_ = 1.0;        // of a patch over the way, once more for each that did not reach
  double triangle_s_ = kFirstMakeS;
};

}  // namespace hapton
