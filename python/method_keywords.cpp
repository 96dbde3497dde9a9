#include "python/method_keywords.h"

#include <fmt/core.h>

#include <sstream>

namespace hapton::python {
namespace {

struct Keyword {
  const char* name;
  void (*read)(MethodSettings& settings, const py::handle& value);
};

template <auto kField>
void read_field(MethodSettings& settings, const py::handle& value) {
  settings.*kField = value.cast<std::remove_reference_t<decltype(settings.*kField)>>();
}

void read_grid(MethodSettings& settings, const py::handle& value) {
  const auto sides = value.cast<py::sequence>();
  if (sides.size() != 3) raise_value_error("grid_division must have 3 numbers; give cells along x, y, z");
  for (std::size_t k = 0; k < 3; ++k) settings.grid_division[k] = sides[k].cast<int>();
}

constexpr Keyword kKeywords[] = {
    {"grid_division", &read_grid},
    {"offset_m", &read_field<&MethodSettings::offset_m>},
    {"set_size", &read_field<&MethodSettings::set_size>},
    {"smooth_radius_m", &read_field<&MethodSettings::smooth_radius_m>},
    {"smooth_layer", &read_field<&MethodSettings::smooth_layer>},
    {"hull_directions", &read_field<&MethodSettings::hull_directions>},
    {"crease_deg", &read_field<&MethodSettings::crease_deg>},
    {"simplify_m", &read_field<&MethodSettings::simplify_m>},
    {"shading", &read_field<&MethodSettings::shading>},
    {"probe_radius_m", &read_field<&MethodSettings::probe_radius_m>},
    {"coupling_n_per_m", &read_field<&MethodSettings::coupling_n_per_m>},
    {"reference_substeps", &read_field<&MethodSettings::reference_substeps>},
    {"reference_substep_limit", &read_field<&MethodSettings::reference_substep_limit>},
};

std::string keyword_names() {
  std::string names;
  for (const Keyword& keyword : kKeywords) names += (names.empty() ? "" : ", ") + std::string(keyword.name);
  return names;
}

}  // namespace

MethodSettings read_method(const std::string& name, const py::kwargs& keywords) {
  MethodSettings settings;
  settings.name = name;
  for (const auto& [key, value] : keywords) {
    const auto keyword_name = key.cast<std::string>();
    const Keyword* match = nullptr;
    for (const Keyword& keyword : kKeywords) match = keyword_name == keyword.name ? &keyword : match;
    if (match == nullptr) throw py::type_error(fmt::format("there is no setting '{}'; choose from: {}", keyword_name, keyword_names()));
    try {
      match->read(settings, value);
    } catch (const py::cast_error&) {
      throw py::type_error(fmt::format("{} has the wrong type for this setting", keyword_name));
    }
  }
  return settings;
}

std::vector<std::string> list_methods() {
  std::vector<std::string> names;
  std::istringstream all(method_names());
  for (std::string name; std::getline(all >> std::ws, name, ',');) names.push_back(name);
  return names;
}

}  // namespace hapton::python
