#include "tools/latency/latency_compare.h"

#include <fmt/core.h>

#include <array>
#include <string_view>
#include <utility>

#include "runtime/regular_file.h"
#include "runtime/report.h"
#include "tools/json_number.h"
#include "tools/json_text.h"
#include "tools/latency/report_types.h"
#include "tools/latency/report_upgrade.h"

namespace hapton {
namespace {

constexpr std::size_t kMaxReportBytes = std::size_t{64} << 20;  // a larger file is not a report; a free choice
constexpr std::array kQuantiles = {std::pair{"p50_us", "p50"}, std::pair{"p99_us", "p99"}, std::pair{"p99_9_us", "p99.9"},
                                   std::pair{"max_us", "max"}};

nlohmann::ordered_json pair_json(double a, double b) {
  nlohmann::ordered_json json = {{"a", a}, {"b", b}};
  if (a != 0.0) json["ratio"] = b / a;
  return json;
}

// Compares the numeric entries that both reports have in this section.
nlohmann::ordered_json compare_numbers(const nlohmann::ordered_json& a, const nlohmann::ordered_json& b, const char* section,
                                       bool only_differing) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  const auto of_a = a.value(section, nlohmann::ordered_json::object());
  const auto of_b = b.value(section, nlohmann::ordered_json::object());
  for (const auto& [name, value] : of_a.items()) {
    if (!value.is_number() || !of_b.contains(name) || !of_b[name].is_number()) continue;
    if (only_differing && value == of_b[name]) continue;
    json[name] = pair_json(value.get<double>(), of_b[name].get<double>());
  }
  return json;
}

std::string ratio_text(const nlohmann::ordered_json& pair) {
  return pair.contains("ratio") ? fmt::format("{:>7.2f}", pair["ratio"].get<double>()) : fmt::format("{:>7}", "-");
}

}  // namespace

Result<nlohmann::ordered_json> read_report_json(const std::filesystem::path& path) {
  std::error_code ignored;
  const auto file_path = std::filesystem::is_directory(path, ignored) ? path / "report.json" : path;
  const auto text = read_regular_file(file_path, "a run with --out writes it", kMaxReportBytes);
  if (!text) return tl::unexpected(text.error());
  auto json = nlohmann::ordered_json::parse(*text, nullptr, false);
  upgrade_report(json);
  if (json_text_of(json, "schema") != kReportSchema || !json.contains("hops") || !has_report_types(json)) {
    return fail("{}: is not a latency report (schema {})", file_path.string(), kReportSchema);
  }
  return json;
}

nlohmann::ordered_json compare_json(const nlohmann::ordered_json& a, const nlohmann::ordered_json& b) {
  nlohmann::ordered_json json = {{"schema", "hapton.latency-compare/1"}, {"hops", nlohmann::ordered_json::object()}};
  for (const auto& [name, of_a] : a["hops"].items()) {
    if (!b["hops"].contains(name)) continue;
    const auto& of_b = b["hops"][name];
    if (json_number_of(of_a, "n") == 0.0 || json_number_of(of_b, "n") == 0.0) continue;
    nlohmann::ordered_json hop = {{"n", {{"a", of_a["n"]}, {"b", of_b["n"]}}}};
    for (const auto& [key, unused] : kQuantiles) hop[key] = pair_json(json_number_of(of_a, key), json_number_of(of_b, key));
    json["hops"][name] = hop;
  }
  json["seconds"] = pair_json(json_number_of(a, "seconds"), json_number_of(b, "seconds"));
  json["ratios"] = compare_numbers(a, b, "ratios", false);
  json["rates_hz"] = compare_numbers(a, b, "rates_hz", false);
  json["counters"] = compare_numbers(a, b, "counters", true);
  return json;
}

std::string compare_text(const nlohmann::ordered_json& a, const nlohmann::ordered_json& b) {
  const auto compared = compare_json(a, b);
  std::string text = fmt::format("{:<18}", "us");
  for (const auto& [unused, title] : kQuantiles) text += fmt::format(" {:>9} {:>9} {:>7}", fmt::format("{} A", title), "B", "B/A");
  text += "\n";
  for (const auto& [name, hop] : compared["hops"].items()) {
    text += fmt::format("{:<18}", name);
    for (const auto& [key, unused] : kQuantiles) {
      text += fmt::format(" {:>9.2f} {:>9.2f} {}", hop[key]["a"].get<double>(), hop[key]["b"].get<double>(), ratio_text(hop[key]));
    }
    text += "\n";
  }
  for (const char* section : {"ratios", "rates_hz", "counters"}) {
    if (compared[section].empty()) continue;
    text += fmt::format("{:<28} {:>12} {:>12} {:>7}\n", section, "A", "B", "B/A");
    if (std::string_view(section) == "counters") {
      text += fmt::format("  {:<26} {:>12.6g} {:>12.6g} {}\n", "(in so many seconds)", compared["seconds"]["a"].get<double>(),
                          compared["seconds"]["b"].get<double>(), ratio_text(compared["seconds"]));
    }
    for (const auto& [name, pair] : compared[section].items()) {
      text += fmt::format("  {:<26} {:>12.6g} {:>12.6g} {}\n", name, pair["a"].get<double>(), pair["b"].get<double>(), ratio_text(pair));
    }
  }
  return text;
}

}  // namespace hapton
