#include "tools/latency/report_types.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace hapton {
namespace {

using Json = nlohmann::ordered_json;
using TypeCheck = bool (*)(const Json& value);

bool is_number(const Json& value) { return value.is_number(); }
bool is_text(const Json& value) { return value.is_string(); }
// A ratio that is not finite is written as null.
bool is_ratio(const Json& value) { return value.is_number() || value.is_null(); }

bool is_object_of(const Json& value, TypeCheck has_type) { return value.is_object() && std::all_of(value.begin(), value.end(), has_type); }
bool is_hop(const Json& value) { return is_object_of(value, is_number); }

}  // namespace

bool has_report_types(const Json& report) {
  const auto has_section_type = [&](const char* section, TypeCheck has_type) {
    const auto found = report.find(section);
    return found == report.end() || is_object_of(*found, has_type);
  };
  const auto seconds = report.find("seconds");
  return report.is_object() && has_section_type("hops", is_hop) && has_section_type("counters", is_number) &&
         has_section_type("rates_hz", is_number) && has_section_type("ratios", is_ratio) && has_section_type("notes", is_text) &&
         (seconds == report.end() || is_number(*seconds));
}

}  // namespace hapton
