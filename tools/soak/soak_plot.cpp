#include "tools/soak/soak_plot.h"

#include <fmt/core.h>

#include <algorithm>

#include "tools/gnuplot.h"

namespace hapton {
namespace {

// A panel shows columns of soak.csv against the time in minutes; this is one of the columns.
struct Curve {
  std::string column;
  std::string title;
};

std::string panel(const std::string& label, const std::vector<Curve>& curves) {
  std::string text = fmt::format("set ylabel '{}'\nplot ", label);
  for (std::size_t i = 0; i < curves.size(); ++i) {
    text += fmt::format("{}'soak.csv' using (column('t_s')/60):{} with lines linewidth 2 title '{}'", i == 0 ? "" : ", ", curves[i].column,
                        curves[i].title);
  }
  return text + "\n";
}

// gnuplot reads _ as markup.
std::string in_words(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

std::vector<Curve> curves_of(const std::vector<std::string>& processes, const std::vector<std::pair<std::string, std::string>>& figures) {
  std::vector<Curve> curves;
  for (const std::string& process : processes) {
    for (const auto& [column, title] : figures) {
      curves.push_back({fmt::format("(column('{}_{}'))", process, column), in_words(process) + title});
    }
  }
  return curves;
}

}  // namespace

std::string soak_csv_header(const std::vector<std::string>& processes) {
  std::string text =
      "t_s,samples_hz,forces_hz,contacts_hz,drawn_hz,lost,late,superseded,missed_cycles,round_trip_p50_us,round_trip_p99_us,"
      "round_trip_max_us,drift_ms";
  for (const std::string& process : processes) text += fmt::format(",{0}_resident_kib,{0}_descriptors,{0}_threads", process);
  return text + "\n";
}

std::string soak_csv_row(const SoakSample& sample) {
  std::string text =
      fmt::format("{:.3f},{:.2f},{:.2f},{:.2f},{:.2f},{},{},{},{},{:.2f},{:.2f},{:.2f},{:.3f}", sample.seconds, sample.samples_hz,
                  sample.forces_hz, sample.contacts_hz, sample.drawn_hz, sample.lost, sample.late, sample.superseded, sample.missed_cycles,
                  sample.round_trip_p50_us, sample.round_trip_p99_us, sample.round_trip_max_us, sample.drift_ms);
  for (const ProcessStats& process : sample.processes) {
    text += fmt::format(",{},{},{}", process.resident_kib, process.descriptors, process.threads);
  }
  return text + "\n";
}

std::string make_soak_plot(const std::vector<std::string>& processes, const std::string& picture) {
  std::string script = fmt::format(
      "set terminal pngcairo size 1280,1400 font 'sans,12'\nset output '{}'\n"
      "set datafile separator ','\nset grid\nset key outside right top\nset yrange [0:*]\n"
      "set lmargin 12\nset rmargin 34\nset multiplot layout 4,1\n",
      picture);
  script += panel("resident memory, MiB", [&] {
    auto curves = curves_of(processes, {{"resident_kib", ""}});
    for (Curve& curve : curves) curve.column = fmt::format("({}/1024)", curve.column);
    return curves;
  }());
  script += panel("count", curves_of(processes, {{"descriptors", ", descriptors"}, {"threads", ", threads"}}));
  script += "set logscale y\nset yrange [*:*]\n";
  script +=
      panel("round trip, us",
            {{"(column('round_trip_max_us'))", "max"}, {"(column('round_trip_p99_us'))", "p99"}, {"(column('round_trip_p50_us'))", "p50"}});
  script += "unset logscale y\nset xlabel 'minutes'\n";
  script += panel("ticks ahead of the clock, ms", {{"(column('drift_ms'))", "drift"}});
  return script + "unset multiplot\n";
}

Result<std::filesystem::path> draw_soak_plot(const std::filesystem::path& folder, const std::vector<std::string>& processes) {
  return draw_with_gnuplot(folder, "soak.png", make_soak_plot(processes, "soak.png.part"));
}

}  // namespace hapton
