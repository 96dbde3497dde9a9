#include "tools/doctor/diagnosis.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "runtime/build_id.h"
#include "tools/doctor/cpu_check.h"
#include "tools/doctor/device_check.h"
#include "tools/doctor/display_check.h"
#include "tools/doctor/hub_check.h"
#include "tools/doctor/library_check.h"
#include "tools/doctor/network_check.h"
#include "tools/doctor/realtime_rights_check.h"

namespace hapton::doctor {
namespace {

constexpr std::array kChecks = {
    Check{"devices", "what is plugged in, its node, driver and rights", false, check_devices},
    Check{"libraries", "vendors' libraries", false, check_libraries},
    Check{"services", "daemons that affect devices", false, check_services},
    Check{"hub", "what a running io_node reports about its device", false, check_hub},
    Check{"rights", "what the servo loop may request", true, check_rights},
    Check{"sleep", "how long CPUs take to wake", true, check_sleep},
    Check{"cpus", "number, frequency, hypervisor", true, check_cpus},
    Check{"clock", "what the time is read from", true, check_clock},
    Check{"kernel", "whether it can be interrupted", true, check_kernel},
    Check{"ports", "free, or used by which process", false, check_ports},
    Check{"keys", "of the encrypted link", false, check_keys},
    Check{"firewall", "whether other hosts get in", false, check_firewall},
    Check{"display", "renderer, and quad-buffer stereo", false, check_display},
};

constexpr std::string_view colour_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::ok:
      return "\x1b[32m";
    case Verdict::note:
      return "\x1b[36m";
    case Verdict::warning:
      return "\x1b[33m";
    case Verdict::problem:
      return "\x1b[1;31m";
  }
  return {};
}

std::string marked(Verdict verdict, bool with_colours) {
  const std::string word = fmt::format("{:<8}", to_string(verdict));
  return with_colours ? fmt::format("{}{}\x1b[0m", colour_of(verdict), word) : word;
}

std::string counted(int count, std::string_view what) { return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s"); }

std::string timing_line(const Diagnosis& diagnosis) {
  const auto obstacles = diagnosis.obstacles_to_1_khz();
  if (!obstacles) return {};
  if (obstacles->empty()) return "obstacles to 1 kHz: none\n";
  return fmt::format("obstacles to 1 kHz: {}\n", fmt::join(*obstacles, ", "));
}

std::string verdict_line(const Diagnosis& diagnosis) {
  const int problems = diagnosis.count(Verdict::problem);
  const std::string warnings = counted(diagnosis.count(Verdict::warning), "warning");
  if (problems == 0) return fmt::format("no problem, {}\n", warnings);
  return fmt::format("{}, {}; the commands that fix them are above\n", counted(problems, "problem"), warnings);
}

bool is_selected(const Check& check, std::span<const std::string> only) {
  return only.empty() || std::find(only.begin(), only.end(), check.name) != only.end();
}

}  // namespace

std::span<const Check> all_checks() { return kChecks; }

int Diagnosis::count(Verdict verdict) const {
  int count = 0;
  for (const Section& section : sections) {
    count += static_cast<int>(std::count_if(section.findings.begin(), section.findings.end(),
                                            [&](const Finding& finding) { return finding.verdict == verdict; }));
  }
  return count;
}

std::optional<std::vector<std::string>> Diagnosis::obstacles_to_1_khz() const {
  std::vector<std::string> obstacles;
  std::ptrdiff_t checked = 0;
  for (const Section& section : sections) {
    if (!section.is_timing) continue;
    ++checked;
    for (const Finding& finding : section.findings) {
      if (finding.verdict == Verdict::warning || finding.verdict == Verdict::problem) obstacles.push_back(finding.subject);
    }
  }
  if (checked < std::count_if(
                    kChecks.begin(), kChecks.end(), [](const Check& check) { return check.is_timing; }))
    return std::nullopt;
  return obstacles;
}

Diagnosis diagnose(const Machine& machine, std::span<const std::string> only) {
  Diagnosis diagnosis;
  for (const Check& check : kChecks) {
    if (is_selected(check, only))
      diagnosis.sections.push_back({std::string(check.name), std::string(check.about), check.is_timing, check.run(machine)});
  }
  return diagnosis;
}

std::string to_text(const Diagnosis& diagnosis, bool with_colours) {
  std::string text;
  for (const Section& section : diagnosis.sections) {
    text += fmt::format("{}: {}\n", section.name, section.about);
    for (const Finding& finding : section.findings) {
      text += fmt::format("  {} {}: {}\n", marked(finding.verdict, with_colours), finding.subject, finding.observation);
      if (finding.remedy.empty()) continue;
      text += fmt::format("           {}: {}\n", finding.verdict == Verdict::note ? "hint" : "fix", finding.remedy);
    }
  }
  return text + "\n" + timing_line(diagnosis) + verdict_line(diagnosis);
}

std::string to_json(const Diagnosis& diagnosis) {
  nlohmann::ordered_json json = {{"schema", "hapton.doctor/1"},
                                 {"build", build_id()},
                                 {"fit", diagnosis.is_fit()},
                                 {"problems", diagnosis.count(Verdict::problem)},
                                 {"warnings", diagnosis.count(Verdict::warning)},
                                 {"checks", nlohmann::ordered_json::array()}};
  if (const auto obstacles = diagnosis.obstacles_to_1_khz()) json["obstacles_to_1_khz"] = *obstacles;
  for (const Section& section : diagnosis.sections) {
    nlohmann::ordered_json check = {{"name", section.name}, {"about", section.about}, {"findings", nlohmann::ordered_json::array()}};
    for (const Finding& finding : section.findings) {
      check["findings"].push_back({{"subject", finding.subject},
                                   {"verdict", to_string(finding.verdict)},
                                   {"seen", finding.observation},
                                   {"remedy", finding.remedy}});
    }
    json["checks"].push_back(std::move(check));
  }
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace hapton::doctor
