#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>

#include "core/base/result.h"
#include "core/force/force_method.h"
#include "link/hub_client.h"
#include "link/link_key.h"
#include "link/random_id.h"
#include "link/sealed_client.h"
#include "link/udp_endpoint.h"
#include "scene/material_limits.h"
#include "tools/commands.h"
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

// What the haptics node sends, as the hub passes it on to tools.
struct Heard {
  std::optional<HapticsSetup> setup;
  std::optional<MaterialState> materials;
};

constexpr int kResetLooks = 5;
constexpr std::int64_t kReplyPatienceNs = 2 * kNanosecondsPerSecond;
constexpr std::int64_t kSetupPatienceNs = 3 * kNanosecondsPerSecond;   // a haptics node sends its setup once a second
constexpr std::int64_t kBuildPatienceNs = 60 * kNanosecondsPerSecond;  // millions of triangles take some seconds
constexpr std::int64_t kTunePatienceNs = 5 * kNanosecondsPerSecond;
constexpr std::int64_t kRepeatSettingNs = kNanosecondsPerSecond / 2;

// Receives from the hub until the condition holds or the time is over, and keeps what the haptics node sends.
template <class Condition>
bool wait_until(HubClient& client, const Clock& clock, Heard& heard, std::int64_t patience_ns, Condition&& holds) {
  const std::int64_t end_ns = clock.now_ns() + patience_ns;
  Datagram datagram;
  while (!holds()) {
    const std::int64_t now_ns = clock.now_ns();
    if (now_ns >= end_ns) {
      return false;
    }
    if (!client.receive(datagram, now_ns + 20 * kNanosecondsPerMillisecond)) continue;
    if (const auto* setup = std::get_if<HapticsSetup>(&datagram.message)) heard.setup = *setup;
    if (const auto* materials = std::get_if<MaterialState>(&datagram.message)) heard.materials = *materials;
  }
  return true;
}

MaterialChange make_change(const SetOptions& options) {
  MaterialChange change;
  const auto give = [&](const std::optional<double>& value, std::uint32_t bit, double& into) {
    if (!value) return;
    change.given |= bit;
    into = *value;
  };
  give(options.stiffness_n_per_m, MaterialChange::kStiffness, change.stiffness_n_per_m);
  give(options.damping_ns_per_m, MaterialChange::kDamping, change.damping_ns_per_m);
  give(options.friction ? options.friction : options.friction_static, MaterialChange::kFrictionStatic, change.friction_static);
  give(options.friction ? options.friction : options.friction_dynamic, MaterialChange::kFrictionDynamic, change.friction_dynamic);
  return change;
}

// None where no material is to be changed.
Result<std::optional<MaterialRequest>> make_material_request(const SetOptions& options) {
  MaterialRequest request;
  request.change = make_change(options);
  if (request.change.given == 0) {
    if (options.object.empty()) return std::nullopt;
    return fail("nothing to set for object '{}'; give --stiffness, --damping or --friction", options.object);
  }
  if (options.object.size() >= request.object.size()) {
    return fail("the name of an object has at most {} bytes, not {}", request.object.size() - 1, options.object.size());
  }
  std::copy(options.object.begin(), options.object.end(), request.object.begin());
  request.request = static_cast<std::uint32_t>(make_random_id()) | 1U;
  return request;
}

bool has_settings(const SetOptions& options) {
  return options.rate_hz != 0.0 || !options.method.empty() || options.report || options.reset_faults;
}

Result<Settings> make_settings(const SetOptions& options, bool has_material) {
  if (!has_settings(options) && !has_material) {
    return fail("nothing to set; give --rate, --method, --stiffness, --damping, --friction, --report or --reset-faults");
  }
  Settings settings;
  settings.servo_rate_hz = options.rate_hz;
  settings.report_now = options.report;
  settings.reset_faults = options.reset_faults;
  if (!options.method.empty() &&
      (options.method.size() >= settings.method.size() || !(is_method_name(options.method) || options.method == "plugin"))) {
    return fail("method '{}' is not known; choose one of: {}, or plugin, the one that haptics_node was started with", options.method,
                method_names());
  }
  std::copy(options.method.begin(), options.method.end(), settings.method.begin());
  if (!options.method.empty()) settings.method_request = static_cast<std::uint32_t>(make_random_id()) | 1U;
  return settings;
}

// Sends the request twice a second until the reply comes, because a datagram may be lost.
template <class Request, class Condition>
bool repeat_until(HubClient& client, const Clock& clock, Heard& heard, std::int64_t patience_ns, const Request& request,
                  Condition&& is_answered) {
  std::int64_t next_request_ns = clock.now_ns() + kRepeatSettingNs;
  return wait_until(client, clock, heard, patience_ns, [&] {
    if (is_answered()) return true;
    if (clock.now_ns() >= next_request_ns) {
      client.send(request);
      next_request_ns += kRepeatSettingNs;
    }
    return false;
  });
}

// The haptics node's reply to the method request.
Result<std::string> confirm_method(HubClient& client, const Clock& clock, const SetOptions& options, std::uint32_t request_id,
                                   Heard& heard) {
  if (!wait_until(client, clock, heard, kSetupPatienceNs, [&] { return heard.setup.has_value(); })) {
    return fail("no haptics node has joined the hub, so no method is in use; start haptics_node");
  }
  Settings again;
  std::copy(options.method.begin(), options.method.end(), again.method.begin());
  again.method_request = request_id;
  if (!repeat_until(client, clock, heard, kBuildPatienceNs, again, [&] { return heard.setup->method_request == request_id; })) {
    return fail(
        "the haptics node does not confirm method {}: it is still building it, another method was requested since, or it is another "
        "build",
        options.method);
  }
  if (heard.setup->rejection[0] != '\0')
    return fail("the haptics node rejected it: {}; the current method stays in use", heard.setup->rejection.data());
  return fmt::format("method {} in use", options.method);
}

Result<std::string> confirm_material(HubClient& client, const Clock& clock, const MaterialRequest& request, Heard& heard) {
  if (!wait_until(client, clock, heard, kSetupPatienceNs, [&] { return heard.setup.has_value(); })) {
    return fail("no haptics node has joined the hub, so nothing can be touched; start haptics_node");
  }
  const auto is_answered = [&] { return heard.materials && heard.materials->request == request.request; };
  if (!repeat_until(client, clock, heard, kTunePatienceNs, request, is_answered)) {
    return fail("the haptics node does not confirm the material: another change was requested since, or it is another build");
  }
  if (heard.materials->rejection[0] != '\0') {
    return fail("the haptics node rejected it: {}; no material is changed", heard.materials->rejection.data());
  }
  return request.object[0] == '\0' ? std::string("material of all objects in use")
                                   : fmt::format("material of '{}' in use", request.object.data());
}

// The hub's faults, after it has had time to process the request.
Result<std::string> confirm_reset(const SetOptions& options) {
  const auto reader = HubReader::open(options.hub, options.key_file);
  if (!reader) return tl::unexpected(reader.error());
  std::string what;
  for (int look = 0; look < kResetLooks; ++look) {
    const auto texts = (*reader)->read();
    if (!texts) return tl::unexpected(texts.error());
    const auto report = nlohmann::json::parse(texts->json, nullptr, false);
    const auto notes = report.is_object() ? report.value("notes", nlohmann::json::object()) : nlohmann::json::object();
    const std::string fault = notes.value("safety_fault", "");
    if (fault == "none") return std::string("no fault is latched; forces ramp up");
    if (fault.empty()) return fail("the hub does not report faults; it is another build");
    what = notes.value("safety_fault_text", fault);
    (*reader)->idle(0.1);
  }
  if (const auto hub = parse_address(options.hub); hub && !is_loopback(*hub)) {
    return fail(
        "the fault remains: {}; fix its cause (docs/safety.md), then reset again on the hub's host, or while the dead man's switch is held",
        what);
  }
  return fail("the fault remains, as its cause persists: {}; fix that (docs/safety.md), then reset again", what);
}

Result<std::string> set(const SetOptions& options) {
  const auto material = make_material_request(options);
  if (!material) {
    return tl::unexpected(material.error());
  }
  const auto settings = make_settings(options, material->has_value());
  if (!settings) {
    return tl::unexpected(settings.error());
  }
  const auto hub = parse_address(options.hub);
  if (!hub) {
    return tl::unexpected(hub.error());
  }
  const auto key = find_role_key(options.key_file, *hub, options.reset_faults ? KeyRole::operator_role : KeyRole::tool);
  if (!key) {
    return tl::unexpected(key.error());
  }
  auto endpoint = open_udp_endpoint(any_address_like(*hub));
  if (!endpoint) {
    return tl::unexpected(endpoint.error());
  }
  const SteadyClock clock;
  SealedClient sealed(**endpoint, clock, *key, *hub);
  HubClient client(sealed, clock, NodeRole::tool, *hub);
  Heard heard;
  if (!wait_until(client, clock, heard, kReplyPatienceNs, [&] { return client.state() == JoinState::joined; })) {
    return fail("no reply from a hub at {}; start io_node there, give another address with --hub, or give the hub's --key",
                to_string(*hub));
  }
  const bool is_sent = (!has_settings(options) || client.send(*settings)) && (!*material || client.send(**material));
  if (!is_sent) {
    return fail("the settings could not be sent to {}", to_string(*hub));
  }
  const auto rate_holds = [&] {
    return options.rate_hz == 0.0 || std::abs(client.servo_rate_hz() - options.rate_hz) <= 1e-3 * options.rate_hz;
  };
  if (!wait_until(client, clock, heard, kReplyPatienceNs, rate_holds)) {
    return fail("the hub at {} stays at {} Hz; choose {} to {} Hz", to_string(*hub), client.servo_rate_hz(), kMinServoRateHz,
                kMaxServoRateHz);
  }
  std::string text = fmt::format("hub {}: servo rate {} Hz", to_string(*hub), client.servo_rate_hz());
  if (!options.method.empty()) {
    const auto method = confirm_method(client, clock, options, settings->method_request, heard);
    if (!method) return method;
    text += "; " + *method;
  }
  if (*material) {
    const auto tuned = confirm_material(client, clock, **material, heard);
    if (!tuned) return tuned;
    text += "; " + *tuned;
  }
  if (options.report) text += "; report requested";
  if (!options.reset_faults) return text;
  const auto reset = confirm_reset(options);
  return reset ? Result<std::string>(text + "; " + *reset) : reset;
}

int run(const SetOptions& options) {
  const auto text = set(options);
  if (!text) {
    fmt::print(stderr, "hapton set: {}\n", text.error().what);
    return 1;
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
  command.add_option("--friction-static", options->friction_static, "Coulomb").between(0.0, kFrictionStaticLimit.most).excludes(friction);
  command.add_option("--friction-dynamic", options->friction_dynamic, "Coulomb, at most the static one")
      .between(0.0, kFrictionDynamicLimit.most)
      .excludes(friction);
  command.add_flag("--report", options->report, "Make io_node write report.json and latency.csv now; hapton plot draws them");
  command.add_flag("--reset-faults", options->reset_faults, "Reset the latched fault, once its cause is fixed: the force ramps up again");
  command.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
