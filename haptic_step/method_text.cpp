#include "haptic_step/method_text.h"

#include <fmt/core.h>

#include <array>
#include <locale>
#include <sstream>
#include <utility>

#include "core/collision/grid_division.h"

namespace hapton {
namespace {

constexpr std::string_view kToolName = "name=tool";

// Visits every setting except the name, for writing and for reading.
template <class S, class Visit>
void for_each_setting(S& s, Visit&& visit) {
  visit("grid_division", s.grid_division);
  visit("offset_m", s.offset_m);
  visit("set_size", s.set_size);
  visit("smooth_radius_m", s.smooth_radius_m);
  visit("smooth_layer", s.smooth_layer);
  visit("hull_directions", s.hull_directions);
  visit("crease_deg", s.crease_deg);
  visit("simplify_m", s.simplify_m);
  visit("build_on_approach", s.build_on_approach);
  visit("shading", s.shading);
  visit("probe_radius_m", s.probe_radius_m);
  visit("coupling_n_per_m", s.coupling_n_per_m);
  visit("reference_substeps", s.reference_substeps);
  visit("reference_substep_limit", s.reference_substep_limit);
}

std::string write(const std::array<int, 3>& value) { return fmt::format("{}x{}x{}", value[0], value[1], value[2]); }
std::string write(double value) { return fmt::format("{}", value); }
std::string write(int value) { return fmt::format("{}", value); }
std::string write(bool value) { return value ? "1" : "0"; }

// Splits "NAME=VALUE"; without '=' the value is empty.
std::pair<std::string, std::string> split(const std::string& word) {
  const std::size_t equals = word.find('=');
  return {word.substr(0, equals), equals == std::string::npos ? "" : word.substr(equals + 1)};
}

template <class T>
bool read(const std::string& text, T& value) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  return (stream >> value) && stream.peek() == std::istringstream::traits_type::eof();
}

bool read(const std::string& text, std::array<int, 3>& value) {
  const auto division = parse_grid_division(text);
  if (division) value = *division;
  return division.has_value();
}

}  // namespace

std::string to_text(const MethodSettings& settings) {
  std::string text = "name=" + settings.name;
  const MethodSettings defaults;
  std::string default_words;
  for_each_setting(defaults, [&](const char* name, const auto& value) { default_words += fmt::format(" {}={}\n", name, write(value)); });
  for_each_setting(settings, [&](const char* name, const auto& value) {
    const std::string word = fmt::format(" {}={}", name, write(value));
    if (default_words.find(word + "\n") == std::string::npos) text += word;
  });
  return text;
}

Result<MethodSettings> parse_method_text(std::string_view text) {
  MethodSettings settings;
  std::istringstream words{std::string(text)};
  for (std::string word; words >> word;) {
    const auto [name, value] = split(word);
    const auto is_read = [&name = name, &value = value](const char* known, auto& into) { return name == known && read(value, into); };
    bool is_understood = name == "effects" || name == "cut";  // notes of a haptics node on plug-ins, which are no settings
    if (name == "name") {
      settings.name = value;
      is_understood = !value.empty();
    }
    for_each_setting(settings, [&](const char* known, auto& into) { is_understood = is_understood || is_read(known, into); });
    if (!is_understood) return fail("method settings: '{}' is not understood; was it recorded by another build?", word);
  }
  return settings;
}

std::string to_text(const ToolCoupling& coupling, std::size_t tool_triangles, double voxel_m) {
  return fmt::format("{} stiffness_n_per_m={} rotational_stiffness_nm_per_rad={} tool_triangles={}{}", kToolName,
                     coupling.stiffness_n_per_m, coupling.rotational_stiffness_nm_per_rad, tool_triangles,
                     voxel_m > 0.0 ? fmt::format(" voxel_m={}", voxel_m) : "");
}

std::optional<ToolCoupling> parse_tool_text(std::string_view text) {
  std::istringstream words{std::string(text)};
  std::string word;
  if (!(words >> word) || word != kToolName) return std::nullopt;
  ToolCoupling coupling;
  while (words >> word) {
    const auto [name, value] = split(word);
    const bool is_stiffness = name == "stiffness_n_per_m";
    const bool is_rotational = name == "rotational_stiffness_nm_per_rad";
    if ((is_stiffness && !read(value, coupling.stiffness_n_per_m)) ||
        (is_rotational && !read(value, coupling.rotational_stiffness_nm_per_rad))) {
      return std::nullopt;
    }
  }
  const bool is_valid = coupling.stiffness_n_per_m >= 0.0 && coupling.rotational_stiffness_nm_per_rad >= 0.0;
  return is_valid ? std::optional(coupling) : std::nullopt;
}

std::string_view effects_in(std::string_view method_text) {
  constexpr std::string_view kKey = " effects=";
  const std::size_t begin = method_text.find(kKey);
  if (begin == std::string_view::npos) return {};
  method_text.remove_prefix(begin + kKey.size());
  // A message pads its text with NULs.
  return method_text.substr(0, method_text.find_first_of(std::string_view(" \0", 2)));
}

}  // namespace hapton
