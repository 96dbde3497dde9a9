#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/doctor/finding.h"
#include "tools/doctor/machine.h"

namespace hapton::doctor {

// One check of `hapton doctor`.
struct Check {
  std::string_view name;   // for --only
  std::string_view about;  // what it checks, in a few words
  bool is_timing = false;  // its result decides whether a loop at 1 kHz can keep its period
  Findings (*run)(const Machine&) = nullptr;
};

// All checks, in the order of the report.
std::span<const Check> all_checks();

// The findings of one check, as a part of the report.
struct Section {
  std::string name;
  std::string about;
  bool is_timing = false;
  Findings findings;
};

struct Diagnosis {
  std::vector<Section> sections;

  int count(Verdict verdict) const;
  // What prevents a loop of a thousand regular cycles a second: the subjects of all warnings and problems of the timing checks. nullopt
  // if not all of the timing checks were run.
  std::optional<std::vector<std::string>> obstacles_to_1_khz() const;
  // True: no problem was found; there may be warnings.
  bool is_fit() const { return count(Verdict::problem) == 0; }
};

// Runs the named checks, or all if none is named. Pre: each name is a Check::name of all_checks(). RT: no.
Diagnosis diagnose(const Machine& machine, std::span<const std::string> only = {});

// The report for people: the findings of each check, and a verdict at the end; with terminal colours on request.
std::string to_text(const Diagnosis& diagnosis, bool with_colours);
// The report as JSON for programs, schema hapton.doctor/1.
std::string to_json(const Diagnosis& diagnosis);

}  // namespace hapton::doctor
