#include "tools/live/top_view.h"

#include <fmt/core.h>

#include <algorithm>

#include "runtime/report.h"
#include "tools/json_number.h"

namespace hapton {
namespace {

using ReportJson = nlohmann::ordered_json;

const ReportJson& section(const ReportJson& report, const char* name) {
  static const ReportJson kNone = ReportJson::object();
  const auto found = report.find(name);
  return found == report.end() ? kNone : *found;
}

std::string text_in(const ReportJson& object, const char* name) {
  return object.is_object() && object.contains(name) && object[name].is_string() ? object[name].get<std::string>() : "";
}

// Two reports, whose difference is shown. before is null if there is no earlier report or the hub has restarted: all of now is shown.
struct ReportSpan {
  const ReportJson& now;
  const ReportJson* before;
  double seconds;
};

ReportSpan make_span(const TopSnapshot& now, const TopSnapshot* before) {
  const double passed_s = before == nullptr ? 0.0 : json_number_of(now.report, "seconds") - json_number_of(before->report, "seconds");
  if (passed_s <= 0.0) return {now.report, nullptr, json_number_of(now.report, "seconds")};
  return {now.report, &before->report, passed_s};
}

double counter_change(const ReportSpan& span, const char* name) {
  const double earlier = span.before == nullptr ? 0.0 : json_number_of(section(*span.before, "counters"), name);
  return json_number_of(section(span.now, "counters"), name) - earlier;
}

double per_second(const ReportSpan& span, const char* counter) {
  return span.seconds > 0.0 ? counter_change(span, counter) / span.seconds : 0.0;
}

// The same node in an earlier report, found by its address; null if that report lacks it, or if the node has joined again since.
const ReportJson* find_node(const ReportJson* report, const ReportJson& node) {
  if (report == nullptr) return nullptr;
  for (const ReportJson& other : section(*report, "nodes")) {
    if (text_in(other, "address") == text_in(node, "address") && json_number_of(other, "received") <= json_number_of(node, "received"))
      return &other;
  }
  return nullptr;
}

// One line about the safety governor; empty if the hub does not report its state.
std::string safety_text(const ReportJson& report) {
  const ReportJson& notes = section(report, "notes");
  const ReportJson& ratios = section(report, "ratios");
  if (text_in(notes, "governor").empty()) return "";
  const std::string fault = text_in(notes, "safety_fault_text");
  const std::string reset_hint = fault.empty() ? "" : ": " + fault + "; hapton set --reset-faults";
  // energy_spent is negative if the hand has put in more energy than it got: then nothing of the budget is spent.
  const double spent = std::max(0.0, json_number_of(ratios, "energy_spent"));
  return fmt::format("safety governor {}{}; thermal load {:.0f} %, energy {:.0f} % of its budget\n", text_in(notes, "governor"), reset_hint,
                     100.0 * json_number_of(ratios, "thermal_load"), 100.0 * spent);
}

std::string nodes_text(const ReportSpan& span) {
  std::string text = fmt::format("{:<9} {:<28} {:>12} {:>12} {:>8} {:>10} {:>10}\n", "node", "address", "received/s", "sent/s", "lost",
                                 "reordered", "joined for");
  for (const ReportJson& node : section(span.now, "nodes")) {
    const ReportJson* earlier = find_node(span.before, node);
    const double seconds = earlier == nullptr ? json_number_of(node, "seconds") : span.seconds;
    const auto rate = [&](const char* name) {
      return seconds > 0.0 ? (json_number_of(node, name) - (earlier == nullptr ? 0.0 : json_number_of(*earlier, name))) / seconds : 0.0;
    };
    text += fmt::format("{:<9} {:<28} {:>12.1f} {:>12.1f} {:>8.0f} {:>10.0f} {:>8.0f} s\n", text_in(node, "role"), text_in(node, "address"),
                        rate("received"), rate("sent"), json_number_of(node, "lost"), json_number_of(node, "reordered"),
                        json_number_of(node, "seconds"));
  }
  return section(span.now, "nodes").empty() ? text + "(no node has joined)\n" : text;
}

std::string hops_text(const std::vector<HopCounts>& hops) {
  std::string text = fmt::format("{:<18} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "latency, us", "n", "p50", "p90", "p99", "p99.9", "max");
  for (const HopCounts& hop : hops) {
    text += fmt::format("{:<18} {:>9} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f}\n", hop.name, hop.total(), hop.quantile_us(0.5),
                        hop.quantile_us(0.9), hop.quantile_us(0.99), hop.quantile_us(0.999), hop.quantile_us(1.0));
  }
  return text;
}

std::string counters_text(const ReportSpan& span) {
  std::string text = fmt::format("{:<28} {:>12}{}\n", "counter", "total", span.before == nullptr ? "" : "   since last");
  for (const auto& [name, value] : section(span.now, "counters").items()) {
    if (!value.is_number() || value == 0) continue;
    text += fmt::format("{:<28} {:>12}", name, value.dump());
    text += span.before == nullptr ? "\n" : fmt::format(" {:>+12.0f}\n", counter_change(span, name.c_str()));
  }
  return text;
}

}  // namespace

Result<TopSnapshot> read_top_snapshot(const std::string& json, const std::string& csv) {
  TopSnapshot snapshot;
  snapshot.report = ReportJson::parse(json, nullptr, false);
  if (!snapshot.report.is_object() || text_in(snapshot.report, "schema") != kReportSchema) {
    return fail("the hub's report is not of schema {}; it is another version of Hapton", kReportSchema);
  }
  // It is not an error if the hub has not measured any durations yet.
  if (auto hops = parse_latency_csv(csv, "the hub's latency.csv")) snapshot.hops = std::move(*hops);
  return snapshot;
}

std::string make_top_view(const std::string& hub, const TopSnapshot& now, const TopSnapshot* before, const std::string& touched) {
  const ReportSpan span = make_span(now, before);
  const ReportJson& rates = section(now.report, "rates_hz");
  std::string text =
      fmt::format("hub {} on {}: up {:.0f} s, device {}, servo {:.1f} Hz of {:g} Hz requested\n", hub,
                  text_in(section(now.report, "machine"), "host"), json_number_of(now.report, "seconds"),
                  text_in(section(now.report, "notes"), "device"), per_second(span, "samples"), json_number_of(rates, "servo_requested"));
  text +=
      fmt::format("datagrams {:.0f}/s out ({:.1f} kB/s), {:.0f}/s in ({:.1f} kB/s)\n\n", per_second(span, "datagrams_sent"),
                  1e-3 * per_second(span, "bytes_sent"), per_second(span, "datagrams_received"), 1e-3 * per_second(span, "bytes_received"));
  if (const std::string status = text_in(section(now.report, "notes"), "status_now"); !status.empty() && status != "ok")
    text += status + "\n\n";
  if (!touched.empty()) text += touched + "\n\n";
  if (const std::string safety = safety_text(now.report); !safety.empty()) text += safety + "\n";
  text += nodes_text(span) + "\n";
  text += hops_text(span.before == nullptr ? now.hops : subtract_hops(now.hops, before->hops)) + "\n";
  return text + counters_text(span);
}

std::string make_top_json(const std::string& hub, const TopSnapshot& now, const TopSnapshot* before, const std::string& touched) {
  const ReportSpan span = make_span(now, before);
  ReportJson rates = ReportJson::object();
  for (const auto& counter : section(now.report, "counters").items()) rates[counter.key()] = per_second(span, counter.key().c_str());
  const ReportJson snapshot = {{"schema", "hapton.top/1"}, {"hub", hub},         {"span_s", span.seconds},
                               {"per_second", rates},      {"touched", touched}, {"report", now.report}};
  return snapshot.dump(-1, ' ', false, ReportJson::error_handler_t::replace) + "\n";
}

}  // namespace hapton
