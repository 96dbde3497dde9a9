#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>

#include "core/collision/object_geometry.h"
#include "core/collision/swept_sphere.h"
#include "core/force/sphere/centre_path.h"
#include "core/force/sphere/contact_frame.h"
#include "core/force/sphere/offset_surface.h"

namespace hapton {

// The contacts of a sphere's centre. The first active_count() of them hold it, at most three; the others were hit at the same position, and
// whether they hold it is not decided yet. The centre itself is an argument: `c`.
//
// Frame and units: TouchGeometry's local ones. RT: yes. `work`: is raised by the units of work (step_work.h).
class ContactSet {
 public:
  static constexpr int kMax = 8;  // three that hold the centre, and others at the same position; a free choice

  explicit ContactSet(const Clearance& clearance) : clearance_(clearance) {}

  // The distance that a centre in contact keeps, and how exactly.
  const Clearance& clearance() const { return clearance_; }
  double offset() const { return clearance_.offset; }

  int count() const { return count_; }
  int active_count() const { return active_count_; }
  bool is_empty() const { return count_ == 0; }
  bool is_flat() const { return std::ranges::none_of(active(), &OffsetContact::is_curved); }  // all active ones are on faces
  const OffsetContact& operator[](int i) const { return contacts_[i]; }
  OffsetContact& operator[](int i) { return contacts_[i]; }
  std::span<const OffsetContact> active() const { return std::span(contacts_).first(active_count_); }
  std::span<const OffsetContact> all() const { return std::span(contacts_).first(count_); }

  void clear() { active_count_ = count_ = 0; }
  // Adds a contact, not active; or replaces the one with the same triangle, active or not as that was. False: it is full.
  bool add(const OffsetContact& contact) noexcept;
  void remove(int i) noexcept;
  void keep_active() { count_ = active_count_; }
  void activate_all() { active_count_ = count_; }
  // Replaces all contacts by the given ones, all active. Pre: at most three.
  void hold_by(std::span<const OffsetContact> contacts) noexcept;
  // Keeps contact i alone, and makes it active.
  void keep_only(int i) noexcept;
  // Makes contact i the last active one. Pre: it is not active, and at most two are.
  void activate(int i) noexcept { std::swap((*this)[active_count_++], (*this)[i]); }
  int deactivate_last() { return --active_count_; }  // returns its index
  // Finds the contacts that hold the centre against the pull and makes them the active ones. Where the pull alone does not decide, the
  // device's `motion` does. `descent`: the component of the pull that they leave free. False: there is no solution within rounding.
  bool find_active(const Vec3& c, const Vec3& pull, const Vec3& motion, Vec3& descent) noexcept;
  // Sets the multipliers of the active contacts for a centre at their local minimum for the device.
  void note_multipliers(const Vec3& c, const Vec3& device) noexcept;

  // The frame of the active contacts' normals. False: two are parallel, or three in one plane, within rounding.
  bool find_frame(const Vec3& c, ContactFrame& frame) const noexcept;
  // Moves c to where it is at the offset from all active contacts, with Newton's method. False: no such position is found near c.
  bool restore(Vec3& c, int& work) const noexcept;
  // The same, and finds the frame at the new c.
  bool restore_to_frame(Vec3& c, ContactFrame& frame, int& work) const noexcept;
  // Keeps a path on the active contacts. Pre: at most two.
  void guide(CentrePath& path) const noexcept;

  // Whether another contact, an active one, is on the same edge or vertex as contact i.
  bool is_held_twice(int i) const noexcept;
  // False: c is off one of its contacts; an equation without a solution has put it there, perhaps behind a face.
  bool touches_all(const Vec3& c) const noexcept;
  // The least squared length of the sum of two active contacts' normals: 2 + 2 cos of their angle; 4: fewer than two are active.
  double find_most_opposite(const Vec3& c) const noexcept;
  // Whether an active contact is on that triangle, or on a face, edge or vertex with the same corners. `corners`: the triangle's.
  bool holds_part_of(const ObjectGeometry::Corners& corners, std::uint32_t triangle) const noexcept;
  // A bit for each corner of the triangle that belongs to an active edge or vertex.
  unsigned guiding_corners(const ContactTriangle& shape) const noexcept;

 private:
  bool restore(Vec3& c, ContactFrame& frame, bool& has_normals, int& work) const noexcept;

  std::array<OffsetContact, kMax> contacts_;
  int active_count_ = 0;
  int count_ = 0;
  Clearance clearance_;
};

}  // namespace hapton
