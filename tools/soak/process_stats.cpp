#include "tools/soak/process_stats.h"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <system_error>

namespace hapton {
namespace {

// The number after "NAME:" in a file with lines of that form; -1 if no line begins with this name.
std::int64_t read_number(const std::filesystem::path& file, const std::string& name) {
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(name + ":")) continue;
    std::int64_t number = -1;
    std::istringstream(line.substr(name.size() + 1)) >> number;
    return number;
  }
  return -1;
}

int count_entries(const std::filesystem::path& folder) {
  std::error_code error;
  int count = 0;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) ++count;
  return error ? -1 : count;
}

}  // namespace

Result<ProcessStats> read_process_stats(pid_t pid) {
  const std::filesystem::path folder = "/proc/" + std::to_string(pid);
  ProcessStats stats;
  stats.resident_kib = read_number(folder / "status", "VmRSS");
  stats.threads = static_cast<int>(read_number(folder / "status", "Threads"));
  stats.descriptors = count_entries(folder / "fd");
  if (stats.resident_kib < 0 || stats.threads < 0) return fail("{}: the process has ended", folder.string());
  if (stats.descriptors < 0) return fail("{}: its descriptors cannot be counted; run as the user whose process it is", folder.string());
  return stats;
}

}  // namespace hapton
