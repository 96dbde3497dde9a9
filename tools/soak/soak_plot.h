#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "tools/soak/soak_verdict.h"

namespace hapton {

// The header of soak.csv, and a sample as a row of it: t_s, rates, counts, round trip, drift, then NAME_resident_kib, NAME_descriptors and
// NAME_threads of each process. RT: no.
std::string soak_csv_header(const std::vector<std::string>& processes);
std::string soak_csv_row(const SoakSample& sample);

// The gnuplot script that draws soak.csv: memory, descriptors and threads, round trip, drift, each over time.
std::string make_soak_plot(const std::vector<std::string>& processes, const std::string& picture);

// Draws folder/soak.png from folder/soak.csv. Error: as for draw_with_gnuplot.
Result<std::filesystem::path> draw_soak_plot(const std::filesystem::path& folder, const std::vector<std::string>& processes);

}  // namespace hapton
