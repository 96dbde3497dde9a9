#include <fmt/core.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>

#include "link/link_key.h"
#include "runtime/stop_signal.h"
#include "tools/commands.h"
#include "tools/dds/dds_bridge.h"
#include "tools/dds/ros_names.h"

namespace hapton {
namespace {

struct DdsOptions {
  dds::BridgeSettings bridge;
  std::optional<int> domain;
  std::string realtime = "try";
};

Result<dds::BridgeSettings> make_bridge_settings(const DdsOptions& options) {
  dds::BridgeSettings settings = options.bridge;
  settings.realtime = *parse_realtime_mode(options.realtime);
  const auto domain = dds::choose_domain(options.domain, std::getenv("ROS_DOMAIN_ID"));
  if (!domain) return tl::unexpected(domain.error());
  settings.ros.domain = *domain;
  const auto prefix = dds::make_prefix(settings.ros.prefix);
  if (!prefix) return tl::unexpected(prefix.error());
  settings.ros.prefix = *prefix;
  if (const auto frame = dds::check_frame(settings.ros.frame); !frame) return tl::unexpected(frame.error());
  if (settings.ros.interface.empty()) return settings;
  if (const auto interface = dds::check_interface(settings.ros.interface); !interface) return tl::unexpected(interface.error());
  return settings;
}

Result<void> run_dds(const DdsOptions& options) {
  const auto settings = make_bridge_settings(options);
  if (!settings) return tl::unexpected(settings.error());
  const StopSignal stop;
  const auto summary = dds::run_bridge(
      *settings, [&] { return stop.stop_requested(); },
      [](const std::string& line) {
        fmt::print("{}\n", line);
        std::fflush(stdout);
      });
  if (!summary) return tl::unexpected(summary.error());
  fmt::print("{}\n", to_text(*summary));
  if (summary->samples > 0) return {};
  return fail("no sample of the device came; is it connected? `hapton top` shows");
}

int run(const DdsOptions& options) {
  const auto done = run_dds(options);
  if (!done) fmt::print(stderr, "hapton dds: {}\n", done.error().what);
  return done ? 0 : 1;
}

}  // namespace

void add_dds_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<DdsOptions>();
  dds::BridgeSettings& bridge = options->bridge;
  const CommandLine command = app.add_subcommand("dds", "Show the device to ROS 2 and other DDS programs: poses, forces, buttons");
  command.add_option("--hub", bridge.hub.hub, "Where io_node is: HOST or HOST:PORT").shows_default();
  command.add_option("--key", bridge.hub.key_file, kKeyHelp);
  command.add_option("--seconds", bridge.seconds, "End after this long, s; 0: when stopped (Ctrl-C)").between(0.0, 1e9).shows_default();
  command.add_option("--domain", options->domain, "DDS domain, 0 to 232 (default: ROS_DOMAIN_ID, or 0)");
  command.add_option("--interface", bridge.ros.interface,
                     "Network interface, by name or address; auto: as DDS chooses (default: CYCLONEDDS_URI, or programs on this host)");
  command.add_option("--prefix", bridge.ros.prefix, "Prefix of the topics' names").shows_default();
  command.add_option("--frame", bridge.ros.frame, "frame_id of all positions and forces: Hapton's frame W").shows_default();
  command.add_flag("--reliable", bridge.ros.is_reliable, "Publish with reliable QoS, for subscribers that reject best effort");
  command.add_option("--tf-rate", bridge.ros.tf_rate_hz, "Transforms a second on /tf, at most; 0: none")
      .between(0.0, 10'000.0)
      .shows_default();
  command.add_option("--rt", options->realtime, "Real-time scheduling, below that of the nodes: try, require or off")
      .one_of({"try", "require", "off"})
      .shows_default();
  const CommandOption forces =
      command
          .add_option("--accept-forces", bridge.accept_forces_n,
                      "Take forces from PREFIX/servo_cf, in place of haptics_node, up to this magnitude, N (default: none)")
          .between(0.0, 1000.0);
  command
      .add_option("--accept-torques", bridge.accept_torques_nm,
                  "With --accept-forces: torques up to this magnitude, N m, for devices that can exert them; 0: none")
      .between(0.0, 100.0)
      .shows_default()
      .needs(forces);
  command
      .add_option("--haptics-key", bridge.haptics_key_file,
                  "With --accept-forces: key file of a haptics node, if that of --key is a vision node's")
      .needs(forces);
  command.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
