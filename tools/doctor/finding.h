#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hapton::doctor {

enum class Verdict : std::uint8_t {
  ok,
  note,     // worth knowing; nothing has to be fixed
  warning,  // something works, but not as well as it could
  problem,  // something will not work, or not at 1 kHz
};

// One result of a check. Each text is one line.
struct Finding {
  std::string subject;  // what was checked: "WoodenHaptics 1234:0006"
  Verdict verdict = Verdict::ok;
  std::string observation;  // what was found
  std::string remedy;       // the command or advice that fixes it; never empty for warnings and problems
};

using Findings = std::vector<Finding>;

inline Finding good(std::string subject, std::string observation) { return {std::move(subject), Verdict::ok, std::move(observation), {}}; }
inline Finding note(std::string subject, std::string observation, std::string remedy = {}) {
  return {std::move(subject), Verdict::note, std::move(observation), std::move(remedy)};
}
inline Finding warning(std::string subject, std::string observation, std::string remedy) {
  return {std::move(subject), Verdict::warning, std::move(observation), std::move(remedy)};
}
inline Finding problem(std::string subject, std::string observation, std::string remedy) {
  return {std::move(subject), Verdict::problem, std::move(observation), std::move(remedy)};
}

// "ok", "note", "warning", "problem".
std::string_view to_string(Verdict verdict) noexcept;

}  // namespace hapton::doctor
