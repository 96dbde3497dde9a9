#include "tools/loop/zwidth_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "closed_loop/press.h"
#include "closed_loop/random_stability.h"
#include "tools/milliseconds.h"

namespace hapton {
namespace {

constexpr std::string_view kSchema = "hapton.loop.zwidth/2";
constexpr std::string_view kColumns =
    "cell,device,hand,mass_kg,damping_ns_per_m,hand_mass_kg,hand_damping_ns_per_m,hand_stiffness_n_per_m,friction_n,encoder_step_m,"
    "amplifier_hz,modes,rate_hz,delay_ms,jitter_ms,loss,seed,wall_damping_ns_per_m,stable_stiffness_n_per_m,stable_frequency_hz,passive_"
    "stiffness_n_per_m,"
    "viscous_passive_n_per_m,quantised_passive_n_per_m,linear_rule_n_per_m,stable_damping_ns_per_m,passive_damping_ns_per_m,rest_stiffness_"
    "n_per_m,mass_filter_s,stable_mass_kg,mass_frequency_hz,mean_delay_ms";

// FNV-1a hash of all inputs of a grid: it is the same in all parts of one grid.
std::uint64_t fingerprint(const ZWidthGrid& grid) {
  std::uint64_t hash = 0xcbf29ce484222325;
  const auto add = [&](const std::string& text) {
    for (const char c : text + "\n") hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  };
  for (const NamedLoop& loop : grid.loops) {
    const DeviceModel& d = loop.device_model;
    add(fmt::format("{} {} {} {} {} {} {} {}", loop.device, loop.hand, d.mass_kg, d.damping_ns_per_m, d.friction_n, d.encoder_step_m,
                    d.amplifier_hz, d.mode_count));
    for (int i = 0; i < d.mode_count; ++i) {
      const StructuralMode& mode = d.modes[static_cast<std::size_t>(i)];
      add(fmt::format("{} {} {}", mode.mass_kg, mode.stiffness_n_per_m, mode.damping_ns_per_m));
    }
    add(fmt::format("{} {} {}", loop.hand_model.mass_kg, loop.hand_model.damping_ns_per_m, loop.hand_model.stiffness_n_per_m));
  }
  for (const auto* numbers : {&grid.rates_hz, &grid.delays_ms, &grid.jitters_ms, &grid.losses, &grid.wall_dampings_ns_per_m}) {
    add(fmt::format("{}", fmt::join(*numbers, " ")));
  }
  add(fmt::format("{} {} {}", grid.seed, grid.measures_presses, grid.mass_filter_s));
  return hash;
}

std::string csv_number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

nlohmann::ordered_json json_number(double value) { return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(); }

// One direction of the link, with half of the delay: to the force law, or back.
LinkFaults link_of(const ZWidthRow& row, bool is_to_law) {
  const std::int64_t half_ns = ms_to_ns(0.5 * row.delay_ms);
  return {.delay_ns = is_to_law ? half_ns : ms_to_ns(row.delay_ms) - half_ns, .jitter_ns = ms_to_ns(row.jitter_ms), .loss = row.loss};
}

// The simulated time for each stiffness: 20 s, but at least 90 delays.
double simulated_s(const ZWidthRow& row) {
  constexpr double kDelays = 90.0;  // decision 225: with fewer, long delays end before the first forces come back
  return std::max(RandomLoop().seconds, kDelays * 1e-3 * (row.delay_ms + 2.0 * row.jitter_ms));
}

// The search begins at the exact limit, without jitter and loss. A loop that is unstable without them does not become stable with them.
void simulate(ZWidthRow& row) {
  const RandomLoop loop{.device = row.inputs.device,
                        .hand = row.inputs.hand,
                        .period_ns = ms_to_ns(1e3 / row.inputs.rate_hz),
                        .to_law = link_of(row, true),
                        .from_law = link_of(row, false),
                        .wall_damping_ns_per_m = row.inputs.wall_damping_ns_per_m,
                        .seed = row.seed,
                        .seconds = simulated_s(row)};
  ZWidth& zwidth = row.zwidth;
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  zwidth.mass_kg = {kUnknown, 0.0};
  row.mean_delay_s = measure_mean_delay_s(loop);
  if (!std::isfinite(row.mean_delay_s)) {
    // No force came back.
    zwidth.stiffness = zwidth.damping_ns_per_m = {kUnknown, 0.0};
    zwidth.passive = {};
    zwidth.linear_rule_n_per_m = 0.0;
    return;
  }
  if (zwidth.stiffness.value > 0.0)
    zwidth.stiffness = {find_stable_stiffness_by_simulation(loop, std::max(1.0, zwidth.stiffness.value)), 0.0};
  if (zwidth.damping_ns_per_m.value > 0.0)
    zwidth.damping_ns_per_m = {find_stable_damping_by_simulation(loop, zwidth.damping_ns_per_m.value), 0.0};
  ZWidthCase mean = row.inputs;
  mean.delay_s = row.mean_delay_s;
  const PassivityCase passivity = make_passivity_case(mean);
  zwidth.passive = find_passive_stiffness(passivity);
  zwidth.linear_rule_n_per_m =
      linear_rule_n_per_m(mean.device.damping_ns_per_m + mean.hand.damping_ns_per_m, passivity.period_s, mean.delay_s);
}

void measure_rest_stiffness(ZWidthRow& row) {
  constexpr double kMaxStiffness = 1e6;  // N/m: the stiffest wall tried; a free choice
  row.rest_stiffness_n_per_m = find_rest_stiffness({.device = row.inputs.device,
                                                    .hand = row.inputs.hand,
                                                    .period_ns = ms_to_ns(1e3 / row.inputs.rate_hz),
                                                    .to_law = link_of(row, true),
                                                    .from_law = link_of(row, false),
                                                    .wall_damping_ns_per_m = row.inputs.wall_damping_ns_per_m,
                                                    .seed = row.seed},
                                                   kMaxStiffness);
}

// The number of cells that the first line of a CSV file gives. None: the line is not the first line of a grid.
std::optional<std::size_t> read_cell_count(const std::string& first_line) {
  constexpr std::string_view kCells = " cells=";
  const std::size_t at = first_line.find(kCells);
  if (!first_line.starts_with("# ") || first_line.find(".loop.") == std::string::npos || at == std::string::npos) return std::nullopt;
  std::size_t cells = 0;
  const auto [end, error] = std::from_chars(first_line.data() + at + kCells.size(), first_line.data() + first_line.size(), cells);
  return error == std::errc() ? std::optional(cells) : std::nullopt;
}

}  // namespace

ZWidthRow measure_cell(const ZWidthGrid& grid, std::size_t cell) {
  std::size_t remaining_index = cell;
  const auto pick = [&](const auto& list) -> const auto& {
    const auto& value = list[remaining_index % list.size()];
    remaining_index /= list.size();
    return value;
  };
  ZWidthRow row{.cell = cell, .inputs = {}, .zwidth = {}, .rest_stiffness_n_per_m = {}};
  row.inputs.wall_damping_ns_per_m = pick(grid.wall_dampings_ns_per_m);
  row.inputs.mass_filter_s = grid.mass_filter_s;
  row.loss = pick(grid.losses);
  row.jitter_ms = pick(grid.jitters_ms);
  row.seed = grid.seed;
  row.delay_ms = pick(grid.delays_ms);
  row.inputs.delay_s = row.mean_delay_s = 1e-3 * row.delay_ms;
  row.inputs.rate_hz = pick(grid.rates_hz);
  row.loop = &pick(grid.loops);
  row.inputs.device = row.loop->device_model;
  row.inputs.hand = row.loop->hand_model;
  row.zwidth = find_zwidth(row.inputs);
  if (row.is_simulated()) simulate(row);
  if (grid.measures_presses) measure_rest_stiffness(row);
  return row;
}

Result<Shard> read_shard(const std::string& text) {
  Shard shard;
  const char* const end = text.data() + text.size();
  const auto [slash, error] = std::from_chars(text.data(), end, shard.index);
  if (error == std::errc() && slash != end && *slash == '/') {
    const auto [last, second_error] = std::from_chars(slash + 1, end, shard.count);
    if (second_error == std::errc() && last == end && shard.index >= 1 && shard.index <= shard.count) return shard;
  }
  return fail("--shard '{}' is not a part I/N; give I from 1 to N, such as 2/8", text);
}

nlohmann::ordered_json to_json(const ZWidthRow& row) {
  const DeviceModel& device = row.inputs.device;
  const HandModel& hand = row.inputs.hand;
  nlohmann::ordered_json modes = nlohmann::ordered_json::array();
  for (int i = 0; i < device.mode_count; ++i) {
    const StructuralMode& mode = device.modes[static_cast<std::size_t>(i)];
    modes.push_back(
        {{"mass_kg", mode.mass_kg}, {"stiffness_n_per_m", mode.stiffness_n_per_m}, {"damping_ns_per_m", mode.damping_ns_per_m}});
  }
  nlohmann::ordered_json json = {
      {"schema", kSchema},
      {"inputs",
       {{"device", row.loop->device},
        {"hand", row.loop->hand},
        {"device_mass_kg", device.mass_kg},
        {"device_damping_ns_per_m", device.damping_ns_per_m},
        {"device_friction_n", device.friction_n},
        {"encoder_step_m", device.encoder_step_m},
        {"amplifier_hz", device.amplifier_hz},
        {"modes", modes},
        {"hand_mass_kg", hand.mass_kg},
        {"hand_damping_ns_per_m", hand.damping_ns_per_m},
        {"hand_stiffness_n_per_m", hand.stiffness_n_per_m},
        {"rate_hz", row.inputs.rate_hz},
        {"delay_ms", row.delay_ms},
        {"jitter_ms", row.jitter_ms},
        {"loss", row.loss},
        {"seed", row.seed},
        {"wall_damping_ns_per_m", row.inputs.wall_damping_ns_per_m},
        {"mass_filter_s", row.inputs.mass_filter_s}}},
      {"stable_stiffness_n_per_m", json_number(row.zwidth.stiffness.value)},
      {"stable_frequency_hz", row.zwidth.stiffness.frequency_hz},
      {"stable_damping_ns_per_m", json_number(row.zwidth.damping_ns_per_m.value)},
      {"stable_mass_kg", json_number(row.zwidth.mass_kg.value)},
      {"mass_frequency_hz", row.zwidth.mass_kg.frequency_hz},
      {"passive_stiffness_n_per_m", json_number(row.zwidth.passive.least_n_per_m())},
      {"viscous_passive_stiffness_n_per_m", json_number(row.zwidth.passive.viscous_n_per_m)},
      {"quantised_passive_stiffness_n_per_m", json_number(row.zwidth.passive.quantised_n_per_m)},
      {"passive_damping_ns_per_m", row.zwidth.passive_damping_ns_per_m},
      {"linear_rule_n_per_m", row.zwidth.linear_rule_n_per_m},
      {"methods",
       {{"stable", row.is_simulated()
                       ? fmt::format("simulation of {:g} s for each stiffness and damping, with the same draws: motion dies out below, "
                                     "grows above. Virtual mass: not computed with jitter or loss",
                                     simulated_s(row))
                       : "exact: first crossing of the unit circle by the sampled loop, counted up from zero stiffness"},
        {"passive", row.is_simulated()
                        ? "on average over the draws: Colgate and Schenkel 1997, exact with any delay, at mean_delay_ms, which is "
                          "simulated; with encoder steps the smaller of it and 2 friction / step (Abbott and Okamura 2005). Damping: of "
                          "the device, whatever hand holds it"
                        : "Colgate and Schenkel 1997, exact with any delay; with encoder steps the smaller of it and 2 friction / step "
                          "(Abbott and Okamura 2005). Damping: of the device, whatever hand holds it"}}}};
  if (row.is_simulated()) json["mean_delay_ms"] = json_number(1e3 * row.mean_delay_s);
  if (row.rest_stiffness_n_per_m) {
    json["rest_stiffness_n_per_m"] = *row.rest_stiffness_n_per_m;
    json["methods"]["rest"] = "simulated presses: bounded, and a limit cycle of at most two encoder steps or 1 % of the depth";
  }
  return json;
}

std::string csv_header(const ZWidthGrid& grid) {
  return fmt::format("# {} grid={:016x} cells={}\n{}\n", kSchema, fingerprint(grid), grid.cells(), kColumns);
}

std::string csv_line(const ZWidthRow& row) {
  const DeviceModel& d = row.inputs.device;
  const HandModel& h = row.inputs.hand;
  return fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", row.cell,
                     row.loop->device, row.loop->hand, d.mass_kg, d.damping_ns_per_m, h.mass_kg, h.damping_ns_per_m, h.stiffness_n_per_m,
                     d.friction_n, d.encoder_step_m, d.amplifier_hz, d.mode_count, row.inputs.rate_hz, row.delay_ms, row.jitter_ms,
                     row.loss, row.seed, row.inputs.wall_damping_ns_per_m, csv_number(row.zwidth.stiffness.value),
                     row.zwidth.stiffness.frequency_hz, csv_number(row.zwidth.passive.least_n_per_m()),
                     csv_number(row.zwidth.passive.viscous_n_per_m), csv_number(row.zwidth.passive.quantised_n_per_m),
                     row.zwidth.linear_rule_n_per_m, csv_number(row.zwidth.damping_ns_per_m.value), row.zwidth.passive_damping_ns_per_m,
                     row.rest_stiffness_n_per_m ? csv_number(*row.rest_stiffness_n_per_m) : "", row.inputs.mass_filter_s,
                     csv_number(row.zwidth.mass_kg.value), row.zwidth.mass_kg.frequency_hz,
                     csv_number(row.is_simulated() ? 1e3 * row.mean_delay_s : row.delay_ms));
}

Result<std::string> merge_csv(const std::vector<std::filesystem::path>& parts) {
  std::string head;
  std::size_t cells = 0;
  std::map<std::size_t, std::string> rows;  // by cell; a map, because a damaged file may announce any number of cells
  for (const std::filesystem::path& part : parts) {
    std::ifstream stream(part);
    std::string first_line;
    std::string columns;
    if (!std::getline(stream, first_line) || !std::getline(stream, columns)) {
      return fail("{}: cannot be read, or is empty; give files that hapton loop zwidth --csv wrote", part.string());
    }
    const auto part_cells = read_cell_count(first_line);
    if (!part_cells) return fail("{}: line 1: is not a grid of hapton loop; hapton loop zwidth --csv writes one", part.string());
    const std::string part_head = first_line + "\n" + columns + "\n";
    if (head.empty()) {
      head = part_head;
      cells = *part_cells;
    }
    if (part_head != head) return fail("{}: is part of another grid than {}", part.string(), parts.front().string());
    std::string line;
    for (int number = 3; std::getline(stream, line); ++number) {
      std::size_t cell = 0;
      const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), cell);
      if (error != std::errc() || end == line.data() + line.size() || *end != ',' || cell >= cells) {
        return fail("{}: line {}: does not begin with a cell of the grid", part.string(), number);
      }
      if (!rows.emplace(cell, line).second) return fail("{}: line {}: cell {} is a duplicate", part.string(), number, cell);
    }
  }
  std::string merged = head;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const auto row = rows.find(cell);
    if (row == rows.end()) return fail("cell {} of {} is in none of the files; is a file missing?", cell, cells);
    merged += row->second + "\n";
  }
  return merged;
}

}  // namespace hapton
