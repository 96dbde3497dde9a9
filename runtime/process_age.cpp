#include "runtime/process_age.h"

#include <ctime>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

#include <unistd.h>

namespace hapton {
namespace {

// Words between the program's name and the time of its start.
constexpr int kWordsBefore = 19;

}  // namespace

std::optional<double> read_process_age_s(const std::string& stat_file) {
  std::ifstream file(stat_file);
  const std::string stat{std::istreambuf_iterator<char>(file), {}};
  // The program's name stands in brackets, and may itself contain brackets.
  const auto after_name = stat.rfind(')');
  if (after_name == std::string::npos) return std::nullopt;
  std::istringstream words(stat.substr(after_name + 1));
  std::string skipped;
  for (int i = 0; i < kWordsBefore; ++i) words >> skipped;
  double start_ticks = 0.0;
  std::timespec now = {};
  if (!(words >> start_ticks) || clock_gettime(CLOCK_BOOTTIME, &now) != 0) return std::nullopt;
  const double now_s = static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  return now_s - start_ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
}

}  // namespace hapton
