#pragma once

#include <fmt/core.h>

#include <filesystem>
#include <string>

#include "core/base/result.h"
#include "runtime/atomic_file.h"
#include "runtime/clock.h"
#include "tools/bench/bench_meshes.h"

namespace hapton {

// Measures, with progress on stderr, prints the report's text and writes the report to FOLDER/NAME.txt, .csv and .json. With an empty
// folder no files are written; a folder that cannot be written to is an error before anything is measured. measure(progress) returns a
// report that to_text, to_csv and to_json accept. RT: no.
template <class Measure>
Result<void> measure_and_report(const std::string& folder, const std::string& name, Measure&& measure) {
  if (!folder.empty()) {
    if (auto writable = ensure_writable_folder(folder); !writable) return writable;
  }
  const SteadyClock clock;
  const std::int64_t start_ns = clock.now_ns();
  const auto report =
      measure([&](const std::string& what) { print_progress(1e-9 * static_cast<double>(clock.now_ns() - start_ns), what); });
  if (!report) return tl::unexpected(report.error());
  fmt::print("{}", to_text(*report));
  if (folder.empty()) return {};
  const std::filesystem::path file = std::filesystem::path(folder) / name;
  if (auto written = write_file_atomically(file.string() + ".csv", to_csv(*report)); !written) return written;
  if (auto written = write_file_atomically(file.string() + ".txt", to_text(*report)); !written) return written;
  return write_file_atomically(file.string() + ".json", to_json(*report));
}

}  // namespace hapton
