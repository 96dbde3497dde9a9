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
  bool is_timing = false;  // it concerns whether a 1 kHz loop can keep its period
  Findings (*run)(const Machine&) = nullptr;
};

// All of them, in the order of the report.
std::span<const Check> all_checks();

// The findings of a check.
struct Section {
  std::string name;
  std::string about;
  bool is_timing = false;
  Findings findings;
};

struct Diagnosis {
  std::vector<Section> sections;

  int count(Verdict verdict) const;
  // What prevents a loop of a thousand regular cycles a second: the subjects of all warnings and problems of the timing checks. Empty if
  // not all of those were run.
  std::optional<std::vector<std::string>> obstacles_to_1_khz() const;
  // No problem was found.
  bool is_fit() const { return count(Verdict::problem) == 0; }
};

// Runs the named checks, or all when none is named. Pre: the names are of all_checks(). RT: no.
Diagnosis diagnose(const Machine& machine, std::span<const std::string> only = {});

// For people: a table, and a verdict at its end; colours on request.
std::string to_text(const Diagnosis& diagnosis, bool with_colours);
// For programs: schema hapton.doctor/1.
std::string to_json(const Diagnosis& diagnosis);

}  // namespace hapton::doctor
