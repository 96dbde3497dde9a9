#pragma once

#include <cstdint>

namespace hapton {

// The bit of a stylus button in DeviceState::buttons and similar masks. Buttons count from 1 to 32; for any other number 0. RT: yes.
constexpr std::uint32_t button_bit(int button) noexcept { return button >= 1 && button <= 32 ? std::uint32_t{1} << (button - 1) : 0U; }

}  // namespace hapton
