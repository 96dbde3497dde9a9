#include "runtime/prometheus_text.h"

#include <array>
#include <cstdint>
#include <string_view>
#include <utility>

#include "runtime/counter_descriptions.h"

namespace hapton {
namespace {

// The text as it stands within the quotes of a label.
std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '\\' || c == '"') result += '\\';
    result += c == '\n' ? ' ' : c;
  }
  return result;
}

std::string head(std::string_view name, std::string_view type, std::string_view help) {
  return fmt::format("# HELP {} {}\n# TYPE {} {}\n", name, help, name, type);
}

// 1, 2 and 5 in each decade from a microsecond to a second.
constexpr std::array<std::int64_t, 19> kBoundsNs = {1'000,      2'000,       5'000,       10'000,      20'000,       50'000,     100'000,
                                                    200'000,    500'000,     1'000'000,   2'000'000,   5'000'000,    10'000'000, 20'000'000,
                                                    50'000'000, 100'000'000, 200'000'000, 500'000'000, 1'000'000'000};

// For each bound, how many durations were at most that long. A bucket of the histogram (1.6 % wide) that a bound divides does not count.
std::array<std::uint64_t, kBoundsNs.size()> count_within(const LatencyHistogram& histogram) {
  std::array<std::uint64_t, kBoundsNs.size()> cumulative = {};
  histogram.for_each_bucket([&](std::int64_t, std::int64_t upper_ns, std::uint64_t count) {
    for (std::size_t i = 0; i < kBoundsNs.size(); ++i) cumulative[i] += upper_ns - 1 <= kBoundsNs[i] ? count : 0;
  });
  return cumulative;
}

std::string hops_text(const LatencyReport& report) {
  std::string text = head("hapton_latency_seconds", "histogram", "Latency of each hop since the start.");
  for (const LatencyHop& hop : report.hops) {
    const LatencyHistogram& h = hop.histogram;
    const std::string label = fmt::format("hop=\"{}\"", escaped(hop.name));
    const auto cumulative = count_within(h);
    for (std::size_t i = 0; i < kBoundsNs.size(); ++i)
      text += fmt::format("hapton_latency_seconds_bucket{{{},le=\"{:g}\"}} {}\n", label, 1e-9 * static_cast<double>(kBoundsNs[i]),
                          cumulative[i]);
    text += fmt::format("hapton_latency_seconds_bucket{{{},le=\"+Inf\"}} {}\n", label, h.count());
    text += fmt::format("hapton_latency_seconds_sum{{{}}} {:.9g}\n", label, 1e-9 * h.mean_ns() * static_cast<double>(h.count()));
    text += fmt::format("hapton_latency_seconds_count{{{}}} {}\n", label, h.count());
  }
  text += head("hapton_latency_longest_seconds", "gauge", "Longest latency of each hop since the start.");
  for (const LatencyHop& hop : report.hops) {
    text += fmt::format("hapton_latency_longest_seconds{{hop=\"{}\"}} {:.9g}\n", escaped(hop.name),
                        1e-9 * static_cast<double>(hop.histogram.max_ns()));
  }
  return text;
}

// A count whose name ends in _us is written as a time in seconds, others unchanged. One that begins with longest_ is a gauge.
std::string counters_text(const LatencyReport& report) {
  std::string text;
  for (const auto& [name, count] : report.counters) {
    const bool is_time = name.ends_with("_us");
    const bool is_gauge = name.starts_with("longest_");
    const std::string metric =
        fmt::format("hapton_{}{}{}", is_time ? name.substr(0, name.size() - 3) : name, is_time ? "_seconds" : "", is_gauge ? "" : "_total");
    const std::string_view description = describe_counter(name);
    text += head(metric, is_gauge ? "gauge" : "counter", description.empty() ? name : description);
    text += is_time ? fmt::format("{} {:.9g}\n", metric, 1e-6 * static_cast<double>(count)) : fmt::format("{} {}\n", metric, count);
  }
  return text;
}

std::string nodes_text(const LatencyReport& report) {
  static constexpr std::array<std::pair<const char*, std::int64_t ReportNode::*>, 6> kCounts = {{
      {"received", &ReportNode::received},
      {"lost", &ReportNode::lost},
      {"reordered", &ReportNode::reordered},
      {"duplicate", &ReportNode::duplicate},
      {"sent", &ReportNode::sent},
      {"send_failures", &ReportNode::send_failures},
  }};
  std::string text;
  for (const auto& [name, count] : kCounts) {
    const std::string metric = fmt::format("hapton_node_{}_total", name);
    text += head(metric, "counter", "Datagrams of each joined node.");
    for (const ReportNode& node : report.nodes) {
      text += fmt::format("{}{{role=\"{}\",address=\"{}\"}} {}\n", metric, escaped(node.role), escaped(node.address), node.*count);
    }
  }
  return text;
}

}  // namespace

std::string to_prometheus(const LatencyReport& report) {
  std::string text = head("hapton_up_seconds", "gauge", "Time since measurements began.");
  text += fmt::format("hapton_up_seconds {:.9g}\n", report.seconds);
  text += counters_text(report);
  text += head("hapton_rate_hertz", "gauge", "Since the start.");
  for (const auto& [name, rate_hz] : report.rates_hz)
    text += fmt::format("hapton_rate_hertz{{name=\"{}\"}} {:.9g}\n", escaped(name), rate_hz);
  text += head("hapton_ratio", "gauge", "Shares and ratios within this run.");
  for (const auto& [name, ratio] : report.ratios) text += fmt::format("hapton_ratio{{name=\"{}\"}} {:.9g}\n", escaped(name), ratio);
  return text + nodes_text(report) + hops_text(report);
}

}  // namespace hapton
