// Runs the list of attacks and faults (attack_list.h) against an io_node with a simulated device. Measures how long a force stays on the
// motors. For deploy/attack.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/attack/attack_list.h"

namespace {

using namespace hapton::attack;

std::string text_of(double value) { return value < 0.0 ? "-" : fmt::format("{:.1f}", value); }

void print(const Row& row) {
  fmt::print("{:<58} {:>8} {:>8} {:>6} {:>6}  {:<8} {}\n", row.name, text_of(row.after_sample_ms), text_of(row.after_event_ms),
             text_of(row.bound_ms), text_of(row.blind_ms),
             row.is_skipped  ? "skipped"
             : row.is_broken ? "BROKEN"
             : row.is_over   ? "over"
                             : "held",
             row.note);
  std::fflush(stdout);
}

nlohmann::json json_of(const Row& row) {
  return {{"name", row.name},
          {"after_sample_ms", row.after_sample_ms},
          {"after_event_ms", row.after_event_ms},
          {"bound_ms", row.bound_ms},
          {"blind_ms", row.blind_ms},
          {"skipped", row.is_skipped},
          {"over", row.is_over},
          {"broken", row.is_broken},
          {"note", row.note}};
}

// Prints, in one line, the row of one kind whose force was released last.
void print_worst(const std::vector<Row>& rows, Kind kind, std::string_view what, double bound_ms) {
  const Row* worst = nullptr;
  for (const Row& row : rows) {
    if (row.kind == kind && !row.is_skipped && (worst == nullptr || row.release_ms() > worst->release_ms())) worst = &row;
  }
  if (worst == nullptr) return;
  fmt::print("worst release, {}: {:.1f} ms (bound {:.0f} ms): {}\n", what, worst->release_ms(), bound_ms, worst->name);
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  std::string json_file;
  CLI::App app{
      "Runs the list of attacks and faults against io_node and measures how long a force stays on the simulated motors. Exit code 0: every "
      "bound held; 1: one was broken; 77: this user may not look into other processes.",
      "hapton_attack"};
  app.add_option("--repeat", settings.repeat, "Times each fault is made")->check(CLI::Range(1, 1000))->take_last()->capture_default_str();
  app.add_option("--flood-seconds", settings.flood_s, "Length of each flood")
      ->check(CLI::Range(0.5, 1e5))
      ->take_last()
      ->capture_default_str();
  app.add_option("--only", settings.only, "Only faults whose name contains this");
  app.add_option("--touch", settings.touch,
                 "Where forces are computed, as io_node --touch; with patch each row begins once patches are in use")
      ->check(CLI::IsMember({"remote", "auto", "patch"}))
      ->capture_default_str();
  app.add_option("--slack-ms", settings.slack_ms,
                 "For a machine that is not idle: a bound exceeded by less than this is reported but is not a failure")
      ->check(CLI::Range(0.0, 1e5))
      ->capture_default_str();
  app.add_option("--give-up-seconds", settings.give_up_s,
                 "On a machine that stood still meanwhile: faults not begun after this time are skipped")
      ->check(CLI::Range(1.0, 1e9));
  app.add_option("--json", json_file, "File for the table");
  CLI11_PARSE(app, argc, argv);
  fmt::print("{:<58} {:>8} {:>8} {:>6} {:>6}\n", "all times in ms", "sample", "event", "bound", "blind");
  const std::vector<Row> rows = run_list(settings, print);
  print_worst(rows, Kind::inside, "io_node running (from the sample that the force replies to)", kInsideMs);
  print_worst(rows, Kind::outside, "io_node frozen or killed (from the event)", kOutsideMs);
  print_worst(rows, Kind::alone, "patches felt without the haptics node (from the event)", kAloneMs);
  if (!json_file.empty()) {
    nlohmann::json table = nlohmann::json::array();
    for (const Row& row : rows) table.push_back(json_of(row));
    std::ofstream(json_file) << table.dump(2) << "\n";
  }
  const bool has_any = std::any_of(rows.begin(), rows.end(), [](const Row& row) { return !row.is_skipped; });
  if (!has_any) return 77;
  return std::any_of(rows.begin(), rows.end(), [](const Row& row) { return row.is_broken; }) ? 1 : 0;
}
