#include "tools/relay/relay_script.h"

#define TOML_EXCEPTIONS 0
#include <external/toml.h>

#include <cmath>
#include <vector>

#include "core/base/similar_word.h"
#include "runtime/regular_file.h"
#include "runtime/toml_reader.h"

namespace hapton {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 20;  // a larger file is not a script; a free choice
// One table of the script; the first error is kept and the rest is skipped.
class FaultTable {
 public:
  FaultTable(const toml::table& table, const std::string& file) : table_(table), file_(file) {}

  const std::optional<Error>& error() const { return error_; }

  void reject_all_but(const std::vector<std::string_view>& known) {
    for (const auto& [key, node] : table_) {
      if (std::find(known.begin(), known.end(), key.str()) == known.end()) {
        set_error(node, fmt::format("unknown key '{}'{}", key.str(), similar_word_hint(key.str(), known)));
      }
    }
  }

  void read(std::string_view key, double& value) {
    const toml::node* node = table_.get(key);
    if (node == nullptr) return;
    const auto number = node->value<double>();
    if (!node->is_number() || !number || !std::isfinite(*number)) return set_error(*node, fmt::format("'{}' must be a number", key));
    value = *number;
  }

  void read_ms(std::string_view key, std::int64_t& time_ns) {
    double ms = 1e-6 * static_cast<double>(time_ns);
    read(key, ms);
    // The range is larger than what check_faults accepts, so an error still shows, but small enough for a whole number of ns.
    time_ns = std::llround(1e6 * std::clamp(ms, -1.0, 1e6));
  }

  void read(std::string_view key, bool& value) {
    const toml::node* node = table_.get(key);
    if (node == nullptr) return;
    if (!node->is_boolean()) return set_error(*node, fmt::format("'{}' must be true or false", key));
    value = node->as_boolean()->get();
  }

  void read(std::string_view key, std::string& value) {
    const toml::node* node = table_.get(key);
    if (node == nullptr) return;
    if (!node->is_string()) return set_error(*node, fmt::format("'{}' must be a text in quotes", key));
    value = node->as_string()->get();
  }

  void read(std::string_view key, std::optional<std::uint64_t>& value) {
    const toml::node* node = table_.get(key);
    if (node == nullptr) return;
    if (!node->is_integer() || node->as_integer()->get() < 0) return set_error(*node, fmt::format("'{}' must be a whole number", key));
    value = static_cast<std::uint64_t>(node->as_integer()->get());
  }

  void read_faults(LinkFaults& faults) {
    read_ms("delay_ms", faults.delay_ns);
    read_ms("jitter_ms", faults.jitter_ns);
    read("loss", faults.loss);
    read("burst_share", faults.burst_share);
    read("burst_length", faults.burst_length);
    read("burst_loss", faults.burst_loss);
    read("reorder", faults.reorder);
    read_ms("reorder_ms", faults.reorder_by_ns);
    read("duplicate", faults.duplicate);
    read("corrupt", faults.corrupt);
    read("partition", faults.partition);
    if (const auto checked = check_faults(faults); !checked) set_error(table_, checked.error().what);
  }

  // Reads the table of one direction within this table; values whose keys are missing stay as they are.
  void read_direction(std::string_view key, LinkFaults& faults);

  void set_error(const toml::node& node, const std::string& what) {
    if (!error_) error_ = Error{fmt::format("{}:{}: {}", file_, node.source().begin.line, what)};
  }

 private:
  const toml::table& table_;
  const std::string& file_;
  std::optional<Error> error_;
};

const std::vector<std::string_view> kFaultKeys = {"delay_ms", "jitter_ms",  "loss",      "burst_share", "burst_length", "burst_loss",
                                                  "reorder",  "reorder_ms", "duplicate", "corrupt",     "partition"};

std::vector<std::string_view> phase_keys() {
  std::vector<std::string_view> keys = kFaultKeys;
  keys.insert(keys.end(), {"name", "seconds", "to_hub", "to_nodes"});
  return keys;
}

void FaultTable::read_direction(std::string_view key, LinkFaults& faults) {
  const toml::node* node = table_.get(key);
  if (node == nullptr) return;
  if (!node->is_table()) return set_error(*node, fmt::format("'{}' must be a table: [phase.{}]", key, key));
  FaultTable direction_table(*node->as_table(), file_);
  direction_table.reject_all_but(kFaultKeys);
  direction_table.read_faults(faults);
  if (direction_table.error() && !error_) error_ = direction_table.error();
}

Result<FaultPhase> read_phase(const toml::table& table, const std::string& file, std::size_t number) {
  FaultPhase phase;
  phase.name = fmt::format("{}", number);
  FaultTable reader(table, file);
  reader.reject_all_but(phase_keys());
  reader.read("name", phase.name);
  double seconds = 0.0;
  reader.read("seconds", seconds);
  if (!(seconds > 0.0 && seconds <= 1e6))
    reader.set_error(table, fmt::format("phase '{}' needs seconds between 0 and 1000000", phase.name));
  phase.duration_ns = std::max<std::int64_t>(1, std::llround(1e9 * std::clamp(seconds, 0.0, 1e6)));
  reader.read_faults(phase.to_hub);
  phase.to_nodes = phase.to_hub;
  reader.read_direction("to_hub", phase.to_hub);
  reader.read_direction("to_nodes", phase.to_nodes);
  if (reader.error()) return tl::unexpected(*reader.error());
  return phase;
}

}  // namespace

Result<RelayScript> parse_relay_script(std::string_view text, const std::string& name) {
  const toml::parse_result parsed = toml::parse(text, name);
  if (!parsed) {
    return fail("{}:{}: {}", name, parsed.error().source().begin.line, explain_toml_error(parsed.error().description()));
  }
  RelayScript script;
  FaultTable top(parsed.table(), name);
  top.reject_all_but({"seed", "repeat", "phase"});
  top.read("seed", script.seed);
  top.read("repeat", script.schedule.repeat);
  if (top.error()) return tl::unexpected(*top.error());
  const toml::array* phases = parsed.table().get_as<toml::array>("phase");
  if (phases == nullptr || phases->empty()) {
    return fail("{}: has no [[phase]]; give at least one, with seconds and faults", name);
  }
  for (const toml::node& node : *phases) {
    if (!node.is_table()) return fail("{}:{}: a phase is a table: [[phase]]", name, node.source().begin.line);
    auto phase = read_phase(*node.as_table(), name, script.schedule.phases.size() + 1);
    if (!phase) return tl::unexpected(phase.error());
    script.schedule.phases.push_back(std::move(*phase));
  }
  return script;
}

Result<RelayScript> read_relay_script(const std::filesystem::path& path) {
  const auto text = read_regular_file(path, "--script wants a TOML file", kMaxBytes);
  if (!text) return tl::unexpected(text.error());
  return parse_relay_script(*text, path.string());
}

}  // namespace hapton
