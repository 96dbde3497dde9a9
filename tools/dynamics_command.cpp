#include <fmt/core.h>

#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <variant>

#include "link/hub_connection.h"
#include "link/random_id.h"
#include "runtime/stop_signal.h"
#include "scene/find_scene.h"
#include "tools/commands.h"
#include "tools/dynamics/dynamics_driver.h"

namespace hapton {
namespace {

using dynamics::DynamicsDriver;

struct DynamicsOptions {
  std::string scene;
  double gravity = 9.81;
  double friction = 0.4;
  double seconds = 0.0;
  HubConnection::Settings hub;
};

constexpr double kJoinTimeoutS = 5.0;  // how long to wait for the hub; a free choice
// The longest wait for a datagram. A longer wait would delay a request: the driver has one due every 5 ms.
constexpr std::int64_t kMaxWaitNs = 1 * kNanosecondsPerMillisecond;
constexpr std::int64_t kWarnEveryNs = kNanosecondsPerSecond;
// Less is not reported: it occurs when nodes start, or when a machine stands still for a moment.
constexpr double kMinReportedLeftOutS = 0.5;

void print_and_flush(const std::string& line) {
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

std::string describe(const Scene& scene, const DynamicsDriver& driver) {
  std::string bodies;
  for (const int object : driver.world().bodies()) {
    const SceneObject& body = scene.objects[static_cast<std::size_t>(object)];
    bodies += fmt::format("{}{} ({:g} kg)", bodies.empty() ? "" : ", ", body.name, body.mass_kg);
  }
  return fmt::format("bodies: {}; obstacles: {}", bodies, scene.objects.size() - driver.world().bodies().size());
}

// Error: the haptics node has another scene.
Result<void> pass_to_driver(DynamicsDriver& driver, const Scene& scene, HubClient& client, const Datagram& datagram) {
  const bool is_overtaken = client.last_arrival() == Arrival::reordered;
  if (const auto* probe = std::get_if<ProbeState>(&datagram.message)) {
    if (is_overtaken) return {};
    // This comes first, because it requests the next state.
    client.send(FrameAck{.echo_sample = probe->sample, .echo_sample_time_ns = probe->sample_time_ns, .every_sample = true});
    driver.take(*probe);
  } else if (const auto* setup = std::get_if<HapticsSetup>(&datagram.message)) {
    if (!is_overtaken) driver.take(*setup);
  } else if (const auto* materials = std::get_if<MaterialState>(&datagram.message)) {
    if (!is_overtaken) driver.take(*materials);
  } else if (const auto* move = std::get_if<ObjectMove>(&datagram.message)) {
    driver.take(*move, client.last_arrival());
  } else if (const auto* reply = std::get_if<MoveReply>(&datagram.message)) {
    driver.take(*reply);
  } else if (const auto* pose = std::get_if<ObjectPose>(&datagram.message)) {
    driver.take(*pose, client.last_arrival());
  } else if (const auto* facts = std::get_if<SceneFacts>(&datagram.message)) {
    if (facts->given_hash != scene.given_hash) return fail("haptics_node has another scene; give its scene file by --scene");
  }
  return {};
}

void warn(const Scene& scene, DynamicsDriver& driver) {
  if (const std::string why = driver.take_rejection(); !why.empty()) print_and_flush("a body does not move: " + why);
  for (const int fallen : driver.take_fallen()) {
    print_and_flush(
        fmt::format("{} fell out of the scene, and is back where it began", scene.objects[static_cast<std::size_t>(fallen)].name));
  }
}

Result<void> run_dynamics(const DynamicsOptions& options) {
  const auto scene = load_scene(find_scene(options.scene));
  if (!scene) return tl::unexpected(scene.error());
  auto driver = DynamicsDriver::make(*scene, {.gravity_W = {0.0, -options.gravity, 0.0},
                                              .friction = options.friction,
                                              .first_request = static_cast<std::uint32_t>(make_random_id())});
  if (!driver) return tl::unexpected(driver.error());
  const auto connection = HubConnection::open(NodeRole::vision, options.hub);
  if (!connection) return tl::unexpected(connection.error());
  if (const auto joined = (*connection)->wait_until_joined(kJoinTimeoutS); !joined) return tl::unexpected(joined.error());
  print_and_flush(describe(*scene, *driver));

  HubClient& client = (*connection)->client();
  const Clock& clock = (*connection)->clock();
  const StopSignal stop;
  const std::int64_t end_ns =
      options.seconds > 0.0 ? clock.now_ns() + static_cast<std::int64_t>(1e9 * options.seconds) : std::numeric_limits<std::int64_t>::max();
  std::int64_t next_warning_ns = 0;
  Datagram datagram;
  while (clock.now_ns() < end_ns && !stop.stop_requested()) {
    if (client.receive(datagram, clock.now_ns() + kMaxWaitNs)) {
      if (const auto taken = pass_to_driver(*driver, *scene, client, datagram); !taken) return tl::unexpected(taken.error());
    }
    if (const auto request = driver->next_request(clock.now_ns())) client.send(*request);
    if (clock.now_ns() < next_warning_ns) continue;
    next_warning_ns = clock.now_ns() + kWarnEveryNs;
    warn(*scene, *driver);
  }
  const DynamicsDriver::Counts& counts = driver->counts();
  for (const int object : driver->world().bodies()) {
    const SceneObject& body = scene->objects[static_cast<std::size_t>(object)];
    const double away_m = (driver->world().place(object).p_S - body.commanded->pivot()).norm();
    print_and_flush(fmt::format("{} is {:.1f} mm from where it began", body.name, 1e3 * away_m));
  }
  print_and_flush(fmt::format("{} steps, {} moves requested, pressed in {} samples, delay {:.1f} ms", counts.steps, counts.requests,
                              counts.pushes, 1e3 * driver->delay_s()));
  const double left_out_s = 1e-9 * static_cast<double>(counts.left_out_ns);
  if (left_out_s > kMinReportedLeftOutS)
    print_and_flush(fmt::format("slow: bodies stood still for {:.1f} s, as states came late or the machine was busy", left_out_s));
  if (counts.steps > 0) return {};
  return fail("no scene time has passed: does haptics_node run with this scene, and is the device connected? `hapton top` shows");
}

int run(const DynamicsOptions& options) {
  const auto done = run_dynamics(options);
  if (!done) fmt::print(stderr, "hapton dynamics: {}\n", done.error().what);
  return done ? 0 : 1;
}

}  // namespace

void add_dynamics_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<DynamicsOptions>();
  const CommandLine command = app.add_subcommand("dynamics", "Let the stylus push objects that have a mass (rigid bodies, by Bullet)");
  command.add_option("--scene", options->scene, "Scene file of the running nodes; its bodies have moved_by = \"program\" and mass_kg")
      .required();
  command.add_option("--gravity", options->gravity, "m/s^2, downwards (-y of W); 0: none").between(0.0, 100.0).shows_default();
  command.add_option("--friction", options->friction, "Coulomb coefficient between any two objects").between(0.0, 2.0).shows_default();
  command.add_option("--seconds", options->seconds, "End after this long, s; 0: when stopped (Ctrl-C)").between(0.0, 1e9).shows_default();
  command.add_option("--hub", options->hub.hub, "Where io_node is: HOST or HOST:PORT").shows_default();
  command.add_option("--key", options->hub.key_file, kKeyHelp);
  command.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
