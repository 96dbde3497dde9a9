#include "tools/loop/zwidth_plot.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <iterator>
#include <map>

#include "tools/gnuplot.h"

namespace hapton {
namespace {

constexpr std::array kColors = {"#0050c8", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c564b", "#7f7f7f"};

struct Curve {
  std::string points;
  bool has_passive = false;
};

bool is_over_delay(const ZWidthGrid& grid) { return grid.delays_ms.size() > 1 || grid.rates_hz.size() == 1; }

// The title of a curve: what all its rows have in common.
std::string title_of(const ZWidthGrid& grid, const ZWidthRow& row) {
  std::string title = row.loop->is_own() ? "own loop" : fmt::format("{}, hand {}", row.loop->device, row.loop->hand);
  title += is_over_delay(grid) ? fmt::format(", {:g} Hz", row.inputs.rate_hz) : fmt::format(", {:g} ms", row.delay_ms);
  if (grid.wall_dampings_ns_per_m.size() > 1) title += fmt::format(", B {:g} Ns/m", row.inputs.wall_damping_ns_per_m);
  if (row.jitter_ms > 0.0) title += fmt::format(", jitter {:g} ms", row.jitter_ms);
  if (row.loss > 0.0) title += fmt::format(", loss {:g} %", 100.0 * row.loss);
  return title;
}

// A logarithmic axis cannot show zero.
std::string on_log_axis(double value) { return value > 0.0 && std::isfinite(value) ? fmt::format("{}", value) : "NaN"; }

}  // namespace

std::string make_zwidth_plot(const ZWidthGrid& grid, const std::vector<ZWidthRow>& rows, const std::string& picture) {
  std::map<std::string, Curve> curves;
  for (const ZWidthRow& row : rows) {
    Curve& curve = curves[title_of(grid, row)];
    const double passive = row.zwidth.passive.least_n_per_m();
    curve.has_passive |= passive > 0.0 && std::isfinite(passive);
    fmt::format_to(std::back_inserter(curve.points), "{} {} {}\n", is_over_delay(grid) ? row.delay_ms : row.inputs.rate_hz,
                   on_log_axis(row.zwidth.stiffness.value), on_log_axis(passive));
  }
  std::string script;
  std::string plots;
  std::size_t index = 0;
  for (const auto& [title, curve] : curves) {
    script += fmt::format("$curve{} << EOD\n{}EOD\n", index, curve.points);
    const char* const color = kColors[index % kColors.size()];
    plots +=
        fmt::format("{}$curve{} using 1:2 with linespoints linewidth 2 pointtype 7 pointsize 0.5 linecolor rgb '{}' title '{}: stable'",
                    plots.empty() ? "" : ", ", index, color, title);
    if (curve.has_passive) {
      plots +=
          fmt::format(", $curve{} using 1:3 with lines linewidth 2 dashtype 2 linecolor rgb '{}' title '{}: passive'", index, color, title);
    }
    ++index;
  }
  script += fmt::format(
      "set terminal pngcairo size 1000,{} font 'sans,12'\nset output '{}'\n"
      "set title 'Largest stable and largest passive stiffness'\n"
      "set xlabel '{}'\nset ylabel 'stiffness, N/m'\nset logscale y\n{}"
      "set grid xtics ytics mytics linetype 1 linecolor rgb '#c8c8c8', linetype 1 linecolor rgb '#ececec'\nset mytics 10\n"
      "set key below left Left reverse samplen 3 maxcols 2\n",
      600 + 12 * curves.size(), picture, is_over_delay(grid) ? "delay from sample to force, ms" : "servo rate, Hz",
      is_over_delay(grid) ? "" : "set logscale x\n");
  return script + "plot " + plots + "\n";
}

Result<std::filesystem::path> draw_zwidth_plot(const std::filesystem::path& picture, const ZWidthGrid& grid,
                                               const std::vector<ZWidthRow>& rows) {
  const std::filesystem::path folder = picture.has_parent_path() ? picture.parent_path() : ".";
  const std::string name = picture.filename().string();
  return draw_with_gnuplot(folder, name, make_zwidth_plot(grid, rows, name + ".part"));
}

}  // namespace hapton
