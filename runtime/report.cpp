#include "runtime/report.h"

#include <sys/utsname.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "runtime/atomic_file.h"

namespace hapton {
namespace {

constexpr double kNanosecondsPerMicrosecond = 1e3;

std::string read_cpu_name() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) {
      return line.substr(colon + 2);
    }
  }
  return "unknown";
}

std::string describe_build() {
#ifdef NDEBUG
  std::string build = "release";
#else
  std::string build = "debug";
#endif
#ifdef __AVX512F__
  build += " AVX-512";
#endif
#ifdef __AVX2__
  build += " AVX2";
#endif
#ifdef __FMA__
  build += " FMA";
#endif
  return build;
}

std::string describe_compiler() {
#if defined(__clang__)
  return "clang " __clang_version__;
#elif defined(__GNUC__)
  return "g++ " __VERSION__;
#else
  return "unknown";
#endif
}

double in_us(double duration_ns) { return duration_ns / kNanosecondsPerMicrosecond; }

nlohmann::ordered_json hop_json(const LatencyHistogram& histogram) {
  return {{"n", histogram.count()},
          {"p50_us", in_us(histogram.quantile_ns(0.5))},
          {"p90_us", in_us(histogram.quantile_ns(0.9))},
          {"p99_us", in_us(histogram.quantile_ns(0.99))},
          {"p99_9_us", in_us(histogram.quantile_ns(0.999))},
          {"max_us", in_us(static_cast<double>(histogram.max_ns()))},
          {"mean_us", in_us(histogram.mean_ns())}};
}

nlohmann::ordered_json node_json(const ReportNode& node) {
  return {{"role", node.role},           {"address", node.address}, {"seconds", node.seconds},
          {"received", node.received},   {"lost", node.lost},       {"reordered", node.reordered},
          {"duplicate", node.duplicate}, {"sent", node.sent},       {"send_failures", node.send_failures}};
}

}  // namespace

MachineInfo read_machine_info() {
  MachineInfo machine;
  utsname system = {};
  if (uname(&system) == 0) {
    machine.host = system.nodename;
    machine.kernel = fmt::format("{} {}", system.sysname, system.release);
  }
  machine.cpu = read_cpu_name();
  machine.cpu_count = static_cast<int>(std::thread::hardware_concurrency());
  machine.compiler = describe_compiler();
  machine.build = describe_build();
  return machine;
}

std::string to_json(const LatencyReport& report) {
  nlohmann::ordered_json json;
  json["schema"] = kReportSchema;
  json["program"] = report.program;
  json["machine"] = {{"host", report.machine.host},     {"cpu", report.machine.cpu},           {"cpu_count", report.machine.cpu_count},
                     {"kernel", report.machine.kernel}, {"compiler", report.machine.compiler}, {"build", report.machine.build}};
  json["seconds"] = report.seconds;
  json["rates_hz"] = report.rates_hz;
  json["counters"] = report.counters;
  json["ratios"] = report.ratios;
  json["notes"] = report.notes;
  json["nodes"] = nlohmann::ordered_json::array();
  for (const ReportNode& node : report.nodes) {
    json["nodes"].push_back(node_json(node));
  }
  json["hops"] = nlohmann::ordered_json::object();
  for (const LatencyHop& hop : report.hops) {
    json["hops"][hop.name] = hop_json(hop.histogram);
  }
  // Names and notes may come from files and devices: bytes that are not UTF-8 are replaced; otherwise dump() would throw.
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string to_csv(const LatencyReport& report) {
  std::string csv = "hop,lower_ns,upper_ns,count\n";
  for (const LatencyHop& hop : report.hops) {
    hop.histogram.for_each_bucket([&](std::int64_t lower_ns, std::int64_t upper_ns, std::uint64_t count) {
      csv += fmt::format("{},{},{},{}\n", hop.name, lower_ns, upper_ns, count);
    });
  }
  return csv;
}

Result<void> write_report(const LatencyReport& report, const std::filesystem::path& folder) {
  if (Result<void> written = write_file_atomically(folder / "report.json", to_json(report)); !written) {
    return written;
  }
  return write_file_atomically(folder / "latency.csv", to_csv(report));
}

}  // namespace hapton
