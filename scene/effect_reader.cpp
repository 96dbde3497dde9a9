#include "scene/effect_reader.h"

#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace hapton {
namespace {

// Limits of the keys, far beyond any surface, device or hand, so that only typing errors are rejected.
constexpr double kEffectMaxStiffnessNPerM = 1e6;
constexpr double kEffectMaxProgressiveNPerM2 = 1e9;
constexpr double kEffectMaxDampingNsPerM = 1e3;
constexpr double kEffectMaxTapNsPerM = 1e3;
constexpr double kEffectMaxLengthM = 10.0;
constexpr double kEffectMaxPositionM = 1e6;
constexpr double kEffectMaxTimeS = 60.0;
constexpr double kEffectMaxFrequencyHz = 1000.0;  // the upper limit of human vibrotactile perception
constexpr double kMaxButtons = 32.0;
constexpr double kEffectLeastMassKg = 1e-3;
constexpr double kEffectMostMassKg = 5.0;
constexpr double kEffectMostFilterS = 1.0;
constexpr double kMaxBumpShare = 1.0 / 3.0;  // height over length; the steepest slope is then pi / 3

constexpr std::array<std::string_view, 13> kSurfaceKeys = {
    "progressive_n_per_m2", "viscosity_ns_per_m", "snap_range_m",   "snap_stiffness_n_per_m", "bump_height_m",
    "bump_length_m",        "bump_pattern",       "bump_direction", "tap_ns_per_m",           "tap_frequency_hz",
    "tap_decay_s",          "tap_max_force_n",    "layer"};
constexpr std::array<std::string_view, 2> kPatterns = {"ridges", "grid"};
constexpr std::array<std::string_view, 4> kWaveforms = {"sine", "square", "triangle", "sawtooth"};

// Error: `key` is given, but has no effect without `other`.
void need(TableReader& reader, std::string_view key, std::string_view other, bool is_on) {
  if (reader.has(key) && !is_on) reader.fail_at(key, "'{}' has no effect: give '{}' above 0 too", key, other);
}

void read_bumps(TableReader& reader, SurfaceBumps& bumps) {
  reader.read("bump_height_m", bumps.height_m, 0.0, kEffectMaxLengthM);
  reader.read("bump_length_m", bumps.length_m, 0.0, kEffectMaxLengthM, true);
  std::size_t pattern = static_cast<std::size_t>(bumps.pattern);
  reader.read_choice("bump_pattern", kPatterns, pattern);
  bumps.pattern = static_cast<SurfaceBumps::Pattern>(pattern);
  reader.read_direction("bump_direction", bumps.direction);
  for (const char* key : {"bump_length_m", "bump_pattern", "bump_direction"}) need(reader, key, "bump_height_m", bumps.is_on());
  if (bumps.pattern != SurfaceBumps::Pattern::ridges && reader.has("bump_direction")) {
    reader.fail_at("bump_direction", "'bump_direction' is for 'bump_pattern' \"ridges\": leave it out");
  }
  if (bumps.height_m > kMaxBumpShare * bumps.length_m) {
    reader.fail_at("bump_height_m", "'bump_height_m' is {}: it must be at most a third of 'bump_length_m', {}", bumps.height_m,
                   bumps.length_m);
  }
}

void read_snap(TableReader& reader, SurfaceSnap& snap) {
  reader.read("snap_range_m", snap.range_m, 0.0, kEffectMaxLengthM);
  reader.read("snap_stiffness_n_per_m", snap.stiffness_n_per_m, 0.0, kEffectMaxStiffnessNPerM, true);
  need(reader, "snap_stiffness_n_per_m", "snap_range_m", snap.is_on());
  if (snap.bound_n() > kMaxEffectForceN) {
    reader.fail_at("snap_range_m", "'snap_range_m' times 'snap_stiffness_n_per_m' is {} N: it must be at most {} N", snap.bound_n(),
                   kMaxEffectForceN);
  }
}

void read_tap(TableReader& reader, TapVibration& tap) {
  reader.read("tap_ns_per_m", tap.ns_per_m, 0.0, kEffectMaxTapNsPerM);
  reader.read("tap_frequency_hz", tap.frequency_hz, 0.0, kEffectMaxFrequencyHz, true);
  reader.read("tap_decay_s", tap.decay_s, 0.0, kEffectMaxTimeS, true);
  reader.read("tap_max_force_n", tap.max_force_n, 0.0, kMaxEffectForceN, true);
  for (const char* key : {"tap_frequency_hz", "tap_decay_s", "tap_max_force_n"}) need(reader, key, "tap_ns_per_m", tap.is_on());
}

Result<TissueLayer> read_layer(const toml::table& table, const std::string& where) {
  TissueLayer layer;
  TableReader reader(table, where);
  reader.allow({"depth_m", "stiffness_n_per_m", "pop_force_n", "drag_ns_per_m"});
  reader.require("depth_m");
  reader.require("stiffness_n_per_m");
  reader.read("depth_m", layer.depth_m, 0.0, kEffectMaxLengthM);
  reader.read("stiffness_n_per_m", layer.stiffness_n_per_m, 0.0, kEffectMaxStiffnessNPerM, true);
  reader.read("pop_force_n", layer.pop_force_n, 0.0, kMaxEffectForceN, true);
  reader.read("drag_ns_per_m", layer.drag_ns_per_m, 0.0, kEffectMaxDampingNsPerM);
  if (reader.has("drag_ns_per_m") && !reader.has("pop_force_n")) {
    reader.fail_at("drag_ns_per_m", "'drag_ns_per_m' has no effect in a layer without 'pop_force_n', which is never punctured");
  }
  if (reader.error()) return tl::unexpected(*reader.error());
  return layer;
}

Result<void> read_layers(const toml::table& table, const std::string& material_name, const Material& material, TableReader& reader,
                         SurfaceEffects& effects) {
  const toml::node* node = table.get("layer");
  if (node == nullptr || reader.error()) return {};
  const std::string header = fmt::format("[[material.{}.layer]]", printable(material_name));
  const toml::array* array = node->as_array();
  if (array == nullptr || array->empty() || !array->is_array_of_tables()) {
    return fail("{}'layer' must be tables that begin with {}", line_prefix(*node), header);
  }
  if (array->size() > TissueLayers::kMax)
    return fail("{}{} layers: give at most {}", line_prefix(*node), array->size(), TissueLayers::kMax);
  for (const toml::node& one : *array) {
    const std::size_t number = effects.layers.count() + 1;
    const auto layer = read_layer(*one.as_table(), fmt::format("{} {}", header, number));
    if (!layer) return tl::unexpected(layer.error());
    if (number > 1) {
      const TissueLayer& before = effects.layers[number - 2];
      if (!(layer->depth_m > before.depth_m)) {
        return fail("{}'depth_m' in {} {} is {}: it must be more than that of the layer before, {}", line_prefix(one), header, number,
                    layer->depth_m, before.depth_m);
      }
      if (!(before.pop_force_n <= kMaxEffectForceN)) {
        return fail("{}{} {} is never reached: give the layer before it a 'pop_force_n'", line_prefix(one), header, number);
      }
    }
    effects.layers.add(*layer);
  }
  // Layers replace the spring and damper of the material. It must be one-sided, so that a needle in the body can leave it after a restart.
  if (material.two_sided) reader.fail_at("layer", "layers in [material.{}] need 'two_sided = false'", printable(material_name));
  if (material.damping_ns_per_m > 0.0) reader.fail_at("damping_ns_per_m", "layers have no 'damping_ns_per_m': give them 'drag_ns_per_m'");
  if (effects.progressive.is_on()) reader.fail_at("progressive_n_per_m2", "layers have no 'progressive_n_per_m2': leave it out");
  if (reader.has("stiffness_n_per_m"))
    reader.fail_at("stiffness_n_per_m", "layers replace 'stiffness_n_per_m' of the material: leave it out");
  return {};
}

// ---- [[effect]] ------------------------------------------------------------------------------------------------------

// Where an effect acts: position_m with radius_m (a ball) or size_m (a box), or object; none of them: everywhere.
void read_volume(TableReader& reader, EffectSpec& spec, EffectVolume& volume) {
  const bool has_ball = reader.has("radius_m");
  const bool has_box = reader.has("size_m");
  Vec3 centre = Vec3::Zero();
  reader.read("position_m", centre, kEffectMaxPositionM);
  if (!spec.object.empty()) {
    for (const char* key : {"position_m", "radius_m", "size_m"}) {
      if (reader.has(key)) reader.fail_at(key, "both 'object' and '{}' are given: keep one", key);
    }
    return;
  }
  if (has_ball && has_box) return reader.fail_at("size_m", "both 'radius_m' and 'size_m' are given: keep one");
  if (reader.has("position_m") != (has_ball || has_box)) {
    return reader.fail_at("position_m", "a volume is 'position_m' with 'radius_m' (a ball) or 'size_m' (a box): give both, or neither");
  }
  double radius_m = 0.0;
  std::array<double, 3> size_m = {};
  reader.read("radius_m", radius_m, 0.0, kEffectMaxLengthM, true);
  reader.read("size_m", size_m, 1e-6, kEffectMaxLengthM);
  const Vec3 half = 0.5 * Vec3(size_m[0], size_m[1], size_m[2]);
  if (has_ball) volume = EffectVolume::ball(centre, radius_m);
  if (has_box) volume = EffectVolume::box(centre - half, centre + half);
}

void read_position(TableReader& reader, const EffectSpec& spec, Vec3& position) {
  if (spec.object.empty()) reader.require("position_m");
  if (!spec.object.empty() && reader.has("position_m")) reader.fail_at("position_m", "both 'object' and 'position_m' are given: keep one");
  reader.read("position_m", position, kEffectMaxPositionM);
}

void read_max_force(TableReader& reader, double& max_force_n) { reader.read("max_force_n", max_force_n, 0.0, kMaxEffectForceN, true); }

void read_effect(TableReader& reader, EffectSpec& spec, SpringEffect& spring) {
  read_position(reader, spec, spring.centre);
  reader.read("stiffness_n_per_m", spring.stiffness_n_per_m, 0.0, kEffectMaxStiffnessNPerM, true);
  read_max_force(reader, spring.max_force_n);
}

void read_effect(TableReader& reader, EffectSpec& spec, ConstantEffect& constant) {
  reader.require("force_n");
  reader.read("force_n", constant.force_n, kMaxEffectForceN);
  if (constant.bound_n() > kMaxEffectForceN) {
    reader.fail_at("force_n", "'force_n' has length {}: it must be at most {}", constant.bound_n(), kMaxEffectForceN);
  }
  read_volume(reader, spec, constant.volume);
}

void read_effect(TableReader& reader, EffectSpec& spec, SnapEffect& snap) {
  read_position(reader, spec, snap.position);
  reader.read("range_m", snap.range_m, 0.0, kEffectMaxLengthM, true);
  read_max_force(reader, snap.max_force_n);
  if (snap.target == SnapEffect::Target::point) return;
  const char* key = snap.target == SnapEffect::Target::line ? "direction" : "normal";
  reader.require(key);
  reader.read_direction(key, snap.direction);
}

void read_effect(TableReader& reader, EffectSpec& spec, GravityWellEffect& well) {
  read_position(reader, spec, well.centre);
  reader.read("radius_m", well.radius_m, 0.0, kEffectMaxLengthM, true);
  read_max_force(reader, well.max_force_n);
}

void read_effect(TableReader& reader, EffectSpec& spec, ViscousEffect& viscous) {
  reader.require("damping_ns_per_m");
  reader.read("damping_ns_per_m", viscous.damping_ns_per_m, 0.0, kEffectMaxDampingNsPerM, true);
  read_max_force(reader, viscous.max_force_n);
  read_volume(reader, spec, viscous.volume);
}

void read_effect(TableReader& reader, EffectSpec& spec, MassEffect& mass) {
  reader.require("mass_kg");
  reader.read("mass_kg", mass.mass_kg, kEffectLeastMassKg, kEffectMostMassKg);
  reader.read("filter_s", mass.filter_s, MassEffect::kMinFilterS, kEffectMostFilterS);
  read_max_force(reader, mass.max_force_n);
  read_volume(reader, spec, mass.volume);
}

void read_effect(TableReader& reader, EffectSpec& spec, WaveEffect& wave) {
  std::size_t form = 0;
  reader.read_choice("waveform", kWaveforms, form);
  wave.waveform = static_cast<Waveform>(form);
  reader.require("direction");
  reader.read_direction("direction", wave.direction);
  reader.read("amplitude_n", wave.amplitude_n, 0.0, kMaxEffectForceN, true);
  reader.read("frequency_hz", wave.frequency_hz, 0.0, kEffectMaxFrequencyHz, true);
  read_volume(reader, spec, wave.volume);
}

void read_effect(TableReader& reader, EffectSpec& spec, BurstEffect& burst) {
  reader.require("direction");
  reader.read_direction("direction", burst.direction);
  reader.read("amplitude_n", burst.amplitude_n, 0.0, kMaxEffectForceN, true);
  reader.read("frequency_hz", burst.frequency_hz, 0.0, kEffectMaxFrequencyHz, true);
  reader.read("decay_s", burst.decay_s, 0.0, kEffectMaxTimeS, true);
  reader.read("duration_s", burst.duration_s, 0.0, kEffectMaxTimeS, true);
  if (spec.object.empty() && !reader.has("position_m") && !reader.has("button")) {
    reader.fail_at("position_m",
                   "a burst needs a volume to enter: give 'position_m' with 'radius_m' or 'size_m', or 'object'; or a 'button'");
  }
  read_volume(reader, spec, burst.volume);
}

struct EffectType {
  std::string_view name;
  SpaceEffect made;  // with its defaults
  std::vector<std::string_view> keys;
};

// Never destroyed: the thread that reads a scene may still run when the program ends.
const std::vector<EffectType>& effect_types() {
  static const auto& types = *new std::vector<EffectType>{
      {"spring", SpringEffect(), {"position_m", "stiffness_n_per_m", "max_force_n"}},
      {"constant", ConstantEffect(), {"force_n", "position_m", "radius_m", "size_m"}},
      {"magnet", SnapEffect(), {"position_m", "range_m", "max_force_n"}},
      {"line_snap", SnapEffect{.target = SnapEffect::Target::line}, {"position_m", "direction", "range_m", "max_force_n"}},
      {"plane_snap", SnapEffect{.target = SnapEffect::Target::plane}, {"position_m", "normal", "range_m", "max_force_n"}},
      {"gravity_well", GravityWellEffect(), {"position_m", "radius_m", "max_force_n"}},
      {"viscous", ViscousEffect(), {"damping_ns_per_m", "max_force_n", "position_m", "radius_m", "size_m"}},
      {"mass", MassEffect(), {"mass_kg", "filter_s", "max_force_n", "position_m", "radius_m", "size_m"}},
      {"wave", WaveEffect(), {"waveform", "direction", "amplitude_n", "frequency_hz", "position_m", "radius_m", "size_m"}},
      {"burst", BurstEffect(), {"direction", "amplitude_n", "frequency_hz", "decay_s", "duration_s", "position_m", "radius_m", "size_m"}},
  };
  return types;
}

struct PlaceAt {
  Vec3 low, high;

  void operator()(SpringEffect& effect) const { effect.centre = 0.5 * (low + high); }
  void operator()(SnapEffect& effect) const { effect.position = 0.5 * (low + high); }
  void operator()(GravityWellEffect& effect) const { effect.centre = 0.5 * (low + high); }
  template <class InVolume>
  void operator()(InVolume& effect) const {
    effect.volume = EffectVolume::box(low, high);
  }
};

// ---- [[effect]] of type "plugin" ----------------------------------------------------------------------------------------

constexpr std::string_view kParametersKey = "parameters";

// A parameter as text, as on a command line: whole numbers have no decimal point.
Result<std::string> parameter_text(const toml::node& node, std::string_view key, std::size_t number) {
  const std::size_t line = node.source().begin.line;
  if (const auto* flag = node.as_boolean()) return std::string(flag->get() ? "true" : "false");
  if (const auto* whole = node.as_integer()) return fmt::format("{}", whole->get());
  if (const auto* value = node.as_floating_point()) return fmt::format("{}", value->get());
  const auto* text = node.as_string();
  if (text == nullptr)
    return fail("line {}: parameter '{}' in [[effect]] {} must be a text, a number, true or false", line, printable(key), number);
  if (text->get().find(',') != std::string::npos) {
    return fail("line {}: parameter '{}' in [[effect]] {} has a comma, which separates parameters", line, printable(key), number);
  }
  return text->get();
}

Result<void> read_parameters(const toml::table& table, std::size_t number, LibraryEffect& effect) {
  const toml::node* node = table.get(kParametersKey);
  if (node == nullptr) return {};
  if (!node->is_table()) {
    return fail("line {}: 'parameters' in [[effect]] {} must be a table such as {{ range_m = 0.04 }}", node->source().begin.line, number);
  }
  for (const auto& [key, value] : *node->as_table()) {
    const std::string name(key.str());
    if (name.empty() || name.find_first_of(",=:") != std::string::npos) {
      return fail("line {}: '{}' in [[effect]] {} is not a parameter name", value.source().begin.line, printable(name), number);
    }
    auto text = parameter_text(value, name, number);
    if (!text) return tl::unexpected(text.error());
    effect.parameters.emplace_back(name, std::move(*text));
  }
  return {};
}

}  // namespace

std::span<const std::string_view> surface_effect_keys() { return kSurfaceKeys; }

Result<void> read_surface_effects(const toml::table& table, const std::string& material_name, const Material& material, TableReader& reader,
                                  SurfaceEffects& effects) {
  reader.read("progressive_n_per_m2", effects.progressive.n_per_m2, 0.0, kEffectMaxProgressiveNPerM2);
  reader.read("viscosity_ns_per_m", effects.viscosity.damping_ns_per_m, 0.0, kEffectMaxDampingNsPerM);
  if (!reader.has("bump_map") && !reader.has("normal_map")) read_bumps(reader, effects.bumps);
  if (effects.bumps.is_on() && material.damping_ns_per_m > 0.0) {
    reader.fail_at("bump_height_m",
                   "'bump_height_m' is set beside 'damping_ns_per_m' = {}: bumps would turn its damping into a source of energy; "
                   "set that to 0, or use 'viscosity_ns_per_m'",
                   material.damping_ns_per_m);
  }
  read_snap(reader, effects.snap);
  read_tap(reader, effects.tap);
  return read_layers(table, material_name, material, reader, effects);
}

Result<EffectSpec> read_space_effect(const toml::table& table, std::size_t number) {
  TableReader reader(table, fmt::format("[[effect]] {}", number));
  std::vector<std::string_view> names;
  for (const EffectType& one : effect_types()) names.push_back(one.name);
  names.emplace_back("plugin");  // see library_effect.h
  reader.require("type");
  std::size_t type = 0;
  reader.read_choice("type", names, type);
  if (reader.error()) return tl::unexpected(*reader.error());
  if (type == effect_types().size()) return fail("[[effect]] {} is a plug-in, not computed here", number);
  const EffectType& known = effect_types()[type];
  std::vector<std::string_view> keys = known.keys;
  keys.insert(keys.end(), {"type", "name", "object", "button"});
  reader.allow(keys);
  EffectSpec spec = {.name = std::string(known.name), .effect = known.made, .object = "", .object_line = 0};
  reader.read_name("name", spec.name);
  reader.read("object", spec.object);
  if (reader.has("object")) {
    spec.object_line = table.get("object")->source().begin.line;
    if (spec.object.empty()) reader.fail_at("object", "'object' in [[effect]] {} is empty: name an object", number);
  }
  double button = 0.0;
  reader.read("button", button, 1.0, kMaxButtons);
  if (button != std::floor(button))
    reader.fail_at("button", "'button' in [[effect]] {} is {}: buttons are counted 1, 2, 3 ...", number, button);
  if (button >= 1.0 && !reader.error()) spec.on.button = std::uint32_t{1} << (static_cast<unsigned>(button) - 1U);
  std::visit([&](auto& effect) { read_effect(reader, spec, effect); }, spec.effect);
  if (reader.error()) return tl::unexpected(*reader.error());
  return spec;
}

bool is_library_effect(const toml::table& table) { return table["type"].value_exact<std::string>() == "plugin"; }

Result<LibraryEffect> read_library_effect(const toml::table& table, std::size_t number) {
  TableReader reader(table, fmt::format("[[effect]] {}", number));
  reader.allow({"type", "name", "library", kParametersKey});
  reader.require("library");
  LibraryEffect effect;
  effect.line = table.source().begin.line;
  std::string library;
  reader.read_name("name", effect.name);
  reader.read("library", library);
  if (reader.has("library") && library.empty()) reader.fail_at("library", "'library' in [[effect]] {} is empty: name a file", number);
  if (reader.error()) return tl::unexpected(*reader.error());
  effect.library = library;
  if (effect.name.empty()) effect.name = effect.library.stem().string();
  if (const auto read = read_parameters(table, number, effect); !read) return tl::unexpected(read.error());
  return effect;
}

void place_at_object(SpaceEffect& effect, const Vec3& low, const Vec3& high) { std::visit(PlaceAt{low, high}, effect); }

}  // namespace hapton
