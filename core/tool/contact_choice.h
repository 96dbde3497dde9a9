#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/tool/local_contacts.h"

namespace hapton {

// Chooses which of many contacts a LocalContacts keeps. The nearest may all be on one side of a face: the tool would tilt into the other.
// For each goal, finds the motion within the chosen bounds, adds the bound of all that this motion violates most, and repeats until none
// is violated: the motion is then the same as within all bounds (cutting planes, Kelley 1960). The motion is that of LocalContacts::solve:
// in the metric with the curvature of the contacts, or in the plain metric if no bound is active in that one. If the chosen bounds
// contradict each other, all bounds are lowered so that zero motion satisfies them. The search for a goal stops after kMaxCuts bounds; the
// first goal is searched again at the end without this limit. Places that are then left go to the bounds with the least room.
//
// bounds: half-spaces of motions from the proxy (shift, then turn). goals: motions to possible poses of the device, the most likely one
// first. metric: only its inverse roots, stiffness and tolerance are read. Returns the number of chosen bounds, at most chosen.size() and
// LocalContacts::kMax; `chosen` gets their indices, each once. RT: yes; passes over all bounds: at most 2 kMaxCuts + 2 for each goal and
// 3 LocalContacts::kMax for the first one, and twice as many if bounds contradict each other.
inline constexpr int kMaxCuts = 8;  // in each metric
std::size_t choose_contacts(std::span<const MotionBound> bounds, std::span<const Vec6> goals, const LocalContacts& metric,
                            std::span<std::uint32_t> chosen) noexcept;

}  // namespace hapton
