#pragma once

#include "core/math/commanded_motion.h"
#include "link/messages.h"

namespace hapton {

// Converts the move of a message for all that compute with it: haptics, pictures and replays get the same bits. RT: yes.
inline CommandedMove to_command(const ObjectMove& move) noexcept {
  return {.serial = move.serial,
          .from = {.time_s = 1e-9 * static_cast<double>(move.start_ns), .p_S = move.from_p_m, .turn = move.from_q},
          .to = {.time_s = 1e-9 * static_cast<double>(move.end_ns), .p_S = move.to_p_m, .turn = move.to_q}};
}

}  // namespace hapton
