// Shows: a program that deforms an object of the scene while it is touched: 30 shapes a second of a swelling that travels along its top.
// Run:   io_node; haptics_node --scene scenes/swelling.toml; deform_object [SECONDS [HUB [KEYFILE [MESHFILE]]]]
//        MESHFILE: the mesh of the object; default: meshes/supple_block.obj, relative to the current folder
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "link/hub_connection.h"
#include "link/shape_outbox.h"
#include "scene/touch_mesh.h"

using namespace hapton;

constexpr double kShapeS = 1.0 / 30.0;

int main(int argc, char** argv) {
  // Loaded with the unit and sealing of the scene file, so that the vertices are the same, in the same order.
  const auto mesh = load_touch_mesh(argc > 4 ? argv[4] : "meshes/supple_block.obj", Unit::mm, CrackSealing::off);
  if (!mesh) return std::fprintf(stderr, "%s\n", mesh.error().what.c_str()), 1;
  const std::vector<Vec3>& rest = mesh->mesh.vertices;  // m
  const double seconds = argc > 1 ? std::atof(argv[1]) : 10.0;
  auto hub = HubConnection::open(NodeRole::tool, {.hub = argc > 2 ? argv[2] : "127.0.0.1", .key_file = argc > 3 ? argv[3] : ""});
  if (!hub) return std::fprintf(stderr, "%s\n", hub.error().what.c_str()), 1;
  if (const auto joined = (*hub)->wait_until_joined(5.0); !joined) return std::fprintf(stderr, "%s\n", joined.error().what.c_str()), 1;

  HubClient& client = (*hub)->client();
  const Clock& clock = (*hub)->clock();
  ShapeOutbox outbox;
  std::vector<ShapePart::Displacement> shape(rest.size());
  Datagram datagram;
  int given_count = 0, rejected_count = 0;
  const std::int64_t begin_ns = clock.now_ns();
  for (double t = 0.0; t < seconds; t = 1e-9 * static_cast<double>(clock.now_ns() - begin_ns)) {
    const double swelling_x_m = 0.045 * std::sin(1.5 * t);
    for (std::size_t v = 0; v < rest.size(); ++v) {
      const double r = std::fmin(1.0, std::hypot(rest[v].x() - swelling_x_m, rest[v].y()) / 0.03);
      shape[v] = {0.0F, 0.0F, static_cast<float>(0.012 * std::pow(1.0 - r * r, 2) * std::fmax(0.0, rest[v].z() / 0.02))};
    }
    if (const auto number = outbox.give("block", shape, kShapeS); !number)
      return std::fprintf(stderr, "%s\n", number.error().what.c_str()), 1;
    ++given_count;
    const std::int64_t next_ns = clock.now_ns() + static_cast<std::int64_t>(1e9 * kShapeS);
    while (clock.now_ns() < next_ns) {
      outbox.send(client, clock.now_ns());
      if (!client.receive(datagram, clock.now_ns() + ShapeOutbox::kEveryNs)) continue;
      outbox.take(datagram.message);
      if (const auto* reply = std::get_if<ShapeReply>(&datagram.message); reply != nullptr && reply->rejection[0] != '\0') {
        if (++rejected_count == 1) std::fprintf(stderr, "%s\n", reply->rejection.data());
      }
    }
  }
  // deform_object() sends the last shape, the surface at rest, until haptics_node has confirmed it.
  const auto takes_s = deform_object(client, clock, outbox, "block", std::vector<ShapePart::Displacement>(rest.size()), 0.5);
  if (!takes_s) return std::fprintf(stderr, "%s\n", takes_s.error().what.c_str()), 1;
  std::printf("%d shapes given, %d rejected; back at rest in %.2f s\n", given_count, rejected_count, *takes_s);
  return rejected_count > 0;
}
