#include "scene/probe_reader.h"

#include <algorithm>
#include <utility>

#include "core/force/force_method.h"
#include "scene/probe_tables.h"
#include "scene/text_cursor.h"

namespace hapton {
namespace {

constexpr double kLargestRadiusM = 1.0;
constexpr std::size_t kLongestProbeName = 60;

Result<ProbeSpec> read_probe(const toml::table& table, const std::string& where) {
  ProbeSpec probe;
  probe.line = table.source().begin.line;
  TableReader reader(table, where);
  reader.allow({"name", "radius_m", "method", "shading"});
  reader.require("name");
  reader.read_name("name", probe.name);
  if (!reader.error() && (probe.name.empty() || probe.name.size() > kLongestProbeName)) {
    reader.fail_at("name", "'name' in {} has {} bytes: give 1 to {}", where, probe.name.size(), kLongestProbeName);
  }
  if (reader.has("radius_m")) reader.read("radius_m", probe.radius_m.emplace(0.0), 0.0, kLargestRadiusM);
  if (reader.has("shading")) reader.read("shading", probe.shading.emplace(0.0), 0.0, 1.0);
  if (reader.has("method")) {
    reader.read("method", probe.method.emplace());
    if (!reader.error() && !is_method_name(*probe.method)) {
      reader.fail_at("method", "'method' in {} is '{}': choose one of {}", where, printable(*probe.method), method_names());
    }
  }
  if (reader.error()) return tl::unexpected(*reader.error());
  return probe;
}

}  // namespace

Result<std::vector<ProbeSpec>> read_probes(const toml::table& scene) {
  std::vector<ProbeSpec> probes;
  const toml::node* node = scene.get("probe");
  if (node == nullptr) return probes;
  const toml::array* tables = node->as_array();
  if (tables == nullptr || !tables->is_array_of_tables()) {
    return fail("{}'probe' must be tables that begin with [[probe]]", line_prefix(*node));
  }
  for (const toml::node& table : *tables) {
    auto probe = read_probe(*table.as_table(), fmt::format("[[probe]] {}", probes.size() + 1));
    if (!probe) return tl::unexpected(probe.error());
    if (std::any_of(probes.begin(), probes.end(), [&](const ProbeSpec& one) { return one.name == probe->name; })) {
      return fail("{}there are two probes named '{}': give each its own name", line_prefix(table), printable(probe->name));
    }
    probes.push_back(std::move(*probe));
  }
  return probes;
}

Result<const ProbeSpec*> find_probe(const std::vector<ProbeSpec>& probes, std::string_view name) {
  if (name.empty()) return probes.empty() ? nullptr : &probes.front();
  const auto found = std::find_if(probes.begin(), probes.end(), [&](const ProbeSpec& one) { return one.name == name; });
  if (found != probes.end()) return &*found;
  std::vector<std::string_view> known;
  for (const ProbeSpec& probe : probes) known.emplace_back(probe.name);
  return fail("there is no [[probe]] named '{}'{}", printable(name), known.empty() ? ": add it" : similar_word_hint(name, known));
}

std::string describe(const ProbeSpec& probe) {
  std::string text = fmt::format("probe '{}'", printable(probe.name));
  const char* before = ": ";
  const auto add = [&](const std::string& what) { text += std::exchange(before, ", ") + what; };
  if (probe.radius_m) add(*probe.radius_m > 0.0 ? fmt::format("radius {:g} m", *probe.radius_m) : std::string("a point"));
  if (probe.method) add("method " + *probe.method);
  if (probe.shading) add(fmt::format("shading {:g}", *probe.shading));
  return text;
}

}  // namespace hapton
