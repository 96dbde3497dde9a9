#include "tools/doctor/cpu_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

namespace hapton::doctor {
namespace {

constexpr std::string_view kCpuFolder = "/sys/devices/system/cpu";

// The number of CPUs in a list such as "0-3,5".
int count_cpus(std::string_view list) {
  int count = 0;
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(','), list.size());
    const std::string range(list.substr(0, end));
    const std::size_t dash = range.find('-');
    count += dash == range.npos ? 1 : std::atoi(range.c_str() + dash + 1) - std::atoi(range.c_str()) + 1;
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  return count;
}

Finding check_number(const Machine& machine) {
  const std::string online = machine.read(fmt::format("{}/online", kCpuFolder)).value_or("");
  const int count = count_cpus(online);
  const std::string isolated = machine.read(fmt::format("{}/isolated", kCpuFolder)).value_or("");
  if (online.empty()) return note("CPUs", "not known: the kernel does not say");
  if (count < 2) {
    return warning("CPUs", "one: the loop and every other program delay each other",
                   "give the machine a second CPU, or run vision_node on another host");
  }
  if (isolated.empty()) return good("CPUs", fmt::format("{}; none is isolated, io_node --cpu N pins the loop to one", count));
  return good("CPUs",
              fmt::format("{}, of which {} are isolated for real time: io_node --cpu {}", count, isolated, std::atoi(isolated.c_str())));
}

// The governors in use, each with one of the CPUs that use it.
std::map<std::string, std::string> find_governors(const Machine& machine) {
  std::map<std::string, std::string> governors;
  for (const std::string& cpu : machine.list(kCpuFolder)) {
    const auto governor = machine.read(fmt::format("{}/{}/cpufreq/scaling_governor", kCpuFolder, cpu));
    if (governor) governors.emplace(*governor, cpu);
  }
  return governors;
}

Finding check_governor(const Machine& machine) {
  constexpr const char* kRemedy = "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor";
  const std::string subject = "CPU frequency";
  const auto governors = find_governors(machine);
  if (governors.empty()) return good(subject, "not controlled by this kernel (a virtual machine, or a fixed frequency)");
  const std::string driver = machine.read(fmt::format("{}/cpu0/cpufreq/scaling_driver", kCpuFolder)).value_or("");
  // With these drivers, the governor "powersave" does raise the frequency, though late.
  const bool is_adaptive_driver = driver.find("pstate") != driver.npos;
  // If several governors are in use, the slowest one is reported.
  auto slow_governor = governors.find("powersave");
  if (slow_governor == governors.end()) {
    slow_governor = std::find_if(governors.begin(), governors.end(), [](const auto& governor) { return governor.first != "performance"; });
  }
  if (slow_governor == governors.end()) return good(subject, "governor performance");
  const auto& [governor, cpu] = *slow_governor;
  const std::string observation = fmt::format("governor {} ({}, {})", governor, cpu, driver.empty() ? "driver not known" : driver);
  if (governor == "powersave" && !is_adaptive_driver)
    return problem(subject, observation + ": the CPU stays at its lowest frequency", kRemedy);
  return warning(subject, observation + ": the frequency rises only after the work is there", kRemedy);
}

void check_hypervisor(const Machine& machine, Findings& findings) {
  const std::string cpu = machine.read("/proc/cpuinfo").value_or("");
  const auto flags = split_words(find_field(cpu, "flags"));
  if (std::find(flags.begin(), flags.end(), "hypervisor") == flags.end()) return;
  findings.push_back(warning("virtual machine",
                             "a hypervisor shares out the CPUs: it may stop the loop for milliseconds, whatever is granted here",
                             "run io_node on the bare machine that the device is plugged into"));
}

}  // namespace

Findings check_cpus(const Machine& machine) {
  Findings findings = {check_number(machine), check_governor(machine)};
  check_hypervisor(machine, findings);
  return findings;
}

Findings check_clock(const Machine& machine) {
  constexpr const char* kFolder = "/sys/devices/system/clocksource/clocksource0";
  // The clocks that are read without a system call.
  constexpr std::array<std::string_view, 4> kFast = {"tsc", "kvm-clock", "hyperv_clocksource_tsc_page", "arch_sys_counter"};
  const auto current = machine.read(fmt::format("{}/current_clocksource", kFolder));
  if (!current) return {note("clock", "not known: the kernel does not say")};
  if (std::find(kFast.begin(), kFast.end(), *current) != kFast.end()) return {good("clock", *current)};
  const std::string available = machine.read(fmt::format("{}/available_clocksource", kFolder)).value_or("");
  const auto words = split_words(available);
  const bool has_tsc = std::find(words.begin(), words.end(), "tsc") != words.end();
  return {problem(
      "clock", fmt::format("{}: every reading takes a microsecond or more, and the loop reads it ten times a cycle", *current),
      has_tsc ? fmt::format("echo tsc | sudo tee {}/current_clocksource", kFolder)
              : "boot with the kernel parameter tsc=reliable, if the firmware does not stop the TSC; see: sudo dmesg | grep -i tsc")};
}

Findings check_kernel(const Machine& machine) {
  const std::string version = machine.read("/proc/version").value_or("");
  const std::string release = version.empty() ? "" : std::string(split_words(version).size() > 2 ? split_words(version)[2] : "");
  if (version.empty()) return {note("kernel", "not known: no /proc/version")};
  if (machine.read("/sys/kernel/realtime") == "1" || version.find("PREEMPT_RT") != version.npos)
    return {good("kernel", fmt::format("{}, PREEMPT_RT", release))};
  if (version.find("PREEMPT") != version.npos)
    return {good("kernel", fmt::format("{}, preemptible; linux-image-rt-amd64 has still shorter worst cases", release))};
  return {warning("kernel", fmt::format("{} is not preemptible: its own work may hold the loop up for milliseconds", release),
                  "sudo apt-get install linux-image-rt-amd64 && sudo reboot")};
}

}  // namespace hapton::doctor
