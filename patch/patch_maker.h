#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "patch/patch_store.h"
#include "patch/patch_touch.h"

namespace hapton {

// Decides when the hand needs another patch, and makes it: around where the hand will be once it is made, as wide as the scene is known
// there and as kMostTriangles allow. Frame: S. Units: SI. RT: no. Threads: one.
class PatchMaker {
 public:
  static constexpr std::size_t kMostTriangles = 8192;  // about 5 ms to make

  // Where the hand is. Times of one clock, in order.
  void note_hand(const Vec3& p_SD, std::int64_t time_ns) noexcept;
  // What was made before is of no use any more.
  void forget() noexcept { p_SC_.reset(); }
  // Null: the newest will do, or nothing is known there.
  std::unique_ptr<Patch> make_if_due(const PatchStore& store, std::uint32_t generation);

  std::size_t triangles() const noexcept { return triangles_; }  // of the newest
  double radius_m() const noexcept { return radius_m_; }

 private:
  std::unique_ptr<Patch> make(const PatchStore& store, const Vec3& p_SC, double known_m, std::uint32_t generation);
  bool is_left() const noexcept;

  Vec3 p_SD_ = Vec3::Zero();
  Vec3 v_SD_ = Vec3::Zero();
  std::int64_t time_ns_ = 0;
  bool has_hand_ = false;
  std::optional<Vec3> p_SC_;  // of the newest patch
  double radius_m_ = 0.0;
  std::size_t triangles_ = 0;
  bool is_limited_ = false;      // by its triangles: more was known
  std::uint64_t made_from_ = 0;  // the store's revision then
};

}  // namespace hapton
