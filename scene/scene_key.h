#pragma once

#include <string_view>

#include "core/force/stiffest.h"

namespace hapton {

// Which keys of a scene file make a surface or an effect as stiff as it is: "its stiffness_n_per_m". RT: yes.
std::string_view scene_key_of(StiffCause cause) noexcept;

}  // namespace hapton
