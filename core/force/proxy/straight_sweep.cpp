#include "core/force/proxy/straight_sweep.h"

#include <algorithm>
#include <limits>
#include <tuple>

namespace hapton {
namespace {

constexpr double kFirstPiece = 0x1p-6;  // share of the whole motion
constexpr double kMinPiece = 0x1p-14;   // share of the whole motion
constexpr double kPieceGrowth = 4.0;    // factor from one piece to the next
constexpr int kMaxInBox = 128;          // most triangles in the box of a piece; a piece whose box holds more is cut
constexpr int kMaxCuts = 4;             // most cuts of pieces in one motion; after these, balls are searched instead of boxes
constexpr int kFewTests = 16;           // after a cut: if a box needed no more tests than this, the next piece is longer
constexpr int kFewInBall = 48;          // if a ball needed no more tests than this, the next piece is longer
constexpr double kShortPiece = 0.25;    // share of the offset of the clearance: length of the first piece among many triangles
constexpr int kMinTests = 64;           // tests of each search in a ball, however little work is left

}  // namespace

void StraightSweep::start(const Vec3& from, const Vec3& motion) noexcept {
  from_ = from;
  motion_ = motion;
  free_until_ = 0.0;
  piece_length_ = kFirstPiece;
  stop_time_ = kNever;
  cut_count_ = 0;
  is_crowded_ = crowded_length_ > 0.0;  // continues with pieces as long as the last ones of the previous motion
  if (is_crowded_) piece_length_ = std::min(1.0, std::max(kMinPiece, crowded_length_ / motion.norm()));
  crowded_length_ = 0.0;
  least_tested_ = std::numeric_limits<int>::max();
  is_interrupted_ = false;
  blocker_count_ = 0;
}

StraightSweep::End StraightSweep::go_on(ProxyState& proxy, const Clearance& clearance, int fixed_count, int& work, int most_work) noexcept {
  while (free_until_ < 1.0) {
    if (!is_interrupted_) {
      piece_end_ = std::min(1.0, free_until_ + piece_length_);
      stop_time_ = kNever;
      blocker_count_ = 0;
      tested_in_piece_ = 0;
      if (is_crowded_) ball_.start(from_ + (0.5 * (free_until_ + piece_end_)) * motion_);
    }
    if (is_crowded_) {
      is_interrupted_ = !search_ball(proxy, clearance, fixed_count, work, most_work);
      if (is_interrupted_ && free_until_ == 0.0) return End::interrupted;
      if (is_interrupted_) {
        // The part of the motion before this piece is free: the probe goes to its end, and the next call begins with this piece.
        is_interrupted_ = false;
        crowded_length_ = (piece_end_ - free_until_) * motion_.norm();
        stop_time_ = free_until_;
        blocker_count_ = 0;
        return End::stopped;
      }
    } else if (!search_box(proxy, clearance, fixed_count, work)) {
      shorten_piece(clearance);
      continue;
    }
    if (stop_time_ <= piece_end_) return End::stopped;
    free_until_ = piece_end_;
    choose_next_piece();
    if (work > most_work && free_until_ < 1.0) {
      if (is_crowded_) crowded_length_ = piece_length_ * motion_.norm();
      stop_time_ = free_until_;
      return End::stopped;
    }
  }
  return End::free;
}

// False: the box of this piece holds too many triangles.
bool StraightSweep::search_box(ProxyState& proxy, const Clearance& clearance, int fixed_count, int& work) noexcept {
  const Box path = Box::around(from_ + free_until_ * motion_, from_ + piece_end_ * motion_).inflated(clearance.offset);
  bool fits = true;
  surfaces_.geometry().for_each_overlapping(path, [&](std::uint32_t triangle) {
    if (tested_in_piece_ == kMaxInBox) return fits = false;
    ++work;
    test(triangle, proxy, clearance, fixed_count);
    return true;
  });
  return fits;
}

// False: the work of this step is used up.
bool StraightSweep::search_ball(ProxyState& proxy, const Clearance& clearance, int fixed_count, int& work, int most_work) noexcept {
  const double radius = clearance.offset + 4.0 * clearance.tolerance + 0.5 * (piece_end_ - free_until_) * motion_.norm();
  for (int count = 0;; ++count) {
    if (count >= kMinTests && work > most_work) return false;
    const auto triangle = ball_.next(surfaces_.geometry(), radius * radius);
    if (!triangle) return true;
    ++work;
    test(*triangle, proxy, clearance, fixed_count);
  }
}

// Cuts the piece, or changes to balls: where the probe reaches too many triangles even without moving, shorter boxes hold too many as well.
void StraightSweep::shorten_piece(const Clearance& clearance) noexcept {
  if (cut_count_ < kMaxCuts && !is_among_many(clearance)) {
    ++cut_count_;
    piece_length_ = (piece_end_ - free_until_) / kPieceGrowth;
    return;
  }
  is_crowded_ = true;
  piece_length_ = std::min(1.0, std::max(kShortPiece * clearance.offset / motion_.norm(), kMinPiece));
}

// Among many triangles the next piece is longer if this one held hardly more of them than shorter ones, as along an edge that all share.
void StraightSweep::choose_next_piece() noexcept {
  if (!is_crowded_) {
    if (cut_count_ == 0 || tested_in_piece_ <= kFewTests) piece_length_ *= kPieceGrowth;
    return;
  }
  least_tested_ = std::min(least_tested_, std::max(tested_in_piece_, kFewInBall));
  if (tested_in_piece_ <= least_tested_ + least_tested_ / 4) {
    piece_length_ *= kPieceGrowth;
  } else if (tested_in_piece_ > 4 * least_tested_) {
    piece_length_ /= kPieceGrowth;
  }
}

bool StraightSweep::is_among_many(const Clearance& clearance) const noexcept {
  const Vec3 at = from_ + free_until_ * motion_;
  int count = 0;
  surfaces_.geometry().for_each_overlapping(Box{at, at}.inflated(clearance.offset), [&](std::uint32_t) { return ++count <= kMaxInBox; });
  return count > kMaxInBox;
}

void StraightSweep::test(std::uint32_t triangle, ProxyState& proxy, const Clearance& clearance, int fixed_count) noexcept {
  ++tests_;
  ++tested_in_piece_;
  const TriangleView shape{surfaces_.geometry(), triangle};
  const Separation at = shape.separation(from_);
  if (!is_point_) note_grazed(proxy, at, triangle, clearance, fixed_count);
  const double t = time_to_block(shape, from_, at, motion_, std::min(piece_end_, stop_time_), clearance);
  if (t > 1.0 || !surfaces_.can_touch(triangle, from_)) return;
  stop_time_ = std::min(stop_time_, t);
  note_blocker({triangle, t, is_point_ ? 0.0 : at.normal.dot(motion_)});
}

// A sphere on a face is also in contact with coplanar neighbours, although they never block its path.
void StraightSweep::note_grazed(ProxyState& proxy, const Separation& at, std::uint32_t triangle, const Clearance& clearance,
                                int fixed_count) const noexcept {
  if (at.distance > clearance.offset + 2.0 * clearance.tolerance) return;
  const auto begin = proxy.contacts.begin();
  const auto end = begin + proxy.contact_count;
  if (std::any_of(begin, end, [&](const ProxyContact& contact) { return contact.triangle == triangle; })) return;
  auto place = end;
  if (proxy.contact_count < ProxyState::kMaxContacts) {
    ++proxy.contact_count;
  } else {
    place = std::max_element(begin + fixed_count, end,
                             [](const ProxyContact& a, const ProxyContact& b) { return a.separation.distance < b.separation.distance; });
    if (at.distance >= place->separation.distance) return;
  }
  *place = {.triangle = triangle, .shape = surfaces_.shape_of(triangle), .separation = at};
}

void StraightSweep::note_blocker(const Blocker& blocker) noexcept {
  if (blocker_count_ < ProxyState::kMaxContacts) {
    blockers_[static_cast<std::size_t>(blocker_count_++)] = blocker;
    return;
  }
  const auto comes_later = [](const Blocker& a, const Blocker& b) { return std::tie(a.time, a.rate) < std::tie(b.time, b.rate); };
  const auto last = std::max_element(blockers_.begin(), blockers_.end(), comes_later);
  if (comes_later(blocker, *last)) *last = blocker;
}

}  // namespace hapton
