#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "link/session_reader.h"
#include "recording/recording_entries.h"
#include "tools/commands.h"
#include "tools/session/cycle_files.h"
#include "tools/session/recorded_scenes.h"
#include "tools/session/session_export.h"
#include "tools/session/session_mcap.h"
#include "tools/session/session_replay.h"
#include "tools/session/session_summary.h"

namespace hapton {
namespace {

struct SessionOptions {
  std::string file;
  std::string out;
  std::string scene;
  std::string format = "tables";
  std::vector<std::string> effects;
  std::string method;
};

Result<void> summarize(SessionReader& reader, SessionSummary& summary) {
  return for_each_entry(reader, [&](const SessionEntry& entry, const Datagram* datagram) {
    summary.add(entry, datagram);
    return Result<void>();
  });
}

Result<void> show_info(const SessionOptions& options) {
  auto reader = SessionReader::open(options.file);
  if (!reader) return tl::unexpected(reader.error());
  SessionSummary summary;
  if (const auto done = summarize(*reader, summary); !done) return done;
  fmt::print("{}", summary.to_text(reader->header()));
  return check_end(*reader);
}

bool are_same(const std::vector<ObjectName>& a, const std::vector<ObjectName>& b) {
  return std::ranges::equal(
      a, b, [](const ObjectName& one, const ObjectName& other) { return one.object == other.object && one.material == other.material; });
}

std::vector<ObjectName> leave_out_names(std::string_view why) {
  fmt::print(stderr, "hapton session export: the tables have no names of objects: {}\n", why);
  return {};
}

// The names of the touched objects, if the recorded scene still exists; otherwise their columns stay empty, and one line says why. The
// first scene of each haptics node counts. If two nodes had scenes with different objects, the number of an object means nothing.
Result<std::vector<ObjectName>> find_names(const SessionOptions& options) {
  auto reader = SessionReader::open(options.file);
  if (!reader) return tl::unexpected(reader.error());
  SessionSummary summary;
  if (const auto done = summarize(*reader, summary); !done) return tl::unexpected(done.error());
  RecordedScenes scenes(options.scene);
  std::optional<std::uint64_t> sender;
  std::optional<std::vector<ObjectName>> names;
  for (const auto& [key, setup] : summary.setups()) {
    if (sender == key.first) continue;
    sender = key.first;
    auto found = scenes.find_names(setup);
    if (!found) return leave_out_names(found.error().what);
    if (names && !are_same(*names, *found)) return leave_out_names("haptics nodes of the recording had scenes with other objects");
    names = std::move(*found);
  }
  return names.value_or(std::vector<ObjectName>());
}

// Writes one table in one file: every cycle with its sample, its force and what happened.
Result<void> write_cycles(const SessionOptions& options, SessionReader& reader, const std::vector<ObjectName>& names) {
  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  if (error) return fail("{}: the folder cannot be made: {}", options.out, error.message());
  if (options.format == "mcap") {
    const auto path = std::filesystem::path(options.out) / "session.mcap";
    const auto written = write_mcap(reader, path, names);
    if (!written) return tl::unexpected(written.error());
    fmt::print("{}: {} cycles, {} messages in all\n", path.string(), written->cycles, written->messages);
    return check_end(reader);
  }
  const bool is_hdf5 = options.format == "hdf5";
  const auto path = std::filesystem::path(options.out) / (is_hdf5 ? "session.h5" : "session.csv");
  const auto written = is_hdf5 ? write_joined_hdf5(reader, path, names) : write_cycle_csv(reader, path, names);
  if (!written) return tl::unexpected(written.error());
  fmt::print("{}: {} rows\n", path.string(), written->rows);
  if (written->lost > 0) fmt::print("{} samples in {} gaps are missing in the recording: column `lost`\n", written->lost, written->gaps);
  if (written->rows == 0 && written->without_sample > 0) {
    return fail("{}: an older recording, whose cycles lack the device's samples; --format tables writes what it has", options.file);
  }
  return check_end(reader);
}

Result<void> write_tables(const SessionOptions& options) {
  auto names = find_names(options);
  if (!names) return tl::unexpected(names.error());
  auto reader = SessionReader::open(options.file);
  if (!reader) return tl::unexpected(reader.error());
  if (options.format != "tables") return write_cycles(options, *reader, *names);
  auto tables = SessionExport::open(options.out, reader->header().start_ns, std::move(*names));
  if (!tables) return tl::unexpected(tables.error());
  const auto done = for_each_entry(*reader, [&](const SessionEntry& entry, const Datagram* datagram) {
    tables->add(entry, datagram);
    return Result<void>();
  });
  if (!done) return done;
  if (const auto closed = tables->close(); !closed) return closed;
  fmt::print("{}/trajectory.csv: {} rows, forces.csv: {}, cycles.csv: {}{}\n", options.out, tables->rows().trajectory,
             tables->rows().forces, tables->rows().cycles,
             tables->shapes() > 0 ? fmt::format(", shapes.csv: {}", tables->shapes()) : std::string());
  return check_end(*reader);
}

// local: the number of forces that io_node computed itself.
std::string describe(const ReplayCounts& counts, std::uint64_t local) {
  std::string text = fmt::format("replayed: {} steps, {} in contact; {} compared bit for bit, {} different\n", counts.steps,
                                 counts.contact_steps, counts.compared, counts.different);
  if (counts.lost_replies > 0) text += fmt::format("{} replies were lost: replayed but not compared\n", counts.lost_replies);
  if (counts.not_compared > 0)
    text += fmt::format("{} steps not compared: contact, or an effect, began before the recording\n", counts.not_compared);
  if (counts.unknown_method > 0)
    text += fmt::format("{} steps not compared: the recording does not have their method, view, materials, moves, shapes or carves\n",
                        counts.unknown_method);
  if (local > 0) {
    text += fmt::format("{} forces were computed by io_node, from parts of the scene (--touch): not compared; docs/remote.md\n", local);
  }
  if (counts.missing_states > 0) text += fmt::format("{} replies to states that are not in the recording\n", counts.missing_states);
  if (counts.missing_views > 0)
    text += fmt::format("{} replies with a view that is not in the recording, or has several poses in it\n", counts.missing_views);
  return text;
}

Result<void> load_effects(const SessionOptions& options, PluginEffects& effects) {
  for (const std::string& text : options.effects) {
    const auto choice = parse_plugin_choice(text);
    if (!choice) return tl::unexpected(choice.error());
    if (const auto added = effects.add(*choice); !added) return added;
  }
  return {};
}

Result<void> replay_session(const SessionOptions& options) {
  auto summary_reader = SessionReader::open(options.file);
  if (!summary_reader) return tl::unexpected(summary_reader.error());
  SessionSummary summary;
  if (const auto done = summarize(*summary_reader, summary); !done) return done;

  auto reader = SessionReader::open(options.file);
  if (!reader) return tl::unexpected(reader.error());
  RecordedScenes scenes(options.scene);
  if (!options.method.empty()) {
    const auto choice = parse_plugin_choice(options.method);
    if (!choice) return tl::unexpected(choice.error());
    scenes.use_method_file(*choice);
  }
  SessionReplay comparison(
      summary.setups(), [&](const HapticsSetup& setup) { return scenes.make_touch(setup); }, summary.materials(),
      [&](const HapticsSetup& setup, const MaterialState& state) { return scenes.make_materials(setup, state); });
  comparison.use_moves(summary.moves());
  comparison.use_carves(summary.carves());
  comparison.use_program_shapes([&](const HapticsSetup& setup, std::int32_t object) { return scenes.find_program_shape(setup, object); },
                                summary.first_shapes());
  // How long a call of an effect took in the session is not known. With a simulated clock it may take any time now.
  const SimulatedClock clock;
  PluginEffects effects(clock);
  if (const auto loaded = load_effects(options, effects); !loaded) return loaded;
  if (!effects.empty()) comparison.use_effects(&effects);
  auto done = for_each_entry(*reader, [&](const SessionEntry& entry, const Datagram* datagram) -> Result<void> {
    if (datagram == nullptr) return {};
    if (entry.kind == SessionEntry::Kind::sent) {
      if (const auto* state = std::get_if<DeviceState>(&datagram->message)) comparison.on_state(*state);
      if (const auto* view = std::get_if<ViewTransform>(&datagram->message)) comparison.on_view(*view);
      return {};
    }
    if (const auto* part = std::get_if<ObjectShape>(&datagram->message)) comparison.on_shape(datagram->header.sender, *part);
    if (const auto* start = std::get_if<ShapeStart>(&datagram->message)) comparison.on_shape(datagram->header.sender, *start);
    const auto* force = std::get_if<ForceCommand>(&datagram->message);
    return force != nullptr ? comparison.on_reply(datagram->header.sender, *force) : Result<void>();
  });
  if (done) done = comparison.finish();
  if (!done) return done;
  const ReplayCounts& counts = comparison.counts();
  fmt::print("{}", describe(counts, summary.local_forces()));
  if (counts.different > 0) {
    return fail("{}: {} of {} forces differ, by {:.3g} N at most; first: {}", options.file, counts.different, counts.compared,
                counts.max_difference_n, counts.first_difference);
  }
  if (counts.compared == 0) return fail("{}: holds no force that could be compared", options.file);
  return check_end(*reader);
}

int report(const Result<void>& done, const char* command) {
  if (done) return 0;
  std::fflush(stdout);
  fmt::print(stderr, "hapton session {}: {}\n", command, done.error().what);
  return 1;
}

}  // namespace

void add_session_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<SessionOptions>();
  const CommandLine session = app.add_subcommand("session", "Inspect, export or replay a recorded session (io_node --record)");
  session.require_subcommands(1, 1);

  const CommandLine info = session.add_subcommand("info", "Show its contents: nodes, datagrams, rates, latencies, faults");
  info.add_option("file", options->file, "Recorded session").required();
  info.on_run([options, &exit_code] { exit_code = report(show_info(*options), "info"); });

  const CommandLine tables = session.add_subcommand("export", "Write it as tables (CSV, HDF5) or messages (MCAP)");
  tables.add_option("file", options->file, "Recorded session").required();
  tables.add_option("--scene", options->scene, "Scene file for the objects' names, when it is not where the haptics node had it");
  tables.add_option("--out", options->out, "Folder for the tables").folder_to_write().required();
  tables
      .add_option("--format", options->format,
                  "tables: trajectory.csv, forces.csv and cycles.csv, and shapes.csv where programs deformed objects; csv: all joined by "
                  "sample in session.csv; hdf5: the same in session.h5; mcap: its messages in session.mcap")
      .one_of({"tables", "csv", "hdf5", "mcap"})
      .shows_default();
  tables.on_run([options, &exit_code] { exit_code = report(write_tables(*options), "export"); });

  const CommandLine replay = session.add_subcommand("replay", "Replay it through the haptic step and compare every force bit for bit");
  replay.add_option("file", options->file, "Recorded session").required();
  replay.add_option("--scene", options->scene, "Scene file, when it is not where the haptics node had it");
  replay
      .add_option("--effect", options->effects,
                  "Effect from a shared library, as haptics_node had it: FILE.so:KEY=VALUE,...; may be repeated")
      .again_for_more();
  replay.add_option("--method", options->method, "Method from a shared library, as haptics_node had it: FILE.so:KEY=VALUE,...");
  replay.on_run([options, &exit_code] { exit_code = report(replay_session(*options), "replay"); });
}

}  // namespace hapton
