#include "tools/latency/report_types.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace hapton {
namespace {

using Json = nlohmann::ordered_json;
using IsRight = bool (*)(const Json& value);

bool is_number(const Json& value) { return value.is_number(); }
bool is_text(const Json& value) { return value.is_string(); }
// A ratio that is not finite is written as null.
bool is_ratio(const Json& value) { return value.is_number() || value.is_null(); }

bool is_object_of(const Json& value, IsRight is_right) { return value.is_object() && std::all_of(value.begin(), value.end(), is_right); }
bool is_hop(const Json& value) { return is_object_of(value, is_number); }

}  // namespace

bool has_report_types(const Json& report) {
  const auto has = [&](const char* section, IsRight is_right) {
    const auto found = report.find(section);
    return found == report.end() || is_object_of(*found, is_right);
  };
  const auto seconds = report.find("seconds");
  return report.is_object() && has("hops", is_hop) && has("counters", is_number) && has("rates_hz", is_number) && has("ratios", is_ratio) &&
         has("notes", is_text) && (seconds == report.end() || is_number(*seconds));
}

}  // namespace hapton
