#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/collision/swept_sphere.h"
#include "core/force/proxy/proxy_state.h"

namespace hapton {

// One straight motion of a probe among any triangles: how far it goes until something stops it, and what that is.
//
// A long path is searched in growing pieces, because what stops the probe is mostly near the start. A piece whose box holds many triangles
// is cut, because most of them are far from the path. Where the probe itself is among so many, pieces begin at a quarter of the clearance,
// and only triangles within a ball around a piece are tested, however many. When the work is used up in the first piece, the search is
// interrupted, and the next call goes on with the next triangle; in a later piece the motion ends before that piece, with no blocker.
//
// Frame: TouchGeometry's local one. RT: yes. Keeps a reference. Pre: the geometry stays the same from start() to the end.
class StraightSweep {
 public:
  enum class End : std::uint8_t {
    free,         // nothing stops the probe before the end of the motion
    stopped,      // at time(): by blockers(), or if there are none, because the work was used up
    interrupted,  // the work is used up: the next call goes on
  };
  struct Blocker {
    std::uint32_t triangle = 0;
    double time = 0.0;
    double rate = 0.0;  // of change of a sphere's distance to the triangle at the start of the motion; a point: 0
  };

  StraightSweep(const ProxySurfaces& surfaces, bool is_point) : surfaces_(surfaces), is_point_(is_point) {}

  void start(const Vec3& from, const Vec3& motion) noexcept;
  // Adds to the contacts of the proxy the triangles that a sphere touches at the start. If they are full, the first `fixed_count` ones
  // stay, and of the others the nearest. `work` is raised by the number of triangles tested. Pre: clearance is the same from start() on.
  End go_on(ProxyState& proxy, const Clearance& clearance, int fixed_count, int& work, int most_work) noexcept;
  bool is_interrupted() const { return is_interrupted_; }
  void drop() noexcept {
    is_crowded_ = false;
    is_interrupted_ = false;
    crowded_length_ = 0.0;
  }

  const Vec3& from() const { return from_; }
  const Vec3& motion() const { return motion_; }
  double time() const { return stop_time_; }
  // What stops the probe at time() or hardly later, at most ProxyState::kMaxContacts: the first ones, and of several at the start those
  // that the motion comes nearer to fastest. None: nothing stops it, or the work was used up.
  std::span<const Blocker> blockers() const { return std::span(blockers_).first(static_cast<std::size_t>(blocker_count_)); }
  std::uint64_t tests() const { return tests_; }  // since construction

 private:
  bool search_box(ProxyState& proxy, const Clearance& clearance, int fixed_count, int& work) noexcept;
  bool search_ball(ProxyState& proxy, const Clearance& clearance, int fixed_count, int& work, int most_work) noexcept;
  void choose_next_piece() noexcept;
  void shorten_piece(const Clearance& clearance) noexcept;
  bool is_among_many(const Clearance& clearance) const noexcept;
  void test(std::uint32_t triangle, ProxyState& proxy, const Clearance& clearance, int fixed_count) noexcept;
  void note_grazed(ProxyState& proxy, const Separation& at, std::uint32_t triangle, const Clearance& clearance,
                   int fixed_count) const noexcept;
  void note_blocker(const Blocker& blocker) noexcept;

  const ProxySurfaces& surfaces_;
  bool is_point_;
  Vec3 from_ = Vec3::Zero();
  Vec3 motion_ = Vec3::Zero();
  double free_until_ = 0.0;    // up to this time nothing stops the probe
  double piece_end_ = 0.0;     // time at the end of this piece
  double piece_length_ = 0.0;  // length of this piece, in time
  double stop_time_ = kNever;
  int cut_count_ = 0;
  int tested_in_piece_ = 0;  // in this piece
  bool is_crowded_ = false;  // pieces are searched in balls
  bool is_interrupted_ = false;
  int least_tested_ = 0;         // least number of triangles tested in a ball of this motion
  double crowded_length_ = 0.0;  // length of the next piece, if the work was used up between two balls; 0: it was not
  TouchGeometry::NearestSearch ball_;
  std::array<Blocker, ProxyState::kMaxContacts> blockers_;
  int blocker_count_ = 0;
  std::uint64_t tests_ = 0;
};

}  // namespace hapton
