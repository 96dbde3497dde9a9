#include "tools/soak/soak_verdict.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "runtime/report.h"

namespace hapton {
namespace {

// Share of the run that is warm-up and not evaluated. The warm-up has at least kWarmUpSeconds, but at most kMaxWarmUpShare of a short run.
constexpr double kWarmUpShare = 0.1;
constexpr double kWarmUpSeconds = 30.0;  // by then io_node's heap has its final size
constexpr double kMaxWarmUpShare = 0.5;
constexpr double kMaxMemoryGrowthShare = 0.01;  // growth of at most this share of the memory, plus kMaxMemoryGrowthKib, is not a leak
constexpr double kMaxMemoryGrowthKib = 1024.0;  // KiB: 1 MiB
constexpr double kMaxCountChange = 0.5;         // a smaller change of a count passes: one more descriptor or thread is larger
constexpr double kMinRateShare = 0.99;          // least median of the observed rates, as a share of the requested rate; a free choice
constexpr double kMaxDriftMs = 100.0;           // a sample's own uncertainty: the report and the clock are not read at the same instant
constexpr double kMaxDriftShare = 1e-4;         // no quartz clock is off by so much
constexpr std::size_t kMinSamples = 5;          // the medians of thirds of fewer observations say nothing
constexpr std::size_t kMaxPoints = 512;  // the trend is found from at most so many, as its work grows with their square; a free choice

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

double warm_up_s(double seconds) { return std::max(kWarmUpShare * seconds, std::min(kWarmUpSeconds, kMaxWarmUpShare * seconds)); }

double median_of(std::span<const double> values) { return median({values.begin(), values.end()}); }

// The slopes of all pairs of a long series would take minutes to compute, so neighbours are replaced by their median.
std::vector<double> take_block_medians(std::span<const double> values, std::size_t block) {
  std::vector<double> block_medians;
  for (std::size_t i = 0; i < values.size(); i += block)
    block_medians.push_back(median_of(values.subspan(i, std::min(block, values.size() - i))));
  return block_medians;
}

double median_slope(const std::vector<double>& times, const std::vector<double>& values) {
  std::vector<double> slopes;
  for (std::size_t i = 0; i < times.size(); ++i) {
    for (std::size_t j = i + 1; j < times.size(); ++j) {
      if (times[j] > times[i]) slopes.push_back((values[j] - values[i]) / (times[j] - times[i]));
    }
  }
  return slopes.empty() ? 0.0 : median(std::move(slopes));
}

// The samples after the warm-up; each quantity is taken from them as a series.
class Series {
 public:
  explicit Series(const SoakRun& run) {
    for (const SoakSample& sample : run.samples) {
      if (sample.seconds >= warm_up_s(run.seconds)) samples_.push_back(&sample);
    }
    times_ = values_of([](const SoakSample& sample) { return sample.seconds; });
  }

  std::size_t size() const { return samples_.size(); }
  double seconds() const { return times_.back() - times_.front(); }
  std::vector<double> values_of(const std::function<double(const SoakSample&)>& figure) const {
    std::vector<double> values;
    for (const SoakSample* sample : samples_) values.push_back(figure(*sample));
    return values;
  }
  double rise(const std::vector<double>& values) const { return find_rise(times_, values); }

 private:
  std::vector<const SoakSample*> samples_;
  std::vector<double> times_;
};

SoakFinding check_memory(const Series& series, const std::string& process, std::size_t index) {
  const auto kib = series.values_of([&](const SoakSample& sample) { return static_cast<double>(sample.processes[index].resident_kib); });
  const double rise = series.rise(kib);
  const double limit = kMaxMemoryGrowthShare * median(kib) + kMaxMemoryGrowthKib;
  return {"memory", process,       rise,
          limit,    rise <= limit, fmt::format("{} memory {:+.0f} KiB of {:.0f} (at most {:+.0f})", process, rise, median(kib), limit)};
}

SoakFinding check_count(const Series& series, const std::string& process, const char* what, const std::vector<double>& counts) {
  const double rise = series.rise(counts);
  return {what,
          process,
          rise,
          0.0,
          std::abs(rise) < kMaxCountChange,
          fmt::format("{} {} {:+.1f} of {:.0f}", process, what, rise, median(counts))};
}

SoakFinding check_rate(const Series& series, double rate_hz) {
  const double samples_hz = median(series.values_of([](const SoakSample& sample) { return sample.samples_hz; }));
  const double forces_hz = median(series.values_of([](const SoakSample& sample) { return sample.forces_hz; }));
  const double least = std::min(samples_hz, forces_hz);
  const double limit = kMinRateShare * rate_hz;
  return {"rate",         "",
          least,          limit,
          least >= limit, fmt::format("{:.1f} samples and {:.1f} forces a second of {:g}", samples_hz, forces_hz, rate_hz)};
}

SoakFinding check_drift(const Series& series) {
  const double drift_ms = series.rise(series.values_of([](const SoakSample& sample) { return sample.drift_ms; }));
  const double limit = kMaxDriftMs + 1e3 * kMaxDriftShare * series.seconds();
  return {"drift", "", drift_ms, limit, std::abs(drift_ms) <= limit, fmt::format("ticks drifted {:+.1f} ms from the clock", drift_ms)};
}

SoakFinding check_lost(const SoakRun& run) {
  const std::int64_t lost = run.samples.back().lost;
  return {"lost", "", static_cast<double>(lost), 0.0, lost == 0, fmt::format("forces lost: {}", lost)};
}

SoakFinding check_length(const SoakRun& run, std::size_t samples) {
  const double reached_s = run.samples.empty() ? 0.0 : run.samples.back().seconds;
  const bool is_enough = run.end_reason.empty() && samples >= kMinSamples;
  const std::string why = run.end_reason.empty() ? "too few observations" : run.end_reason;
  return {"run",       "",        reached_s,
          run.seconds, is_enough, is_enough ? "ran for the requested time" : fmt::format("{}, after {:.0f} s", why, reached_s)};
}

double worst_round_trip_us(const SoakRun& run) {
  double worst = 0.0;
  for (const SoakSample& sample : run.samples) worst = std::max(worst, sample.round_trip_max_us);
  return worst;
}

nlohmann::ordered_json process_json(const SoakRun& run, std::size_t index) {
  const ProcessStats& first = run.samples.front().processes[index];
  const ProcessStats& last = run.samples.back().processes[index];
  return {{"name", run.processes[index]},
          {"resident_kib", {{"first", first.resident_kib}, {"last", last.resident_kib}}},
          {"descriptors", {{"first", first.descriptors}, {"last", last.descriptors}}},
          {"threads", {{"first", first.threads}, {"last", last.threads}}}};
}

}  // namespace

double find_rise(std::span<const double> times, std::span<const double> values) {
  const std::size_t third = values.size() / 3;
  if (third == 0) return 0.0;
  const std::size_t block = (values.size() + kMaxPoints - 1) / kMaxPoints;
  const double gradual_rise =
      median_slope(take_block_medians(times, block), take_block_medians(values, block)) * (times.back() - times.front());
  const double step_rise = median_of(values.last(third)) - median_of(values.first(third));
  return std::abs(gradual_rise) > std::abs(step_rise) ? gradual_rise : step_rise;
}

SoakVerdict evaluate_soak(const SoakRun& run) {
  const Series series(run);
  SoakVerdict verdict;
  verdict.findings.push_back(check_length(run, series.size()));
  if (series.size() >= kMinSamples) {
    verdict.findings.push_back(check_lost(run));
    verdict.findings.push_back(check_rate(series, run.rate_hz));
    verdict.findings.push_back(check_drift(series));
    for (std::size_t i = 0; i < run.processes.size(); ++i) {
      const std::string& name = run.processes[i];
      verdict.findings.push_back(check_memory(series, name, i));
      verdict.findings.push_back(check_count(series, name, "descriptors", series.values_of([&](const SoakSample& sample) {
        return static_cast<double>(sample.processes[i].descriptors);
      })));
      verdict.findings.push_back(check_count(series, name, "threads", series.values_of([&](const SoakSample& sample) {
        return static_cast<double>(sample.processes[i].threads);
      })));
    }
  }
  verdict.is_flat =
      std::all_of(verdict.findings.begin(), verdict.findings.end(), [](const SoakFinding& finding) { return finding.is_flat; });
  return verdict;
}

nlohmann::ordered_json to_json(const SoakRun& run, const SoakVerdict& verdict) {
  nlohmann::ordered_json json = {{"schema", "hapton.soak/1"}, {"seconds_asked", run.seconds}, {"rate_hz", run.rate_hz}};
  const MachineInfo machine = read_machine_info();
  json["machine"] = {{"host", machine.host}, {"cpu", machine.cpu}, {"cpu_count", machine.cpu_count}, {"kernel", machine.kernel}};
  json["flat"] = verdict.is_flat;
  json["findings"] = nlohmann::ordered_json::array();
  for (const SoakFinding& f : verdict.findings) {
    json["findings"].push_back(
        {{"what", f.what}, {"process", f.process}, {"value", f.value}, {"limit", f.limit}, {"flat", f.is_flat}, {"text", f.text}});
  }
  if (run.samples.empty()) return json;
  const SoakSample& last = run.samples.back();
  json["seconds"] = last.seconds;
  json["looks"] = run.samples.size();
  json["counters"] = {{"lost", last.lost}, {"late", last.late}, {"superseded", last.superseded}, {"missed_cycles", last.missed_cycles}};
  json["round_trip_max_us"] = worst_round_trip_us(run);
  json["processes"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < run.processes.size(); ++i) json["processes"].push_back(process_json(run, i));
  return json;
}

std::string to_text(const SoakRun& run, const SoakVerdict& verdict) {
  if (!verdict.is_flat) {
    std::string text = "soak: not flat";
    const char* separator = ": ";
    for (const SoakFinding& finding : verdict.findings) {
      if (finding.is_flat) continue;
      text += separator + finding.text;
      separator = "; ";
    }
    return text;
  }
  const SoakSample& last = run.samples.back();
  std::string text = fmt::format("soak: flat over {:.0f} s: {} late, {} missed cycles, slowest round trip {:.0f} us", last.seconds,
                                 last.late, last.missed_cycles, worst_round_trip_us(run));
  for (const SoakFinding& finding : verdict.findings) {
    const bool is_reported = finding.what == "lost" || finding.what == "rate" || finding.what == "drift" || finding.what == "memory";
    if (is_reported) text += ", " + finding.text;
  }
  return text + "; descriptors and threads constant";
}

}  // namespace hapton
