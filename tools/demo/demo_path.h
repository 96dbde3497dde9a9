#pragma once

#include <optional>
#include <string>
#include <vector>

#include "runtime/trajectory_csv.h"
#include "scene/scene_file.h"

namespace hapton {

// Paths that the simulated hand (devices/hand_script.h) repeats: where it aims the stylus, W, m, the first row at 0 s. An object in the
// path holds the stylus; the hand pulls in proportion to its distance behind the surface. RT: no.
using DemoPath = std::vector<TrajectoryRow>;

// The foremost point of the scene (greatest z) over this x and y, the scene posed as its file says; none where there is nothing.
std::optional<Vec3> find_front(const Scene& scene, double x_m, double y_m);

// Comes to the scene from the front over (x, y), presses and draws small slow circles for hold_s, leaves. Error: nothing is there.
Result<DemoPath> make_rest_path(const Scene& scene, double x_m, double y_m, double hold_s);

// Presses into the groove and goes straight to and fro along the middle of its bends.
DemoPath make_groove_path();

// Taps at the wall, from in front of it to behind it, farther between two samples of 1 kHz than it is thick; each fourth tap stays behind
// it.
DemoPath make_tap_path();

// Presses and draws arcs over the front of a ball around the origin.
DemoPath make_arc_path(double radius_m);

}  // namespace hapton
