#include <fmt/core.h>

#include <cstdio>
#include <memory>

#include "link/link_key.h"
#include "link/messages.h"
#include "runtime/realtime.h"
#include "tools/commands.h"
#include "tools/soak/soak_run.h"

namespace hapton {
namespace {

constexpr double kFewestSamples = 10.0;  // a trend cannot be found from fewer observations; a free choice
constexpr double kSecondsAnHour = 3600.0;

int run(const SoakOptions& options) {
  if (options.seconds < kFewestSamples * sample_interval_s(options)) {
    fmt::print(stderr,
               "hapton soak: {:g} s are too few for {:g} observations, one every {:g} s; give more --seconds or a smaller --every\n",
               options.seconds, kFewestSamples, sample_interval_s(options));
    return 2;
  }
  const auto ended = run_soak(options);
  if (!ended) {
    fmt::print(stderr, "hapton soak: {}\n", ended.error().what);
    return 1;
  }
  fmt::print("{}", ended->text);
  return ended->is_flat ? 0 : 1;
}

}  // namespace

void add_soak_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<SoakOptions>();
  options->cpu = find_shared_cpu();
  const CommandLine command =
      app.add_subcommand("soak", "Run the nodes for hours and check that memory, descriptors, forces and clock stay flat");
  const CommandOption seconds = command.add_option("--seconds", options->seconds, "Duration, s").between(5.0, 1e7).shows_default();
  command
      .add_number(
          "--hours", [options](double hours) { options->seconds = kSecondsAnHour * hours; }, "Duration, hours")
      .between(0.01, 2000.0)
      .excludes(seconds);
  command.add_option("--every", options->every_s, "Seconds between observations; 0: a 120th of the time, at least 2 s")
      .between(0.0, 3600.0)
      .shows_default();
  command.add_option("--rate", options->rate_hz, "Servo rate, Hz").between(kMinServoRateHz, kMaxServoRateHz).shows_default();
  command.add_flag("--vision", options->vision, "Include a vision node");
  command.add_option("--scene", options->scene, "Scene to touch").shows_default();
  command.add_option("--key", options->key_file, kKeyHelp);
  command.add_option("--out", options->out, "Folder for soak.csv, soak.json, soak.png and the nodes' logs and reports")
      .folder_to_write()
      .shows_default();
  command.add_option("--rt", options->realtime, "Real-time scheduling of the nodes: try, require or off")
      .one_of({"try", "require", "off"})
      .shows_default();
  command.add_option("--cpu", options->cpu, "Pin io_node and haptics_node to this CPU; -1: any; default: the last one")
      .between(-1, 1023)
      .shows_default();
  command.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
