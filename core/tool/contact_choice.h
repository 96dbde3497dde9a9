#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/tool/local_contacts.h"

namespace hapton {

// Which of many contacts a local set keeps. The nearest alone may all be on one side of a face: the tool would tilt over its other side.
// For each goal, the bound that the motion within the chosen ones violates most is added, until none is violated: then the motion is that
// within all bounds (cutting planes, Kelley 1960). The motion is that of LocalContacts::solve: in the metric with the curvature of the
// contacts, or in the plain one if nothing is active there; and once the chosen bounds contradict each other, so do all, and all of them
// are lowered to where zero motion meets them. A goal ends early after kMaxCuts, the first one only where all places are taken. The
// places that are left go to the bounds with the least room.
//
// bounds: of shift and turn. goals: where the device is, as shift and turn; the first one is what is most likely. metric: a local set of
// which the contacts are not read. Returns how many are chosen, as many as fit; their numbers are in `chosen`, each once. RT: yes; for
// each goal at most 2 kMaxCuts + 2 passes over all bounds, for the first one 3 LocalContacts::kMax, and twice as many if bounds
// contradict each other.
inline constexpr int kMaxCuts = 8;  // in each metric
std::size_t choose_contacts(std::span<const MotionBound> bounds, std::span<const Vec6> goals, const LocalContacts& metric,
                            std::span<std::uint32_t> chosen) noexcept;

}  // namespace hapton
