#include "tools/bench/remote_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string_view>

#include "tools/gnuplot.h"

namespace hapton {
namespace {

// One figure of a run, with its name in the CSV and the JSON.
struct Figure {
  std::string_view name;
  std::function<double(const RemoteRow&)> value_of;
};

const std::vector<Figure>& figures() {
  static const std::vector<Figure> all = {
      {"force_error_rms", [](const RemoteRow& r) { return r.touch.force.error_rms; }},
      {"force_error_max_n", [](const RemoteRow& r) { return r.touch.force.error_max_n; }},
      {"direction_error_rms_deg", [](const RemoteRow& r) { return r.touch.force.direction_rms_deg; }},
      {"direction_error_max_deg", [](const RemoteRow& r) { return r.touch.force.direction_max_deg; }},
      {"time_offset_ms", [](const RemoteRow& r) { return 1e3 * r.touch.force.time_offset_s; }},
      {"value_offset", [](const RemoteRow& r) { return r.touch.force.value_offset; }},
      {"falls", [](const RemoteRow& r) { return static_cast<double>(r.touch.force.falls); }},
      {"fall_s", [](const RemoteRow& r) { return r.touch.force.fall_s; }},
      {"contact_s", [](const RemoteRow& r) { return r.touch.force.contact_s; }},
      {"generated_mj", [](const RemoteRow& r) { return 1e3 * r.touch.force.generated_j; }},
      {"zero_delay_generated_mj", [](const RemoteRow& r) { return 1e3 * r.touch.force.zero_delay_generated_j; }},
      {"loop_bounded", [](const RemoteRow& r) { return r.loop.is_bounded ? 1.0 : 0.0; }},
      {"loop_generated_mj", [](const RemoteRow& r) { return 1e3 * r.loop.generated_j; }},
      {"loop_limit_cycle_mm", [](const RemoteRow& r) { return 1e3 * r.loop.limit_cycle_m; }},
      {"loop_path_error_mm", [](const RemoteRow& r) { return 1e3 * r.loop.path_error_m; }},
      {"loop_most_force_n", [](const RemoteRow& r) { return r.loop.most_force_n; }},
      {"packets_up_per_s", [](const RemoteRow& r) { return r.touch.rates.packets_up; }},
      {"packets_down_per_s", [](const RemoteRow& r) { return r.touch.rates.packets_down; }},
      {"bytes_up_per_s", [](const RemoteRow& r) { return r.touch.rates.bytes_up; }},
      {"bytes_down_per_s", [](const RemoteRow& r) { return r.touch.rates.bytes_down; }},
      {"scene_kb", [](const RemoteRow& r) { return r.touch.scene_kb; }},
      {"ready_s", [](const RemoteRow& r) { return r.touch.ready_s; }},
  };
  return all;
}

double figure_of(const RemoteRow& row, std::string_view name) {
  const auto found = std::find_if(figures().begin(), figures().end(), [&](const Figure& figure) { return figure.name == name; });
  return found->value_of(row);
}

struct Spread {
  double median = 0.0;
  double worst = 0.0;
};

// The rows of all meshes and seeds for one method, speed, round trip and loss.
struct Cell {
  const RemoteMethod* method = nullptr;
  double speed_m_per_s = 0.0;
  double round_trip_s = 0.0;
  double loss = 0.0;
  std::vector<const RemoteRow*> rows;

  Spread spread(std::string_view figure) const {
    std::vector<double> values;
    for (const RemoteRow* row : rows) values.push_back(figure_of(*row, figure));
    if (values.empty()) return {};
    std::sort(values.begin(), values.end());
    return {values[(values.size() - 1) / 2], values.back()};
  }
};

Cell cell_of(const RemoteResults& results, const RemoteMethod* method, double speed_m_per_s, double round_trip_s, double loss) {
  Cell cell{method, speed_m_per_s, round_trip_s, loss, {}};
  for (const RemoteRow& row : results.rows) {
    if (row.method == method && row.speed_m_per_s == speed_m_per_s && row.round_trip_s == round_trip_s && row.loss == loss)
      cell.rows.push_back(&row);
  }
  return cell;
}

std::string line_of(const Cell& cell) {
  const auto median_and_worst = [&](std::string_view figure, double scale, int digits) {
    const Spread spread = cell.spread(figure);
    return fmt::format("{:.{}f} {:.{}f}", scale * spread.median, digits, scale * spread.worst, digits);
  };
  return fmt::format(
      "{:16}{:>7g}{:>20}{:>16}{:>14}{:>13}{:>16}{:>8}{:>19}{:>19}{:>11}{:>13}\n", cell.method->name, 1e3 * cell.round_trip_s,
      median_and_worst("force_error_rms", 100.0, 4), median_and_worst("force_error_max_n", 1.0, 3),
      median_and_worst("direction_error_rms_deg", 1.0, 2), median_and_worst("time_offset_ms", 1.0, 0),
      median_and_worst("value_offset", 100.0, 2), median_and_worst("falls", 1.0, 0), median_and_worst("generated_mj", 1.0, 2),
      median_and_worst("loop_generated_mj", 1.0, 2),
      fmt::format("{:.0f} {:.0f}", cell.spread("packets_up_per_s").worst, cell.spread("packets_down_per_s").worst),
      fmt::format("{:.1f} {:.1f}", 1e-3 * cell.spread("bytes_up_per_s").worst, 1e-3 * cell.spread("bytes_down_per_s").worst));
}

std::string header_line() {
  return fmt::format("{:16}{:>7}{:>20}{:>16}{:>14}{:>13}{:>16}{:>8}{:>19}{:>19}{:>11}{:>13}\n", "method", "ms", "error RMS %", "max N",
                     "direction", "late ms", "value %", "falls", "given mJ", "in the loop mJ", "packets/s", "kB/s");
}

std::string walls_text(const RemoteGrid& grid, const RemoteResults& results) {
  std::string text = "\nLargest stiffness of a wall at which a press comes to rest, N/m\n";
  text += fmt::format("{:16}{:>7}", "method", "loss %");
  for (const double round_trip_s : grid.round_trips_s) text += fmt::format("{:>10}", fmt::format("{:g} ms", 1e3 * round_trip_s));
  text += '\n';
  const auto line = [&](std::string_view name, const std::string& loss, const auto& value_at) {
    text += fmt::format("{:16}{:>7}", name, loss);
    for (const double round_trip_s : grid.round_trips_s) text += fmt::format("{:>10}", value_at(round_trip_s));
    text += '\n';
  };
  const auto find_wall = [&](const RemoteMethod* method, double round_trip_s, double loss) {
    return std::find_if(results.walls.begin(), results.walls.end(), [&](const RemoteWall& wall) {
      return wall.method == method && wall.round_trip_s == round_trip_s && wall.loss == loss;
    });
  };
  line("theory, held", "0", [&](double round_trip_s) {
    return fmt::format("{:.0f}", find_wall(grid.methods.front(), round_trip_s, grid.losses.front())->stable_n_per_m);
  });
  for (const RemoteMethod* method : grid.methods) {
    for (const double loss : grid.losses) {
      line(method->name, fmt::format("{:g}", 100.0 * loss), [&](double round_trip_s) {
        const double rest = find_wall(method, round_trip_s, loss)->rest_stiffness_n_per_m;
        if (!(rest > 0.0)) return std::string("none");
        return rest >= kMaxWallNPerM ? fmt::format("> {:.0f}", kMaxWallNPerM) : fmt::format("{:.0f}", rest);
      });
    }
  }
  return text;
}

}  // namespace

std::string to_text(const RemoteGrid& grid, const RemoteResults& results) {
  std::string text = fmt::format(
      "{} meshes, {} seeds from {}; {:g} N/m; {}; jitter {:g} ms; stalls of {:g} ms. Two figures in a column: median and worst over meshes "
      "and seeds; packets and bytes: worst, up and down.\n",
      grid.meshes.size(), grid.seeds, grid.seed, grid.stiffness_n_per_m, grid.device_name, 1e3 * grid.jitter_s, 1e3 * grid.stall_s);
  for (const double speed : grid.speeds_m_per_s) {
    for (const double loss : grid.losses) {
      text += fmt::format("\n{:g} mm/s, loss {:g} % each way\n{}", 1e3 * speed, 100.0 * loss, header_line());
      for (const RemoteMethod* method : grid.methods) {
        for (const double round_trip_s : grid.round_trips_s) text += line_of(cell_of(results, method, speed, round_trip_s, loss));
      }
    }
  }
  return results.walls.empty() ? text : text + walls_text(grid, results);
}

std::string key_columns() { return "method,mesh,seed,speed_mm_per_s,round_trip_ms,loss"; }

std::string to_csv(const RemoteKey& key) {
  return fmt::format("{},{},{},{:g},{:g},{:g}", key.method->name, key.mesh, key.seed, 1e3 * key.speed_m_per_s, 1e3 * key.round_trip_s,
                     key.loss);
}

nlohmann::ordered_json to_json(const RemoteKey& key) {
  return {{"method", key.method->name},
          {"mesh", key.mesh},
          {"seed", key.seed},
          {"speed_mm_per_s", 1e3 * key.speed_m_per_s},
          {"round_trip_ms", 1e3 * key.round_trip_s},
          {"loss", key.loss}};
}

std::string to_csv(const RemoteResults& results) {
  std::string csv = key_columns();
  for (const Figure& figure : figures()) csv += fmt::format(",{}", figure.name);
  csv += '\n';
  for (const RemoteRow& row : results.rows) {
    csv += to_csv(row);
    for (const Figure& figure : figures()) fmt::format_to(std::back_inserter(csv), ",{:.6g}", figure.value_of(row));
    csv += '\n';
  }
  return csv;
}

std::string walls_to_csv(const RemoteResults& results) {
  std::string csv = "method,round_trip_ms,loss,rest_stiffness_n_per_m,stable_stiffness_n_per_m\n";
  for (const RemoteWall& wall : results.walls) {
    fmt::format_to(std::back_inserter(csv), "{},{:g},{:g},{:.6g},{:.6g}\n", wall.method->name, 1e3 * wall.round_trip_s, wall.loss,
                   wall.rest_stiffness_n_per_m, wall.stable_n_per_m);
  }
  return csv;
}

std::string to_json(const RemoteGrid& grid, const RemoteResults& results) {
  using Json = nlohmann::ordered_json;
  Json json = {{"schema", "hapton.bench.remote/1"},
               {"seed", grid.seed},
               {"seeds", grid.seeds},
               {"stiffness_n_per_m", grid.stiffness_n_per_m},
               {"device", grid.device_name},
               {"jitter_ms", 1e3 * grid.jitter_s},
               {"stall_ms", 1e3 * grid.stall_s},
               {"deadband", grid.settings.deadband}};
  json["runs"] = Json::array();
  for (const RemoteRow& row : results.rows) {
    Json run = to_json(row);
    for (const Figure& figure : figures()) run[std::string(figure.name)] = figure.value_of(row);
    json["runs"].push_back(std::move(run));
  }
  json["walls"] = Json::array();
  for (const RemoteWall& wall : results.walls) {
    json["walls"].push_back({{"method", wall.method->name},
                             {"round_trip_ms", 1e3 * wall.round_trip_s},
                             {"loss", wall.loss},
                             {"rest_stiffness_n_per_m", wall.rest_stiffness_n_per_m},
                             {"stable_stiffness_n_per_m", wall.stable_n_per_m}});
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

namespace {

constexpr std::array kMethodColours = {"#000000", "#7f7f7f", "#d55e00", "#e69f00", "#cc79a7", "#56b4e9", "#0072b2", "#009e73", "#8c564b"};
constexpr double kMinDrawnPercent = 1e-4;  // a smaller value is drawn at this value, in %
constexpr double kMinShownMs = 1.0;        // a round trip of 0 is drawn at this value, since the axis is logarithmic
constexpr double kMinDrawnNPerM = 1.0;     // stands for no stiffness, for the same reason

// One data block of gnuplot, with a line "round trip, value" for each round trip.
template <class Value>
std::string block_of(const RemoteGrid& grid, const std::string& name, Value value_at) {
  std::string block = fmt::format("${} << EOD\n", name);
  for (const double round_trip_s : grid.round_trips_s)
    fmt::format_to(std::back_inserter(block), "{} {}\n", std::max(1e3 * round_trip_s, kMinShownMs), value_at(round_trip_s));
  return block + "EOD\n";
}

std::string panel_of(const RemoteGrid& grid, const std::string& title, const std::string& y_label, const std::string& prefix) {
  std::string plot;
  for (std::size_t i = 0; i < grid.methods.size(); ++i) {
    plot += fmt::format("{}${}{} using 1:2 with linespoints linewidth 2 pointtype {} linecolor rgb '{}' title '{}'",
                        i == 0 ? "plot " : ", ", prefix, i, 4 + i, kMethodColours[i % kMethodColours.size()], grid.methods[i]->name);
  }
  return fmt::format("set title '{}'\nset ylabel '{}'\n{}\n", title, y_label, plot);
}

}  // namespace

std::string make_remote_plot(const RemoteGrid& grid, const RemoteResults& results, const std::string& picture) {
  const double speed = *std::min_element(grid.speeds_m_per_s.begin(), grid.speeds_m_per_s.end());
  const bool has_usual_loss = std::find(grid.losses.begin(), grid.losses.end(), 0.1) != grid.losses.end();
  const double loss = has_usual_loss ? 0.1 : grid.losses.front();
  const bool has_walls = !results.walls.empty();
  std::string script = fmt::format(
      "set terminal pngcairo size {},600 font 'sans,12'\nset output '{}'\nset multiplot layout 1,{}\nset logscale xy\n"
      "set xlabel 'round trip, ms (0 is drawn at {:g})'\nset xrange [{:g}:*]\n"
      "set grid xtics ytics linetype 1 linecolor rgb '#dddddd'\nset key below left Left reverse samplen 3 maxcols 3\n",
      has_walls ? 1300 : 700, picture, has_walls ? 2 : 1, kMinShownMs, 0.8 * kMinShownMs);
  for (std::size_t i = 0; i < grid.methods.size(); ++i) {
    script += block_of(grid, fmt::format("e{}", i), [&](double round_trip_s) {
      return std::max(100.0 * cell_of(results, grid.methods[i], speed, round_trip_s, loss).spread("force_error_rms").worst,
                      kMinDrawnPercent);
    });
    if (!has_walls) continue;
    script += block_of(grid, fmt::format("w{}", i), [&](double round_trip_s) {
      for (const RemoteWall& wall : results.walls) {
        if (wall.method == grid.methods[i] && wall.round_trip_s == round_trip_s && wall.loss == loss)
          return std::max(wall.rest_stiffness_n_per_m, kMinDrawnNPerM);
      }
      return kMinDrawnNPerM;
    });
  }
  script += panel_of(
      grid, fmt::format("Force error, {:g} N/m, {:g} mm/s, loss {:g} %, worst mesh", grid.stiffness_n_per_m, 1e3 * speed, 100.0 * loss),
      fmt::format("RMS, % ({:g} and less drawn there)", kMinDrawnPercent), "e");
  if (has_walls) script += panel_of(grid, "Largest stiffness at which a press comes to rest", "N/m", "w");
  return script + "unset multiplot\n";
}

Result<std::filesystem::path> draw_remote_plot(const std::filesystem::path& picture, const RemoteGrid& grid, const RemoteResults& results) {
  const std::filesystem::path folder = picture.has_parent_path() ? picture.parent_path() : ".";
  const std::string name = picture.filename().string();
  return draw_with_gnuplot(folder, name, make_remote_plot(grid, results, name + ".part"));
}

}  // namespace hapton
