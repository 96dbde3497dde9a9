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

  // The distance of a centre in contact, and how exactly it is kept.
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
  // Not active. Replaces a contact with the same triangle. False: there are too many.
  bool add(const OffsetContact& contact) noexcept;
  void remove(int i) noexcept;
  void keep_active() { count_ = active_count_; }
  void activate_all() { active_count_ = count_; }
  // The given ones, all active. At most three.
  void hold_by(std::span<const OffsetContact> contacts) noexcept;
  // That one alone, active.
  void keep_only(int i) noexcept;
  // Makes contact i the last active one. Pre: it is not active, and at most two are.
  void activate(int i) noexcept { std::swap((*this)[active_count_++], (*this)[i]); }
  int deactivate_last() { return --active_count_; }  // returns its number
  // Finds the contacts that hold the centre against the pull and makes them the active ones. Where constraints balance, the device's motion
  // decides. `descent`: the free component of the pull, if any is active. False: there is no solution within rounding.
  bool find_active(const Vec3& c, const Vec3& pull, const Vec3& motion, Vec3& descent) noexcept;
  // Sets the multipliers of the active contacts for a centre at their local minimum for the device.
  void note_multipliers(const Vec3& c, const Vec3& device) noexcept;

  // The frame of the active contacts' normals. False: two are parallel, or three in one plane, within rounding.
  bool find_frame(const Vec3& c, ContactFrame& frame) const noexcept;
  // Projects onto the offset of all active contacts, with Newton's method. False: no position near c is on all of them.
  bool restore(Vec3& c, int& work) const noexcept;
  // The same, and the frame there.
  bool restore_to_frame(Vec3& c, ContactFrame& frame, int& work) const noexcept;
  // Keeps a path on the active contacts. Pre: at most two.
  void guide(CentrePath& path) const noexcept;

  // Whether another contact that is active is on the same edge or corner as contact i, of another triangle.
  bool is_held_twice(int i) const noexcept;
  // A centre that is off its own contacts was put there by an equation that had no solution, perhaps behind a face.
  bool touches_all(const Vec3& c) const noexcept;
  // Of two active contacts, the squared length of the sum of their normals: 2 + 2 cos of the angle between them. The smallest one; 4: none.
  double find_most_opposite(const Vec3& c) const noexcept;
  // Whether an active contact is on that triangle, or on a face, edge or corner that it shares.
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
