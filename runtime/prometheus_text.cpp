#include "runtime/prometheus_text.h"

#include <array>
#include <string_view>
#include <utility>

namespace hapton {
namespace {

// Inside the quotes of a label.
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

std::string hops_text(const LatencyReport& report) {
  std::string text = head("hapton_latency_seconds", "summary", "Latency of each hop.");
  for (const LatencyHop& hop : report.hops) {
    const LatencyHistogram& h = hop.histogram;
    const std::string label = fmt::format("hop=\"{}\"", escaped(hop.name));
    for (const double quantile : {0.5, 0.9, 0.99, 0.999}) {
      text += fmt::format("hapton_latency_seconds{{{},quantile=\"{}\"}} {:.9g}\n", label, quantile, 1e-9 * h.quantile_ns(quantile));
    }
    text += fmt::format("hapton_latency_seconds{{{},quantile=\"1\"}} {:.9g}\n", label, 1e-9 * static_cast<double>(h.max_ns()));
    text += fmt::format("hapton_latency_seconds_sum{{{}}} {:.9g}\n", label, 1e-9 * h.mean_ns() * static_cast<double>(h.count()));
    text += fmt::format("hapton_latency_seconds_count{{{}}} {}\n", label, h.count());
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
  for (const auto& [name, count] : report.counters) {
    const std::string metric = fmt::format("hapton_{}_total", name);
    text += head(metric, "counter", "See docs/latency.md.") + fmt::format("{} {}\n", metric, count);
  }
  text += head("hapton_rate_hertz", "gauge", "Since the start.");
  for (const auto& [name, rate_hz] : report.rates_hz)
    text += fmt::format("hapton_rate_hertz{{name=\"{}\"}} {:.9g}\n", escaped(name), rate_hz);
  text += head("hapton_ratio", "gauge", "Shares and ratios within this run.");
  for (const auto& [name, ratio] : report.ratios) text += fmt::format("hapton_ratio{{name=\"{}\"}} {:.9g}\n", escaped(name), ratio);
  return text + nodes_text(report) + hops_text(report);
}

}  // namespace hapton
