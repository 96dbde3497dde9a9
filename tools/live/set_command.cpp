#include <fmt/core.h>

#include <cstdint>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/force/force_method.h"
#include "link/hub_client.h"
#include "link/link_key.h"
#include "link/sealed_client.h"
#include "link/settings_request.h"
#include "link/udp_endpoint.h"
#include "scene/material_limits.h"
#include "tools/commands.h"
#include "tools/json_text.h"
#include "tools/live/hub_report.h"

namespace hapton {
namespace {

struct SetOptions {
  std::string hub = "127.0.0.1";
  std::string key_file;
  double rate_hz = 0.0;
  std::string method;
  std::string object;
  std::optional<double> stiffness_n_per_m;
  std::optional<double> damping_ns_per_m;
  std::optional<double> friction;
  std::optional<double> friction_static;
  std::optional<double> friction_dynamic;
  bool report = false;
  bool reset_faults = false;
};

// How many times the hub's faults are read after a reset, 0.1 s apart. A free choice.
constexpr int kFaultReads = 5;
// How long a hub may take to accept this program. A free choice.
constexpr std::int64_t kJoinTimeoutNs = 2 * kNanosecondsPerSecond;

bool wait_until_joined(HubClient& client, const Clock& clock) {
  const std::int64_t end_ns = clock.now_ns() + kJoinTimeoutNs;
  Datagram datagram;
  while (client.state() != JoinState::joined && clock.now_ns() < end_ns) {
    client.receive(datagram, clock.now_ns() + 20 * kNanosecondsPerMillisecond);
  }
  return client.state() == JoinState::joined;
}

MaterialChange make_change(const SetOptions& options) {
  MaterialChange change;
  const auto set_if_given = [&](const std::optional<double>& value, std::uint32_t bit, double& into) {
    if (!value) return;
    change.fields |= bit;
    into = *value;
  };
  set_if_given(options.stiffness_n_per_m, MaterialChange::kStiffness, change.stiffness_n_per_m);
  set_if_given(options.damping_ns_per_m, MaterialChange::kDamping, change.damping_ns_per_m);
  set_if_given(options.friction ? options.friction : options.friction_static, MaterialChange::kFrictionStatic, change.friction_static);
  set_if_given(options.friction ? options.friction : options.friction_dynamic, MaterialChange::kFrictionDynamic, change.friction_dynamic);
  return change;
}

bool has_settings(const SetOptions& options) {
  return options.rate_hz != 0.0 || !options.method.empty() || options.report || options.reset_faults;
}

Result<SettingsRequest> make_request(const SetOptions& options) {
  const MaterialChange material = make_change(options);
  if (material.fields == 0 && !options.object.empty()) {
    return fail("nothing to set for object '{}'; give --stiffness, --damping or --friction", options.object);
  }
  if (material.fields == 0 && !has_settings(options)) {
    return fail("nothing to set; give --rate, --method, --stiffness, --damping, --friction, --report or --reset-faults");
  }
  if (!options.method.empty() && !is_method_name(options.method) && options.method != "plugin") {
    return fail("method '{}' is not known; choose one of: {}, or plugin, the one that haptics_node was started with", options.method,
                method_names());
  }
  return make_settings_request({.rate_hz = options.rate_hz,
                                .method = options.method,
                                .object = options.object,
                                .material = material,
                                .writes_report = options.report,
                                .resets_faults = options.reset_faults});
}

// Reads the hub's faults, with time for the hub to process the reset. Error: a fault is still latched.
Result<std::string> confirm_reset(const SetOptions& options) {
  const auto reader = HubReader::open(options.hub, options.key_file);
  if (!reader) return tl::unexpected(reader.error());
  std::string fault_text;
  for (int reading = 0; reading < kFaultReads; ++reading) {
    const auto texts = (*reader)->read();
    if (!texts) return tl::unexpected(texts.error());
    const auto report = nlohmann::json::parse(texts->json, nullptr, false);
    const auto notes = report.is_object() ? report.value("notes", nlohmann::json::object()) : nlohmann::json::object();
    const std::string fault = json_text_of(notes, "safety_fault");
    if (fault == "none") return std::string("no fault is latched; forces ramp up");
    if (fault.empty()) return fail("the hub does not report faults; it is another version of Hapton");
    fault_text = json_text_of(notes, "safety_fault_text");
    if (fault_text.empty()) fault_text = fault;
    (*reader)->idle(0.1);
  }
  if (const auto hub = parse_address(options.hub); hub && !is_loopback(*hub)) {
    return fail(
        "the fault remains: {}; fix its cause (docs/safety.md), then reset again on the hub's host, or while the dead man's switch is held",
        fault_text);
  }
  return fail("the fault remains, as its cause persists: {}; fix that (docs/safety.md), then reset again", fault_text);
}

Result<std::string> set(const SetOptions& options, const SettingsRequest& request) {
  const auto hub = parse_address(options.hub);
  if (!hub) return tl::unexpected(hub.error());
  const auto key = find_role_key(options.key_file, *hub, options.reset_faults ? KeyRole::operator_role : KeyRole::tool);
  if (!key) return tl::unexpected(key.error());
  auto endpoint = open_udp_endpoint(any_address_like(*hub));
  if (!endpoint) return tl::unexpected(endpoint.error());
  const SteadyClock clock;
  SealedClient sealed(**endpoint, clock, *key, *hub);
  HubClient client(sealed, clock, NodeRole::tool, *hub);
  if (!wait_until_joined(client, clock)) {
    return fail("no reply from a hub at {}; start io_node there, give another address with --hub, or give the hub's --key",
                to_string(*hub));
  }
  auto text = apply_settings(client, clock, request, to_string(*hub));
  if (!text) return text;
  if (options.report) *text += "; report requested";
  if (!options.reset_faults) return text;
  const auto reset = confirm_reset(options);
  return reset ? Result<std::string>(*text + "; " + *reset) : reset;
}

// The exit code, as for any other invalid command line.
constexpr int kBadSetting = 2;

int run(const SetOptions& options) {
  const auto request = make_request(options);
  const auto text = request ? set(options, *request) : tl::unexpected(request.error());
  if (!text) {
    fmt::print(stderr, "hapton set: {}\n", text.error().what);
    return request ? 1 : kBadSetting;
  }
  fmt::print("{}\n", *text);
  return 0;
}

}  // namespace

void add_set_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<SetOptions>();
  const CommandLine command = app.add_subcommand("set", "Change a running system: rate, method, materials, report, faults");
  command.add_option("--hub", options->hub, "Where io_node is: HOST or HOST:PORT").shows_default();
  command.add_option("--key", options->key_file, kKeyHelp);
  command.add_option("--rate", options->rate_hz, "Servo rate, Hz").between(kMinServoRateHz, kMaxServoRateHz);
  command.add_option("--method", options->method,
                     "Force method, one of: " + method_names() + "; or plugin, the one that haptics_node was started with");
  command.add_option("--object", options->object, "Object whose material changes, by its name in the scene; default: all objects");
  command
      .add_option("--stiffness", options->stiffness_n_per_m,
                  "Stiffness of the material, N/m; fades in. Not for layers: these and other effects change only in the scene file")
      .positive("N/m")
      .between(0.0, kStiffnessLimit.most);
  command.add_option("--damping", options->damping_ns_per_m, "Damping of the material, Ns/m").between(0.0, kDampingLimit.most);
  const auto friction = command.add_option("--friction", options->friction, "Static and dynamic friction coefficient, the same for both")
                            .between(0.0, kFrictionStaticLimit.most);
  command.add_option("--friction-static", options->friction_static, "Static friction coefficient")
      .between(0.0, kFrictionStaticLimit.most)
      .excludes(friction);
  command.add_option("--friction-dynamic", options->friction_dynamic, "Dynamic friction coefficient, at most the static one")
      .between(0.0, kFrictionDynamicLimit.most)
      .excludes(friction);
  command.add_flag("--report", options->report, "Make io_node write report.json and latency.csv now; hapton plot draws them");
  command.add_flag("--reset-faults", options->reset_faults, "Reset the latched fault, once its cause is fixed: the force ramps up again");
  command.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
