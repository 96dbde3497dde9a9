#pragma once

#include "closed_loop/device_model.h"
#include "closed_loop/hand_model.h"

namespace hapton {

// The stylus of a device whose motors turn it, about one axis through the device point: an axis as in device_model.h, with the units kg m^2
// for kg, Nm s/rad for Ns/m, Nm for N and rad for m. So all of closed_loop/ applies to it: find_zwidth, for example, gives Nm/rad.

// How stiffly a hand holds a stylus against turning is in no data sheet or study that we know of. Assumed: the hand's mass, damper and
// spring act at this distance from the axis (devices/stylus_turn.h leaves out the mass).
constexpr double kGripLeverM = 0.05;

// A stylus of 40 g and 20 cm without damping or friction (devices/stylus_turn.h), read to 1/512 turn (model_a.h). RT: yes.
DeviceModel turning_axis(double max_torque_nm) noexcept;
HandModel turning_hand(const HandModel& hand) noexcept;

// The largest rotational stiffness that is safe, Nm/rad: half of the limit of stability, as in recommend_stiffness. Pre: rate_hz > 0. RT:
// no.
double recommend_rotational_stiffness(const HandModel& hand, double max_torque_nm, double rate_hz, double delay_s);

}  // namespace hapton
