#pragma once

#include <string_view>

#include "core/force/stiffest.h"

namespace hapton {

// The keys of a scene file that give a surface or an effect its stiffness, as part of a message: "its stiffness_n_per_m". RT: yes.
std::string_view scene_key_of(StiffCause cause) noexcept;

}  // namespace hapton
