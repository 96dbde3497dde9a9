// Presses a probe 2 mm into a wall and sends its force through the wire format.
#include <array>
#include <cstdio>
#include <memory>
#include <span>

#include "core/force/touch_step.h"
#include "link/codec.h"
#include "link/endpoint.h"
#include "runtime/clock.h"

int main() {
  using namespace hapton;
  auto wall = std::make_shared<TriangleMesh>();
  wall->vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  wall->triangles = {{0, 1, 2}, {0, 2, 3}};
  auto method = make_method({}, {{{wall, {.stiffness_n_per_m = 1000.0}}}});
  if (!method) return std::fprintf(stderr, "%s\n", method.error().what.c_str()), 1;
  TouchStep touch(std::move(*method));
  touch.reset({.p_WD = {0, 0, 0.01}});
  const TouchOutput output = touch.step({.p_WD = {0.1, 0.2, -0.002}});

  Codec codec;
  const SteadyClock clock;
  std::array<std::byte, kMaxDatagramBytes> bytes;
  ForceCommand command;
  command.force_n = output.force_n;
  const std::size_t size = codec.encode({{1, 2, 3, clock.now_ns()}, command}, bytes);
  Datagram received;
  if (codec.decode(std::span(bytes).first(size), received) != DecodeStatus::ok) return 1;
  const Vec3 force_n = std::get<ForceCommand>(received.message).force_n;
  std::printf("%.6f N\n", force_n.z());
  return force_n.isApprox(Vec3(0, 0, 2)) ? 0 : 1;
}
