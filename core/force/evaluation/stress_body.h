#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// A body of `hapton stress`, in metres. RT: no.
struct StressBody {
  std::string name;
  TriangleMesh touched;  // what the method gets; may have needles, duplicates, cracks, flipped faces
  TriangleMesh solid;    // the same shape, clean and closed, to tell inside from outside. Empty: not closed, so inside tests do not apply
  bool room = false;     // the free space is the inside, and convex: the proxy is a projection onto a convex set and never jumps
  double probe_share = 0.0;  // radius of the probe as a share of the longest side
};

// The names of all generated bodies; longest side about 0.1 m, centred at the origin.
std::span<const std::string_view> stress_body_names();

// The generated body of that name, or a body without triangles if the list does not have the name.
StressBody make_stress_body(std::string_view name);

// A body from another mesh. If it is closed, `solid` is the same mesh; otherwise `solid` is empty.
StressBody make_stress_body(std::string name, TriangleMesh mesh);

// The body scaled about the origin, then moved by move_m.
StressBody placed(StressBody body, double scale, const Vec3& move_m);

}  // namespace hapton
