#pragma once

#include <algorithm>
#include <cstdint>

namespace hapton {

// When an effect acts: always, or while a button of the stylus is held down. Its force is multiplied by a gain that rises linearly from 0
// to 1 within kRampS of the press, and falls as fast from the release on, so a press causes no force discontinuity. Units: s. RT: yes.
//
// Passivity: a dissipative effect stays dissipative. Any other effect becomes active, because it can be switched on where its potential is
// high. Between a press and the end of the fade it gives at most its bound times the length of the hand's path.
struct EffectSwitch {
  // People do not perceive 20 ms as a delay, and a step of 3 N becomes 0.15 N a millisecond (decision 141).
  static constexpr double kRampS = 0.02;
  // The most time that one sample counts for, so that after a late sample the force does not jump by all that the gain missed. At less than
  // 500 Hz the ramp takes longer.
  static constexpr double kMaxStepS = 2e-3;

  // What is kept between two samples. A button that is down at the first sample was not pressed.
  struct State {
    bool was_down = true;
    bool is_on = false;
    double gain = 0.0;
    double last_s = 0.0;   // time of the last sample
    double began_s = 0.0;  // time of the last press
  };

  std::uint32_t button = 0;  // a bit, the lowest for the first button; 0: always on

  // Updates the gain for the next sample. True: the button was pressed since the sample before.
  bool update(std::uint32_t buttons, double time_s, State& state) const noexcept {
    if (button == 0) {
      state.gain = 1.0;
      return false;
    }
    const double passed = std::min(time_s - state.last_s, kMaxStepS) / kRampS;
    state.gain = std::clamp(state.gain + (state.is_on ? passed : -passed), 0.0, 1.0);
    state.last_s = time_s;
    const bool is_down = (buttons & button) != 0;
    const bool is_pressed = is_down && !state.was_down;
    state.was_down = is_down;
    state.is_on = is_down && (state.is_on || is_pressed);
    if (is_pressed) state.began_s = time_s;
    return is_pressed;
  }
};

}  // namespace hapton
