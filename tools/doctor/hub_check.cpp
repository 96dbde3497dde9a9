#include "tools/doctor/hub_check.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "tools/doctor/port_owner.h"

namespace hapton::doctor {
namespace {

constexpr double kHotShare = 0.8;  // share of the motors' temperature limit that is worth a warning; a free choice

std::string text_of(const nlohmann::json& notes, const char* key) {
  const auto found = notes.find(key);
  return found != notes.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::string describe_device(const nlohmann::json& notes) {
  std::string text = text_of(notes, "device");
  for (const auto& [key, word] : {std::pair{"device_model", ""}, {"device_serial", "serial "}, {"device_firmware", "firmware "}}) {
    const std::string value = text_of(notes, key);
    if (!value.empty()) text += fmt::format(", {}{}", word, value);
  }
  return text;
}

Finding check_state(const nlohmann::json& notes) {
  const std::string subject = "device of the hub";
  const std::string device = describe_device(notes);
  const std::string state = text_of(notes, "device_state");
  if (state == "away")
    return problem(subject, device + ": unplugged or not responding", "check its cable and power; io_node keeps looking for it");
  if (state == "fault")
    return problem(subject, device + ": it has stopped replying for good", "check its cable and power, then start io_node again");
  if (state == "calibrating" || text_of(notes, "device_calibrated") == "no") {
    return problem(subject, device + ": not calibrated, so it gives no force",
                   "put the stylus into its inkwell (Touch, Omni), hold it in its neutral pose (PHANToM Premium), or move it to all its "
                   "stops; io_node's log says which");
  }
  return good(subject, device + (text_of(notes, "device_calibrated") == "yes" ? ", calibrated" : ""));
}

void add_temperature(const nlohmann::json& notes, Findings& findings) {
  const std::string text = text_of(notes, "motor_temperature");
  if (text.empty()) return;
  const double temperature = std::strtod(text.c_str(), nullptr);
  const std::string observation = fmt::format("at {:.0f} % of their temperature limit", 100.0 * temperature);
  findings.push_back(temperature < kHotShare
                         ? good("motors", observation)
                         : warning("motors", observation, "let it rest for some minutes, or limit the force: io_node --max-force 1"));
}

void add_realtime(const nlohmann::json& notes, Findings& findings) {
  const std::string realtime = text_of(notes, "realtime");
  if (realtime.empty()) return;
  const bool is_denied = realtime.find(": denied (") != realtime.npos || realtime.find(" NO (") != realtime.npos;  // " NO (": older hubs
  if (!is_denied) {
    findings.push_back(good("rights of the hub", "all requested rights were granted"));
  } else {
    findings.push_back(warning("rights of the hub", realtime, "grant them (hapton doctor --only rights), then start io_node again"));
  }
}

}  // namespace

Findings check_hub(const Machine& machine) {
  const std::string address = fmt::format("127.0.0.1:{}", machine.settings().hub_port);
  if (!find_port_owner(machine, Transport::udp, machine.settings().hub_port))
    return {note("hub", fmt::format("none runs at {}; while io_node runs, this shows calibration, firmware and temperature", address))};
  if (!machine.queries().hub) return {note("hub", "not checked")};
  const HubReply reply = machine.queries().hub();
  if (!reply.error.empty())
    return {warning("hub", fmt::format("{}: {}", address, reply.error),
                    "give the key that io_node was started with: hapton doctor --key FILE")};
  const auto report = nlohmann::json::parse(reply.report, nullptr, false);
  if (!report.is_object() || !report.contains("notes"))
    return {problem("hub", fmt::format("{} replies without a report", address), "start io_node and hapton from one build")};
  Findings findings;
  findings.push_back(check_state(report["notes"]));
  add_temperature(report["notes"], findings);
  add_realtime(report["notes"], findings);
  return findings;
}

}  // namespace hapton::doctor
