#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/standins/board.h"

namespace hapton::standin {

// A stylus of 50 g: a spring and a damper connect it to the hand's position, and the motors push it. Device axes, SI units.
class PointMass {
 public:
  // Places the stylus at the hand's position, at rest.
  void place(Board& board) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      board.position_m[axis] = position_m_[axis] = board.hand_m[axis];
      velocity_m_per_s_[axis] = 0.0;
    }
  }

  void step(Board& board, const std::array<double, 3>& force_n, double step_s) {
    constexpr double kMassKg = 0.05, kSpringNPerM = 200.0, kDamperNsPerM = 4.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double hand_m = board.hand_m[axis];
      if (board.follows_hand == 0) {
        position_m_[axis] = hand_m;
        velocity_m_per_s_[axis] = 0.0;
      } else {
        const double pull_n = kSpringNPerM * (hand_m - position_m_[axis]) - kDamperNsPerM * velocity_m_per_s_[axis];
        velocity_m_per_s_[axis] += step_s * (pull_n + force_n[axis]) / kMassKg;
        position_m_[axis] = std::clamp(position_m_[axis] + step_s * velocity_m_per_s_[axis], -0.2, 0.2);
      }
      board.position_m[axis] = position_m_[axis];
    }
  }

  // Records the motors' force for the test.
  static void note_force(Board& board, const std::array<double, 3>& force, const std::array<double, 3>& torque, bool is_calibrated) {
    double norm2 = 0.0, step2 = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double step = force[axis] - board.force[axis];
      norm2 += force[axis] * force[axis];
      step2 += step * step;
      board.force[axis] = force[axis];
      board.torque[axis] = torque[axis];
    }
    board.largest_force = std::max<double>(board.largest_force, std::sqrt(norm2));
    board.largest_step = std::max<double>(board.largest_step, std::sqrt(step2));
    if (norm2 > 0.0) ++board.pushed_ticks;
    if (norm2 > 0.0 && !is_calibrated) ++board.pushed_unasked;
  }

  const std::array<double, 3>& position_m() const { return position_m_; }

  // Rows of the rotation matrix of the stylus, which is turned about x, then y, then z by Board::turn_rad.
  static std::array<std::array<double, 3>, 3> rotation(const Board& board) {
    const double a = board.turn_rad[0], b = board.turn_rad[1], c = board.turn_rad[2];
    const double ca = std::cos(a), sa = std::sin(a), cb = std::cos(b), sb = std::sin(b), cc = std::cos(c), sc = std::sin(c);
    // Rz(c) Ry(b) Rx(a)
    return {{{cc * cb, cc * sb * sa - sc * ca, cc * sb * ca + sc * sa},
             {sc * cb, sc * sb * sa + cc * ca, sc * sb * ca - cc * sa},
             {-sb, cb * sa, cb * ca}}};
  }

 private:
  std::array<double, 3> position_m_ = {};
  std::array<double, 3> velocity_m_per_s_ = {};
};

}  // namespace hapton::standin
