#include "bench/papers/papers_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

namespace hapton {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array kOfNodes = {kStereoCulled, kStereoUnculled, kRoundTrip, kSystemLatency};

Json json_of(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }
Json json_of(const TimeSpread& s) {
  return {{"n", s.count},       {"p50_ns", s.p50_ns},     {"p90_ns", s.p90_ns},
          {"p99_ns", s.p99_ns}, {"p99_9_ns", s.p99_9_ns}, {"worst_ns", s.worst_ns}};
}

std::string cell(const std::optional<double>& value, const std::string& unit) {
  return value ? fmt::format("{:.4g}{}{}", *value, unit.empty() ? "" : " ", unit) : "-";
}
std::string field(const std::optional<double>& value) { return value ? fmt::format("{:.6g}", *value) : ""; }

// Quotes the text of a CSV field, so that a comma or a quotation mark in it does not end the field.
std::string quoted(std::string text) {
  for (std::size_t at = text.find('"'); at != std::string::npos; at = text.find('"', at + 2)) text.insert(at, 1, '"');
  std::replace(text.begin(), text.end(), '\n', ' ');
  return '"' + text + '"';
}

std::string tasks_text(const PapersReport& report) {
  if (report.tasks.empty()) return {};
  std::string text = fmt::format(
      "\nThe FDH paper's two tasks on {}, sets of 64 triangles, --layer 1; times: least of {} repetitions\n{:>8} {:>10} {:>10} {:>10} "
      "{:>9} {:>9} {:>9} {:>10} {:>10} {:>9} {:>9} {:>9} {:>9}\n",
      report.tasks_mesh, report.tasks.front().repetitions, "rate Hz", "busy mean", "busy p99", "worst ns", "idle %", "at work %", "worst %",
      "slow p50", "slow max", "swap p50", "age p50", "age max", "no set %");
  for (const SmoothTasks& t : report.tasks) {
    fmt::format_to(
        std::back_inserter(text),
        "{:>8.0f} {:>10.0f} {:>10.0f} {:>10.0f} {:>9.2f} {:>9.2f} {:>9.2f} {:>7.1f} us {:>7.1f} us {:>6.0f} ns {:>6.1f} ms {:>6.1f} "
        "ms {:>9.3f}\n",
        t.rate_hz, t.busy_mean_ns, t.busy.p99_ns, t.busy.worst_ns, 100.0 * t.idle_share(), 100.0 * t.idle_share_at_work(),
        100.0 * t.idle_share_worst(), 1e-3 * t.slow.p50_ns, 1e-3 * t.slow.worst_ns, t.swap.p50_ns, 1e-6 * t.age.p50_ns,
        1e-6 * t.age.worst_ns, 100.0 * t.share_without_set());
  }
  return text +
         "idle: of the period, after the mean step, after the mean step with triangles in reach, after the worst step. age: of the set in\n"
         "use, in time of touch. no set: steps whose set did not reach far enough, so that they selected one or asked the tree "
         "themselves.\n";
}

std::string hulls_text(const PapersReport& report) {
  if (report.hulls.empty()) return {};
  std::string text = fmt::format(
      "\nHulls of 6 (boxes), 14, 18 and 26 directions on {}\n{:>10} {:>12} {:>12} {:>10} {:>10} {:>12} {:>12} {:>9} {:>9}\n",
      report.hulls_mesh, "directions", "64 near p50", "64 near max", "nodes", "triangles", "nearest p50", "segment p50", "build ms", "MB");
  for (const HullDirections& h : report.hulls) {
    fmt::format_to(std::back_inserter(text),
                   "{:>10} {:>9.0f} ns {:>9.0f} ns {:>10.1f} {:>10.1f} {:>9.0f} ns {:>9.0f} ns {:>9.1f} {:>9.2f}\n", h.directions,
                   h.local_set.p50_ns, h.local_set.worst_ns, h.nodes, h.triangles, h.structure.nearests.time.p50_ns,
                   h.structure.segments.time.p50_ns, h.structure.build_ms, 1e-6 * static_cast<double>(h.structure.bytes));
  }
  return text;
}

}  // namespace

std::optional<double> PaperRow::ratio() const {
  if (!paper_value || !ours || *paper_value == 0.0) return std::nullopt;
  return *ours / *paper_value;
}

PaperRow& PapersReport::row(std::string_view key) {
  const auto at = std::find_if(rows.begin(), rows.end(), [key](const PaperRow& row) { return row.key == key; });
  assert(at != rows.end());
  return *at;
}

void PapersReport::leave_out_nodes() {
  std::erase_if(rows, [](const PaperRow& row) { return std::find(kOfNodes.begin(), kOfNodes.end(), row.key) != kOfNodes.end(); });
}

bool PapersReport::is_complete() const {
  return std::all_of(rows.begin(), rows.end(), [](const PaperRow& row) { return row.ours.has_value(); });
}

PapersReport make_papers_report() {
  PapersReport report;
  const auto add = [&](std::string key, std::string what, std::string unit, std::optional<double> paper_value, std::string quote) {
    report.rows.push_back({std::move(key), std::move(what), std::move(unit), paper_value, std::move(quote), std::nullopt, "not measured"});
  };
  add("memo.grid_occupied", "grid 32^3 on the car: cells occupied", "%", 25.0, "4.2.2: cell occupancy factor of 25 %");
  add("memo.grid_mean", "... triangles an occupied cell, mean", "", 3.0, "4.2.2: 3 triangles on average");
  add("memo.grid_max", "... triangles a cell, at most", "", 23.0, "4.2.2: the maximum number was 23");
  add("memo.force_rate_grid", "force rate, sweep through the grid", "Hz", 1000.0, "2.0: force update rates of over 1000 Hz");
  add("memo.force_rate_all", "force rate, every triangle tested in every step", "Hz", 1000.0,
      "2.0: the naive collision cost that the grid avoids; held against the same 1000 Hz");
  add("memo.haptons", "haptons, one core", "", 1.0, "4.1: performed at the 1 hapton level");
  add("memo.haptons_capable", "... against what the memo's machine is capable of", "", 5.0, "4.1: capable of approximately 5 haptons");
  add(std::string(kStereoCulled), "stereo frames a second, back faces culled", "Hz", 20.0, "4.2.1: up to 20 Hz");
  add(std::string(kStereoUnculled), "... without culling", "Hz", 8.0, "4.2.1: around 8 Hz");
  add(std::string(kRoundTrip), "force round trip", "ms", 0.7, "4.1: roundtrip communications latency of 0.7 milliseconds");
  add(std::string(kSystemLatency), "system latency: device sample to drawn frame", "ms", 50.0,
      "abstract: system latency of 50 milliseconds, dictated by rendering");
  add("fdh.query_typical", "FDH query, 64 triangles of 20,000: typical", "ms", 3.0, "6: typically around 3 ms");
  add("fdh.query_most", "... at most", "ms", 10.0, "6: within the range of 10 ms and less");
  add("fdh.idle_1khz", "idle time of the fast task, 64 triangles, 1 kHz", "%", std::nullopt, "");
  add("fdh.idle_3khz", "... 3 kHz", "%", 50.0, "6: around 50 % idle time with 3 kHz update rate");
  add("fdh.idle_10khz", "... 10 kHz", "%", std::nullopt, "6: rates up to 10 kHz");
  add("fdh.rate", "rate that the fast task's worst step allows", "Hz", 10000.0, "6: up to 10 kHz, a limit of the hardware");
  add("fdh.swap", "hand-over of a set to the fast task", "us", std::nullopt, "7: left for future work");
  add("fdh.without_set", "steps without a set that reaches far enough, 1 kHz", "%", std::nullopt, "");
  add("fdh.boxes_time", "FDH14 query time over that of boxes, 64 triangles", "", 1.0, "5: almost the same processing speed as AABBs");
  add("fdh.boxes_triangles", "FDH14 triangles looked at over those of boxes", "", std::nullopt, "5: bound objects more tightly");
  return report;
}

std::optional<double> parse_bench_rate(std::string_view output) {
  constexpr std::string_view kBench = "bench: ";
  constexpr std::string_view kFrames = " frames, ";
  const std::size_t line = output.rfind(kBench);
  const std::size_t frames = line == std::string_view::npos ? line : output.find(kFrames, line);
  if (frames == std::string_view::npos) return std::nullopt;
  double rate = 0.0;
  const char* const from = output.data() + frames + kFrames.size();
  const auto [end, error] = std::from_chars(from, output.data() + output.size(), rate);
  const std::string_view rest(end, static_cast<std::size_t>(output.data() + output.size() - end));
  if (error != std::errc() || !rest.starts_with(" Hz") || !(rate > 0.0)) return std::nullopt;
  return rate;
}

std::string to_text(const PapersReport& report) {
  std::string text = fmt::format("{:<52} {:>12} {:>14} {:>10}\n", "figure", "paper", "ours", "ours/paper");
  std::string paper;
  for (const PaperRow& row : report.rows) {
    const std::string of = row.key.starts_with("memo.") ? "HP memo (1996)" : "FDH paper (2001)";
    if (of != paper) text += fmt::format("-- {} --\n", of);
    paper = of;
    const auto ratio = row.ratio();
    fmt::format_to(std::back_inserter(text), "{:<52} {:>12} {:>14} {:>10}\n    {}{}{}\n", row.what, cell(row.paper_value, row.unit),
                   cell(row.ours, row.unit), ratio ? fmt::format("{:.3g}", *ratio) : "-", row.quote, row.quote.empty() ? "" : " | ",
                   row.how);
  }
  return text + tasks_text(report) + hulls_text(report) + "\n" + report.conditions.to_text() + "\n";
}

std::string to_json(const PapersReport& report) {
  Json json = to_json(report.conditions, "hapton bench papers");
  json["complete"] = report.is_complete();
  json["rows"] = Json::array();
  for (const PaperRow& row : report.rows) {
    json["rows"].push_back({{"key", row.key},
                            {"what", row.what},
                            {"unit", row.unit},
                            {"paper", json_of(row.paper_value)},
                            {"paper_says", row.quote},
                            {"ours", json_of(row.ours)},
                            {"ours_over_paper", json_of(row.ratio())},
                            {"how", row.how}});
  }
  json["tasks_mesh"] = report.tasks_mesh;
  json["tasks"] = Json::array();
  for (const SmoothTasks& t : report.tasks) {
    json["tasks"].push_back({{"rate_hz", t.rate_hz},
                             {"repetitions", t.repetitions},
                             {"steps", t.steps},
                             {"contact_steps", t.contact_steps},
                             {"busy_mean_ns", t.busy_mean_ns},
                             {"busy", json_of(t.busy)},
                             {"at_work_mean_ns", t.at_work_mean_ns},
                             {"at_work", json_of(t.at_work)},
                             {"idle_share", t.idle_share()},
                             {"idle_share_at_work", t.idle_share_at_work()},
                             {"idle_share_worst", t.idle_share_worst()},
                             {"slow_task", json_of(t.slow)},
                             {"swap", json_of(t.swap)},
                             {"set_age", json_of(t.age)},
                             {"sets_offered", t.offered},
                             {"steps_without_set", t.without_set},
                             {"steps_beyond_set", t.beyond_set}});
  }
  json["hulls_mesh"] = report.hulls_mesh;
  json["hulls"] = Json::array();
  for (const HullDirections& h : report.hulls) {
    json["hulls"].push_back({{"directions", h.directions},
                             {"local_set", json_of(h.local_set)},
                             {"nodes_per_local_set", h.nodes},
                             {"triangles_per_local_set", h.triangles},
                             {"nearest", json_of(h.structure.nearests.time)},
                             {"segment", json_of(h.structure.segments.time)},
                             {"build_ms", h.structure.build_ms},
                             {"bytes", h.structure.bytes}});
  }
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string to_csv(const PapersReport& report) {
  std::string text = "key,what,unit,paper,ours,ours_over_paper,paper_says,how\n";
  for (const PaperRow& row : report.rows) {
    fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{},{},{}\n", row.key, quoted(row.what), row.unit, field(row.paper_value),
                   field(row.ours), field(row.ratio()), quoted(row.quote), quoted(row.how));
  }
  return text;
}

std::string tasks_csv(const PapersReport& report) {
  std::string text =
      "rate_hz,repetitions,steps,contact_steps,busy_mean_ns,busy_p50_ns,busy_p99_ns,busy_worst_ns,at_work_mean_ns,idle_share,"
      "idle_share_at_work,idle_share_worst,slow_p50_ns,slow_p99_ns,slow_worst_ns,swap_p50_ns,swap_worst_ns,age_p50_ns,age_p99_ns,"
      "age_worst_ns,sets_offered,steps_without_set,steps_beyond_set\n";
  for (const SmoothTasks& t : report.tasks) {
    fmt::format_to(
        std::back_inserter(text),
        "{:.0f},{},{},{},{:.1f},{:.1f},{:.1f},{:.1f},{:.1f},{:.6f},{:.6f},{:.6f},{:.1f},{:.1f},{:.1f},{:.1f},{:.1f},{:.0f},{:.0f},"
        "{:.0f},{},{},{}\n",
        t.rate_hz, t.repetitions, t.steps, t.contact_steps, t.busy_mean_ns, t.busy.p50_ns, t.busy.p99_ns, t.busy.worst_ns,
        t.at_work_mean_ns, t.idle_share(), t.idle_share_at_work(), t.idle_share_worst(), t.slow.p50_ns, t.slow.p99_ns, t.slow.worst_ns,
        t.swap.p50_ns, t.swap.worst_ns, t.age.p50_ns, t.age.p99_ns, t.age.worst_ns, t.offered, t.without_set, t.beyond_set);
  }
  return text;
}

std::string hulls_csv(const PapersReport& report) {
  std::string text =
      "directions,local_set_p50_ns,local_set_p99_ns,local_set_worst_ns,nodes_per_local_set,triangles_per_local_set,nearest_p50_ns,"
      "nearest_p99_ns,segment_p50_ns,segment_p99_ns,build_ms,bytes\n";
  for (const HullDirections& h : report.hulls) {
    fmt::format_to(std::back_inserter(text), "{},{:.1f},{:.1f},{:.1f},{:.2f},{:.2f},{:.1f},{:.1f},{:.1f},{:.1f},{:.3f},{}\n", h.directions,
                   h.local_set.p50_ns, h.local_set.p99_ns, h.local_set.worst_ns, h.nodes, h.triangles, h.structure.nearests.time.p50_ns,
                   h.structure.nearests.time.p99_ns, h.structure.segments.time.p50_ns, h.structure.segments.time.p99_ns,
                   h.structure.build_ms, h.structure.bytes);
  }
  return text;
}

}  // namespace hapton
