#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/tool/least_motion.h"

namespace hapton {

// Which of many contacts a local set keeps. The nearest alone may all be on one side of a face: the tool would tilt over its other side.
// For each goal, the bound that the motion within the chosen ones violates most is added, until none is violated: then the motion is that
// within all bounds (cutting planes, Kelley 1960). It ends early after kMostCuts, where all places are taken, and where the chosen bounds
// contradict each other. The places that are left go to the bounds with the least room.
//
// Coordinates: as of find_least_motion. Returns how many are chosen, as many as fit; their numbers are in `chosen`, each once. RT: yes; at
// most kMostCuts passes over all bounds for each goal.
inline constexpr int kMostCuts = 8;
std::size_t choose_contacts(std::span<const MotionBound> bounds, std::span<const Vec6> goals, double tolerance,
                            std::span<std::uint32_t> chosen) noexcept;

}  // namespace hapton
