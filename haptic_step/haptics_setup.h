#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "core/force/force_method.h"
#include "link/messages.h"
#include "scene/scene_loading.h"

namespace hapton {

// The setup message that a haptics node with these settings sends to the hub. RT: set-up only.
HapticsSetup make_haptics_setup(const std::filesystem::path& scene, const SceneLoading& loading, std::uint64_t scene_hash,
                                const MethodSettings& method);

// Puts a text into a field of HapticsSetup: what is not printable becomes a question mark, what is too long loses its front (the end of a
// path says more). RT: yes.
void put_text(std::string_view text, HapticsSetup::Text& into) noexcept;

}  // namespace hapton
