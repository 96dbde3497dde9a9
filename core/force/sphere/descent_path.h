#pragma once

#include "core/force/sphere/local_minimum.h"

namespace hapton {

// A piece of the steepest descent towards a device that is held, of a centre that stays on its active contacts, one or two: straight over a
// face, along a helix around an edge or a vertex, along the curve where two contacts meet. It turns by at most LocalMinimum::kTurn, and
// ends nearer to the device; on a single contact each part of it leads nearer. A view: contacts, centre and `work`, which is raised by the
// units of work (step_work.h), outlive it.
//
// Frame and units: TouchGeometry's local ones. RT: yes.
class DescentPath {
 public:
  DescentPath(const ContactSet& contacts, const Vec3& centre, int& work)
      : contacts_(contacts), minimum_(contacts), centre_(centre), work_(work) {}

  // `is_unstable`: a minimum along a curve has vanished here; the centre goes along `hint` or against it, whichever leads nearer. `hint`
  // also decides the side on which the centre leaves a place straight above an edge or a vertex. False: no way leads nearer.
  bool make(const Vec3& device, const Vec3& hint, bool is_unstable, CentrePath& path) const noexcept;
  // Between two faces whose normals are nearly opposite, a centre off by no more than the slop may be far from the line where both are at
  // the offset: makes a straight path to that line. False: the contacts are not two such faces, or the centre is close to the line.
  bool return_to_crease(CentrePath& path) const noexcept;

 private:
  CentrePath roll(const OffsetContact& contact, const Vec3& device, const Vec3& hint) const noexcept;
  bool descend_along_curve(const Vec3& device, const Vec3& hint, bool is_unstable, CentrePath& path) const noexcept;
  bool make_curve_piece(const Vec3& direction, double length, const Vec3& device, bool is_unstable, CentrePath& path) const noexcept;

  const ContactSet& contacts_;
  LocalMinimum minimum_;
  const Vec3& centre_;
  int& work_;
};

}  // namespace hapton
