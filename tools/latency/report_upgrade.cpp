#include "tools/latency/report_upgrade.h"

#include <array>
#include <nlohmann/json.hpp>
#include <string>

#include "runtime/report.h"
#include "tools/json_text.h"

namespace hapton {
namespace {

struct Renamed {
  const char* old_name;
  const char* name;
};

constexpr std::array kRenamed = {
    Renamed{"silence_events", "command_timeouts"},
    Renamed{"slewed", "rate_limited"},
    Renamed{"joins_refused", "joins_rejected"},
    Renamed{"let_go_of", "dead_mans_switch_releases"},
    Renamed{"thermal_cooled", "thermal_limited"},
    Renamed{"speed_braked", "speed_limited"},
    Renamed{"workspace_stopped", "workspace_limited"},
    Renamed{"strangers", "unknown_peers"},
    Renamed{"vision_spared", "vision_unchanged"},
    Renamed{"cycles_untold", "cycles_unreported"},
    Renamed{"safety_fault_is", "safety_fault_text"},
    Renamed{"haptics_clock_ahead", "haptics_clock_offset"},
    Renamed{"haptics_clock_ahead_ns", "haptics_clock_offset_ns"},
    Renamed{"bad_device_samples", "invalid_poses"},
    Renamed{"resets_refused", "resets_rejected"},
    Renamed{"refused_old", "rejected_old"},
    Renamed{"refused_future", "rejected_future"},
    Renamed{"refused_malformed", "rejected_malformed"},
    Renamed{"refused_wrong_version", "rejected_wrong_version"},
    Renamed{"refused_wrong_key", "rejected_wrong_key"},
    Renamed{"refused_replayed_handshakes", "rejected_replayed_handshakes"},
    Renamed{"refused_too_many_handshakes", "rejected_too_many_handshakes"},
    Renamed{"refused_oversized", "rejected_oversized"},
    Renamed{"refused_role", "rejected_role"},
    Renamed{"refused_unknown_session", "rejected_unknown_session"},
    Renamed{"refused_replayed", "rejected_replayed"},
    Renamed{"refused_forged", "rejected_forged"},
    Renamed{"refused_no_place", "rejected_no_slot"},
    Renamed{"servo_asked", "servo_requested"},
    Renamed{"unanswered_without_haptics", "no_reply_without_haptics"},
    Renamed{"echo_answered", "echo_replied"},
    Renamed{"device_cuts", "device_releases"},
    Renamed{"budget_spent", "datagram_budget_exhausted"},
    Renamed{"markers_refused", "markers_rejected"},
    Renamed{"near_throttling", "near_rt_throttling"},
};

void rename_keys(nlohmann::ordered_json& section) {
  for (const Renamed& key : kRenamed) {
    if (!section.contains(key.old_name)) continue;
    section[key.name] = section[key.old_name];
    section.erase(key.old_name);
  }
}

}  // namespace

void upgrade_report(nlohmann::ordered_json& report) {
  if (!report.is_object()) return;
  const std::string schema = json_text_of(report, "schema");
  if (schema != "hapton.report/1" && schema != "hapton.report/2" && schema != "hapton.report/3") return;
  for (const char* section : {"counters", "notes", "rates_hz"}) {
    if (report.contains(section) && report[section].is_object()) rename_keys(report[section]);
  }
  report["schema"] = kReportSchema;
}

}  // namespace hapton
