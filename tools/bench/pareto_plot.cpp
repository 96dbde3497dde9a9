#include "tools/bench/pareto_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <string_view>
#include <system_error>

#include "bench/measure/pareto_front.h"
#include "tools/gnuplot.h"

namespace hapton {
namespace {

constexpr int kPanelWidth = 640;  // pixels; this and kPanelHeight are free choices
constexpr int kPanelHeight = 620;
// Approximate sizes, in pixels, of the axes, of a letter and a line of a label in font 8, and of a mark.
constexpr double kAxesWidth = 540.0;
constexpr double kAxesHeight = 430.0;
constexpr double kLetterWidth = 8.0;
constexpr double kLineHeight = 12.0;
constexpr double kMarkSize = 12.0;

struct Style {
  std::string_view family;
  int mark;
  std::string_view colour;
};
constexpr std::array kStyles = {
    Style{"proxy point", 7, "#0050c8"},      Style{"proxy sphere", 5, "#56b4e9"},  Style{"sweep", 9, "#d55e00"},
    Style{"smooth", 13, "#009e73"},          Style{"smooth layer", 12, "#cc79a7"}, Style{"reference", 2, "#000000"},
    Style{"reference sphere", 1, "#7f7f7f"},
};

// Removes _ and similar characters, which gnuplot reads as markup.
std::string without_markup(std::string text) {
  std::replace(text.begin(), text.end(), '_', ' ');
  std::erase_if(text, [](char c) { return c == '\'' || c == '{' || c == '}' || c == '^' || c == '@' || c == '\\'; });
  return text;
}

std::vector<std::string> names_of(const std::vector<ParetoMark>& marks) {
  std::vector<std::string> names;
  for (const ParetoMark& mark : marks) {
    if (std::find(names.begin(), names.end(), mark.mesh) == names.end()) names.push_back(mark.mesh);
  }
  return names;
}

struct Range {
  double low, high;
  double decades() const { return std::log10(high / low); }
};

struct Axes {
  Range time, error;  // microseconds, percent
};

// Whole decades that hold all marks, with room for a factor of room_below under them and of room_above over them.
template <class Value>
Range range_of(const std::vector<ParetoMark>& marks, double room_below, double room_above, Value&& value_of) {
  double low = 1e300;
  double high = 1e-300;
  for (const ParetoMark& mark : marks) {
    low = std::min(low, value_of(mark));
    high = std::max(high, value_of(mark));
  }
  return {std::pow(10.0, std::floor(std::log10(low / room_below))), std::pow(10.0, std::ceil(std::log10(high * room_above)))};
}

// Places the labels of one panel above or below their marks, each in the first line where it touches no mark and no other label.
class LabelPlaces {
 public:
  LabelPlaces(const Axes& axes, const std::vector<ParetoMark>& marks) : axes_(axes) {
    for (const ParetoMark& mark : marks) used_boxes_.push_back({x_px(mark), y_px(mark), kMarkSize, kMarkSize});
  }

  // Returns the height of the label's middle on the error axis, in percent.
  double place(const ParetoMark& mark, bool above) {
    const double step = above ? 1.0 : -1.0;
    Box box{x_px(mark), y_px(mark) + step * kLineHeight, kLetterWidth * static_cast<double>(mark.label.size()), kLineHeight};
    while (std::any_of(used_boxes_.begin(), used_boxes_.end(), [&](const Box& other) { return box.touches(other); })) box.y_px += step;
    used_boxes_.push_back(box);
    return axes_.error.low * std::pow(10.0, box.y_px / kAxesHeight * axes_.error.decades());
  }

 private:
  struct Box {
    double x_px, y_px, width, height;
    bool touches(const Box& o) const {
      return std::fabs(x_px - o.x_px) < 0.5 * (width + o.width) && std::fabs(y_px - o.y_px) < 0.5 * (height + o.height);
    }
  };

  double x_px(const ParetoMark& mark) const { return kAxesWidth * std::log10(mark.time_us / axes_.time.low) / axes_.time.decades(); }
  double y_px(const ParetoMark& mark) const {
    return kAxesHeight * std::log10(100.0 * mark.error / axes_.error.low) / axes_.error.decades();
  }

  const Axes& axes_;
  std::vector<Box> used_boxes_;
};

std::string data_of(const std::vector<ParetoMark>& marks, std::string_view family, const std::string& block, LabelPlaces& places) {
  std::vector<ParetoMark> sorted;
  std::copy_if(marks.begin(), marks.end(), std::back_inserter(sorted), [&](const ParetoMark& mark) { return mark.family == family; });
  std::stable_sort(sorted.begin(), sorted.end(), [](const ParetoMark& a, const ParetoMark& b) { return a.time_us < b.time_us; });
  std::string text = fmt::format("${} << EOD\n", block);
  for (const ParetoMark& mark : sorted) {
    const double label_percent = mark.label.empty() ? 100.0 * mark.error : places.place(mark, family == "sweep");
    fmt::format_to(std::back_inserter(text), "{} {} \"{}\" {:.6g}\n", mark.time_us, 100.0 * mark.error, without_markup(mark.label),
                   label_percent);
  }
  return text + "EOD\n";
}

std::string front_of(const std::vector<ParetoMark>& marks, const std::string& block) {
  std::vector<ParetoPoint> points;
  for (const ParetoMark& mark : marks) {
    if (mark.is_point) points.push_back({mark.time_us, mark.error});
  }
  std::string text = fmt::format("${} << EOD\n", block);
  for (const std::size_t i : find_pareto_front(points))
    fmt::format_to(std::back_inserter(text), "{} {}\n", points[i].time, 100.0 * points[i].error);
  return text + "EOD\n";
}

// The line at kMinShownError, at which marks with a smaller error are drawn.
std::string floor_of(const Range& error) {
  const double floor = 100.0 * kMinShownError;
  if (error.low > floor) return {};
  return fmt::format(
      "set label 'drawn here: {0:g} %, or less' at graph 0.02, first {0:g} offset 0,-0.8 font ',8' textcolor rgb '#7f7f7f'\n"
      "set arrow from graph 0, first {0:g} to graph 1, first {0:g} nohead dashtype 3 linecolor rgb '#7f7f7f'\n",
      floor);
}

std::string panel_of(const std::vector<ParetoMark>& marks, const std::string& mesh, std::size_t number, const Axes& axes) {
  std::vector<ParetoMark> panel_marks;
  for (const ParetoMark& mark : marks) {
    if (mark.mesh == mesh) panel_marks.push_back(mark);
  }
  LabelPlaces places(axes, panel_marks);
  const std::string front = fmt::format("front{}", number);
  std::string text = front_of(panel_marks, front);
  std::string plot = fmt::format(
      "set title '{}'\nplot ${} using 1:2 with lines linewidth 2 dashtype 2 linecolor rgb '#7f7f7f' title 'Pareto front, point probes'",
      without_markup(mesh), front);
  for (std::size_t i = 0; i < kStyles.size(); ++i) {
    const Style& style = kStyles[i];
    if (std::none_of(panel_marks.begin(), panel_marks.end(), [&](const ParetoMark& mark) { return mark.family == style.family; })) continue;
    const std::string block = fmt::format("m{}f{}", number, i);
    text += data_of(panel_marks, style.family, block, places);
    plot += fmt::format(
        ", ${0} using 1:2 with points pointtype {1} pointsize 1.6 linecolor rgb '{2}' title '{3}', ${0} using 1:4:3 with labels font "
        "',8' textcolor rgb '{2}' notitle",
        block, style.mark, style.colour, style.family);
  }
  return text + plot + "\n";
}

}  // namespace

std::string make_pareto_plot(const std::vector<ParetoMark>& marks, const std::string& picture) {
  const std::vector<std::string> meshes = names_of(marks);
  const std::size_t columns = std::min<std::size_t>(3, meshes.size());
  const std::size_t rows = (meshes.size() + columns - 1) / columns;
  const Axes axes{range_of(marks, 1.1, 1.1, [](const ParetoMark& m) { return m.time_us; }),
                  range_of(marks, 3.0, 20.0, [](const ParetoMark& m) { return 100.0 * m.error; })};
  std::string script = fmt::format(
      "set terminal pngcairo size {},{} font 'sans,10'\n"
      "set output '{}'\n"
      "set multiplot layout {},{} title \"Contact step: time against force error\\n"
      "sweep: cells along an axis; smooth, smooth layer (the FDH paper at full strength): triangles in the set, or d: directions of its "
      "hulls\"\n"
      "set xlabel 'contact step, p99, us'\nset ylabel 'force error, RMS, %'\n"
      "set logscale xy\nset xrange [{}:{}]\nset yrange [{}:{}]\n"
      "set format x '10^{{%T}}'\nset format y '10^{{%T}}'\n"
      "set grid linetype 1 linecolor rgb '#dddddd'\nset key below samplen 2\nset bmargin 8\n",
      kPanelWidth * columns, kPanelHeight * rows, picture, rows, columns, axes.time.low, axes.time.high, axes.error.low, axes.error.high);
  script += floor_of(axes.error);
  for (std::size_t i = 0; i < meshes.size(); ++i) script += panel_of(marks, meshes[i], i, axes);
  return script + "unset multiplot\n";
}

Result<std::filesystem::path> draw_pareto_plot(const std::filesystem::path& folder, const std::vector<ParetoMark>& marks) {
  if (marks.empty()) return fail("{}: no contact was measured, so there is nothing to draw", (folder / "pareto.png").string());
  return draw_with_gnuplot(folder, "pareto.png", make_pareto_plot(marks, "pareto.png.part"));
}

}  // namespace hapton
