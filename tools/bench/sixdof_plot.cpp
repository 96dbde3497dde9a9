#include "tools/bench/sixdof_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "tools/gnuplot.h"

namespace hapton {
namespace {

// Colour and mark of each method: enough for eight methods, no two of which may look alike.
constexpr std::array kColours = {"#0050c8", "#e69f00", "#d55e00", "#cc79a7", "#009e73", "#7f7f7f", "#56b4e9", "#000000"};
constexpr std::array kMarks = {7, 9, 11, 5, 13, 15, 4, 6};
// The time axis begins here: methods that compute only the force of a sample take less than a microsecond.
constexpr double kMinUs = 0.1;
// The smallest error that is drawn, as the axis is logarithmic.
constexpr double kMinPercent = 1e-4;

std::vector<SixdofRow> drawable_rows(const std::vector<SixdofRow>& rows) {
  std::vector<SixdofRow> kept;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(kept),
               [](const SixdofRow& row) { return row.has_errors && row.contact.count > 0; });
  return kept;
}

std::vector<std::string> distinct_values(const std::vector<SixdofRow>& rows, std::string SixdofRow::*field) {
  std::vector<std::string> found;
  for (const SixdofRow& row : rows) {
    if (std::find(found.begin(), found.end(), row.*field) == found.end()) found.push_back(row.*field);
  }
  return found;
}

}  // namespace

std::string make_sixdof_plot(const std::vector<SixdofRow>& rows, const std::string& picture) {
  const std::vector<SixdofRow> shown_rows = drawable_rows(rows);
  const std::vector<std::string> scenarios = distinct_values(shown_rows, &SixdofRow::name);
  const std::vector<std::string> methods = distinct_values(shown_rows, &SixdofRow::method);
  const std::size_t columns = std::min<std::size_t>(3, scenarios.size());
  const std::size_t panel_rows = (scenarios.size() + columns - 1) / std::max<std::size_t>(columns, 1);
  std::string script = fmt::format(
      "set terminal pngcairo size {},{} font 'sans,10'\nset output '{}'\n"
      "set multiplot layout {},{} title 'Rigid tool: time of a step against force error'\n"
      "set xlabel 'step in contact, p50, us' offset 0,0.6\nset ylabel 'force error, RMS, %'\nset logscale xy\n"
      "set xrange [{:g}:1e5]\nset yrange [{:g}:1e4]\nset format x '10^{{%T}}'\nset format y '10^{{%T}}'\n"
      "set grid linetype 1 linecolor rgb '#dddddd'\nset key below samplen 1 height 1\nset bmargin 8\n",
      480 * columns, 440 * panel_rows, picture, panel_rows, columns, kMinUs, 0.1 * kMinPercent);
  for (const std::string& scenario : scenarios) {
    script += fmt::format("set title '{}'\nplot ", scenario);
    std::string data;
    for (std::size_t m = 0; m < methods.size(); ++m) {
      script += fmt::format("{}'-' using 1:2 with points pointtype {} pointsize 1.6 linecolor rgb '{}' title '{}'", m > 0 ? ", " : "",
                            kMarks[m % kMarks.size()], kColours[m % kColours.size()], methods[m]);
      for (const SixdofRow& row : shown_rows) {
        if (row.name != scenario || row.method != methods[m]) continue;
        fmt::format_to(std::back_inserter(data), "{:.6g} {:.6g}\n", std::max(1e-3 * row.contact.p50_ns, kMinUs),
                       std::max(row.force_error_percent, kMinPercent));
      }
      data += "e\n";
    }
    script += "\n" + data;
  }
  return script + "unset multiplot\n";
}

Result<std::filesystem::path> draw_sixdof_plot(const std::filesystem::path& folder, const std::vector<SixdofRow>& rows) {
  if (drawable_rows(rows).empty())
    return fail("{}: no contact was measured in a scenario with a known force, so there is nothing to draw",
                (folder / "sixdof.png").string());
  return draw_with_gnuplot(folder, "sixdof.png", make_sixdof_plot(rows, "sixdof.png.part"));
}

}  // namespace hapton
