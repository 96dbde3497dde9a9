#include "tools/latency/run_summary.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <vector>

#include "tools/json_number.h"
#include "tools/json_text.h"

namespace hapton {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMinServoRateShare = 0.99;  // share of the requested servo rate; this and the next value are free choices
constexpr double kMaxLateShare = 0.01;       // share of the forces

std::string note(const Json& report, const char* key) {
  const auto notes = report.find("notes");
  return notes != report.end() ? json_text_of(*notes, key) : std::string();
}

std::string hop_text(const Json& report, const char* hop) {
  const auto hops = report.find("hops");
  if (hops == report.end() || !hops->is_object() || !hops->contains(hop)) return {};
  return fmt::format(", round trip {:.0f} us (p50), {:.0f} us (p99)", json_number_of(*hops, hop, "p50_us"),
                     json_number_of(*hops, hop, "p99_us"));
}

std::string touched_text(const Json& report, const std::string& what, double contacts) {
  const double seconds = json_number_of(report, "seconds");
  if (contacts == 0.0) {
    return fmt::format("touched nothing of {} in {:.1f} s: the probe never met a surface; hapton info shows the object's size and place",
                       what, seconds);
  }
  const std::string torque = note(report, "max_torque_written_nm");
  const bool has_torque = torque.find_first_of("123456789") != std::string::npos;
  return fmt::format("touched {} for {:.1f} s: {:.0f} of {:.0f} samples in contact, at most {} N{}", what, seconds, contacts,
                     json_number_of(report, "counters", "samples"), note(report, "max_force_written_n"),
                     has_torque ? fmt::format(" and {} Nm", torque) : "");
}

// The problems, worst first.
std::vector<std::string> find_troubles(const Json& report) {
  std::vector<std::string> troubles;
  if (const std::string reach = note(report, "reach"); !reach.empty()) troubles.push_back(reach + " (check --unit and --no-fit)");
  const auto count = [&](const char* key) { return json_number_of(report, "counters", key); };
  const auto add = [&](const char* key, const char* noun, const char* participle) {
    if (count(key) > 0.0) troubles.push_back(fmt::format("{:.0f} {}{}{}", count(key), noun, count(key) == 1.0 ? "" : "s", participle));
  };
  add("faults_latched", "fault", " latched");
  add("command_timeouts", "command timeout", "");
  add("lost", "force", " lost");
  if (count("late") > kMaxLateShare * count("forces")) troubles.push_back(fmt::format("{:.0f} forces late", count("late")));
  if (count("forces") == 0.0) troubles.push_back("no force came back from haptics_node");
  const double rate = json_number_of(report, "rates_hz", "samples");
  const double requested = json_number_of(report, "rates_hz", "servo_requested");
  if (rate < kMinServoRateShare * requested) troubles.push_back(fmt::format("{:.0f} samples a second of {:.0f}", rate, requested));
  return troubles;
}

}  // namespace

RunSummary summarise_run(const Json& report, const std::string& what) {
  const double contacts = json_number_of(report, "counters", "contact_samples");
  const std::vector<std::string> troubles = find_troubles(report);
  RunSummary summary{
      .has_contact = contacts > 0.0, .has_no_troubles = troubles.empty(), .text = touched_text(report, what, contacts) + "\n"};
  if (summary.has_no_troubles) {
    summary.text += fmt::format("it ran without faults: {:.0f} samples a second, no force lost, {:.0f} late{}\n",
                                json_number_of(report, "rates_hz", "samples"), json_number_of(report, "counters", "late"),
                                hop_text(report, "round_trip"));
  } else {
    summary.text += fmt::format("it had faults: {}{}\n", fmt::join(troubles, ", "), hop_text(report, "round_trip"));
  }
  return summary;
}

}  // namespace hapton
