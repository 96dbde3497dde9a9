#include "tools/latency/latency_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "tools/gnuplot.h"

namespace hapton {
namespace {

constexpr std::string_view kEcho = "bare_echo";
constexpr std::string_view kRoundTrip = "round_trip";

// The most important curves come last, so that they are drawn on top: the bare echo, and above it the round trip.
std::vector<HopCounts> in_drawing_order(std::span<const HopCounts> hops) {
  std::vector<HopCounts> ordered(hops.begin(), hops.end());
  const auto height = [](const HopCounts& hop) { return hop.name == kRoundTrip ? 2 : hop.name == kEcho ? 1 : 0; };
  std::stable_sort(ordered.begin(), ordered.end(), [&](const HopCounts& a, const HopCounts& b) { return height(a) < height(b); });
  return ordered;
}

// The gnuplot line style of one curve.
std::string style_of(const HopCounts& hop, std::size_t index) {
  static constexpr std::array kColours = {"#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c564b", "#7f7f7f"};
  if (hop.name == kRoundTrip) {
    return "linewidth 3.5 dashtype 1 linecolor rgb '#0050c8'";
  }
  if (hop.name == kEcho) {
    return "linewidth 3 dashtype 2 linecolor rgb '#000000'";
  }
  // If there are more curves than colours, the colours repeat with another dash type.
  return fmt::format("linewidth 2 dashtype {} linecolor rgb '{}'", 1 + 2 * (index / kColours.size()), kColours[index % kColours.size()]);
}

std::string title_of(const HopCounts& hop) {
  std::string words = hop.name;
  std::replace(words.begin(), words.end(), '_', ' ');
  const double p99_us = hop.quantile_us(0.99);
  const bool is_long = p99_us >= 1e4;
  const double scale = is_long ? 1e-3 : 1.0;
  return fmt::format("{}  (p50 {:.4g}, p99 {:.4g} {}, n {})", words, scale * hop.quantile_us(0.5), scale * p99_us, is_long ? "ms" : "us",
                     hop.total());
}

// The points of a curve: a duration in us, and the share of the samples above it. All but the first are upper ends of buckets.
std::string data_of(const HopCounts& hop, std::size_t index) {
  std::string text = fmt::format("$hop{} << EOD\n", index);
  const double total = static_cast<double>(hop.total());
  double slower = total;
  fmt::format_to(std::back_inserter(text), "{} 1\n", std::max(1e-3, 1e-3 * static_cast<double>(hop.buckets.front().lower_ns)));
  for (const HopCounts::Bucket& bucket : hop.buckets) {
    const double before = slower;
    slower -= static_cast<double>(bucket.count);
    const double us = 1e-3 * static_cast<double>(bucket.upper_ns);
    // No sample is above the last bucket, and a logarithmic axis cannot show zero: the curve ends at the share of that bucket itself.
    fmt::format_to(std::back_inserter(text), "{} {}\n", us, slower > 0 ? slower / total : before / total);
  }
  return text + "EOD\n";
}

struct Range {
  double low_us;
  double high_us;
  double least_share;
};

// The ranges of the axes: whole decades that contain all curves.
Range find_range(std::span<const HopCounts> hops) {
  double low = 1e12;
  double high = 1e-3;
  std::uint64_t most = 10;
  for (const HopCounts& hop : hops) {
    low = std::min(low, 1e-3 * static_cast<double>(hop.buckets.front().lower_ns));
    high = std::max(high, 1e-3 * static_cast<double>(hop.buckets.back().upper_ns));
    most = std::max(most, hop.total());
  }
  return {std::pow(10.0, std::floor(std::log10(std::max(low, 1e-1)))), std::pow(10.0, std::ceil(std::log10(high))),
          std::pow(10.0, -std::ceil(std::log10(static_cast<double>(most))))};
}

}  // namespace

std::string make_latency_plot(std::span<const HopCounts> unordered, const std::string& picture) {
  const std::vector<HopCounts> hops = in_drawing_order(unordered);
  std::string script;
  for (std::size_t i = 0; i < hops.size(); ++i) {
    script += data_of(hops[i], i);
  }
  const Range range = find_range(hops);
  script += fmt::format(
      "set terminal pngcairo size 1280,{} font 'sans,12'\n"
      "set output '{}'\n"
      "set title 'Latency: how many samples take longer than that'\n"
      "set xlabel 'latency, us' offset 0,0.5\nset ylabel 'share of samples that took longer'\n"
      "set logscale xy\nset xrange [{}:{}]\nset yrange [{}:1]\n"
      "set format x '%g'\nset format y '10^{{%T}}'\nset mytics 10\nset mxtics 10\n"
      "set grid xtics ytics mxtics linetype 1 linecolor rgb '#c8c8c8', linetype 1 linecolor rgb '#ececec'\n"
      "set key below left Left reverse samplen 3 maxcols 2 height 1\n"
      "plot ",
      660 + 12 * hops.size(), picture, range.low_us, range.high_us, range.least_share);
  for (std::size_t i = 0; i < hops.size(); ++i) {
    script += fmt::format("{}$hop{} using 1:2 with lines {} title '{}'", i == 0 ? "" : ", ", i, style_of(hops[i], i), title_of(hops[i]));
  }
  return script + "\n";
}

Result<std::filesystem::path> draw_latency_plot(const std::filesystem::path& folder) {
  const auto hops = read_latency_csv(folder / "latency.csv");
  if (!hops) {
    return tl::unexpected(hops.error());
  }
  return draw_with_gnuplot(folder, "latency.png", make_latency_plot(*hops, "latency.png.part"));
}

}  // namespace hapton
