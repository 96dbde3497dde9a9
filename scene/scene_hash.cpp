#include "scene/scene_hash.h"

#include <algorithm>
#include <bit>

#include "core/effects/texture_models.h"

namespace hapton {
namespace {

// Eight bytes at a time: xor, multiply by the golden ratio, fold the high half down (Knuth, TAOCP 6.4).
class Hash {
 public:
  void add(std::uint64_t value) noexcept {
    state_ = (state_ ^ value) * 0x9E3779B97F4A7C15ULL;
    state_ ^= state_ >> 32;
  }
  void add(double value) noexcept { add(std::bit_cast<std::uint64_t>(value)); }
  std::uint64_t value() const noexcept { return state_; }

 private:
  std::uint64_t state_ = 0x243F6A8885A308D3ULL;  // digits of pi
};

void add_mesh(Hash& hash, const TriangleMesh& mesh) {
  hash.add(std::uint64_t{mesh.vertices.size()});
  hash.add(std::uint64_t{mesh.triangles.size()});
  for (const Vec3& v : mesh.vertices) {
    for (int k = 0; k < 3; ++k) hash.add(v[k]);
  }
  for (const Triangle& t : mesh.triangles) {
    hash.add(std::uint64_t{t[0]} << 32 | t[1]);
    hash.add(std::uint64_t{t[2]});
  }
}

void add_normals(Hash& hash, const TriangleMesh& mesh) {
  for (const auto& corners : mesh.authored_normals) {
    for (const Eigen::Vector3f& normal : corners) {
      for (int k = 0; k < 3; ++k) hash.add(std::uint64_t{std::bit_cast<std::uint32_t>(normal[k])});
    }
  }
}

// Adds every number of the effect: those that are off count too, so that no change is missed.
void add_volume(Hash& hash, const EffectVolume& volume) {
  volume.for_each_number([&](double number) { hash.add(number); });
}
void add_vector(Hash& hash, const Vec3& v) {
  for (int k = 0; k < 3; ++k) hash.add(v[k]);
}

struct AddEffect {
  Hash& hash;

  void operator()(const SpringEffect& e) const {
    add_vector(hash, e.centre);
    for (const double number : {e.stiffness_n_per_m, e.max_force_n}) hash.add(number);
  }
  void operator()(const ConstantEffect& e) const {
    add_vector(hash, e.force_n);
    add_volume(hash, e.volume);
  }
  void operator()(const SnapEffect& e) const {
    hash.add(static_cast<std::uint64_t>(e.target));
    add_vector(hash, e.position);
    add_vector(hash, e.direction);
    for (const double number : {e.range_m, e.max_force_n}) hash.add(number);
  }
  void operator()(const GravityWellEffect& e) const {
    add_vector(hash, e.centre);
    for (const double number : {e.radius_m, e.max_force_n}) hash.add(number);
  }
  void operator()(const ViscousEffect& e) const {
    for (const double number : {e.damping_ns_per_m, e.max_force_n}) hash.add(number);
    add_volume(hash, e.volume);
  }
  void operator()(const MassEffect& e) const {
    for (const double number : {e.mass_kg, e.filter_s, e.max_force_n}) hash.add(number);
    add_volume(hash, e.volume);
  }
  void operator()(const WaveEffect& e) const {
    hash.add(static_cast<std::uint64_t>(e.waveform));
    add_vector(hash, e.direction);
    for (const double number : {e.amplitude_n, e.frequency_hz}) hash.add(number);
    add_volume(hash, e.volume);
  }
  void operator()(const BurstEffect& e) const {
    add_vector(hash, e.direction);
    for (const double number : {e.amplitude_n, e.frequency_hz, e.decay_s, e.duration_s}) hash.add(number);
    add_volume(hash, e.volume);
  }
};

void add_map(Hash& hash, const ImageMap& map) {
  for (const double number : {map.at_black, map.at_white}) hash.add(number);
  if (!map.is_on()) return;
  hash.add(static_cast<std::uint64_t>(map.image->width()));
  for (const float texel : map.image->texels()) hash.add(static_cast<double>(texel));
}

void add_maps(Hash& hash, const SurfaceMaps& maps) {
  for (const MappedTriangle& triangle : *maps.triangles) {
    for (const Eigen::Vector2d& place : triangle.texcoord) {
      hash.add(place.x());
      hash.add(place.y());
    }
  }
  for (const ImageMap* map : {&maps.height, &maps.stiffness, &maps.friction}) add_map(hash, *map);
  // Scenes without a viscosity map keep the hash that they had before these maps existed.
  if (maps.viscosity.is_on()) add_map(hash, maps.viscosity);
}

void add_texture(Hash& hash, const RecordedTexture& texture) {
  for (const double number : {texture.mass_kg, texture.max_force_n, texture.models->rate_hz()}) hash.add(number);
  hash.add(texture.seed);
  for (const TextureModel& model : texture.models->models()) {
    for (const double number : {model.speed_m_per_s, model.force_n, model.variance, model.gain}) hash.add(number);
    for (const auto* frequencies : {&model.ar, &model.ma}) {
      hash.add(std::uint64_t{frequencies->size()});
      for (const double frequency : *frequencies) hash.add(frequency);
    }
  }
  for (const TextureTriangle& triangle : texture.models->triangles()) {
    for (const std::size_t corner : triangle) hash.add(std::uint64_t{corner});
  }
}

void add_surface(Hash& hash, const SurfaceEffects& e) {
  hash.add(e.progressive.n_per_m2);
  hash.add(std::uint64_t{e.layers.count()});
  for (std::size_t i = 0; i < e.layers.count(); ++i) {
    const TissueLayer& layer = e.layers[i];
    for (const double number : {layer.depth_m, layer.stiffness_n_per_m, layer.pop_force_n, layer.drag_ns_per_m}) hash.add(number);
  }
  hash.add(static_cast<std::uint64_t>(e.bumps.pattern));
  for (const double number : {e.bumps.height_m, e.bumps.length_m}) hash.add(number);
  add_vector(hash, e.bumps.direction);
  hash.add(e.viscosity.damping_ns_per_m);
  for (const double number : {e.snap.stiffness_n_per_m, e.snap.range_m}) hash.add(number);
  for (const double number : {e.tap.ns_per_m, e.tap.frequency_hz, e.tap.decay_s, e.tap.max_force_n}) hash.add(number);
  // Scenes without maps and recorded textures keep the hash that they had before these existed.
  if (e.maps.is_on()) add_maps(hash, e.maps);
  if (e.texture.is_on()) add_texture(hash, e.texture);
}

}  // namespace

std::uint64_t hash_mesh(const TriangleMesh& mesh) {
  Hash hash;
  add_mesh(hash, mesh);
  return hash.value();
}

std::uint64_t hash_numbers(std::span<const double> numbers) {
  Hash hash;
  for (const double number : numbers) hash.add(number);
  return hash.value();
}

std::uint64_t hash_placed(std::uint64_t mesh, double scale, const Quat& orientation, const Vec3& position) {
  const Quat& q = orientation;
  return combine_hashes(mesh, hash_numbers(std::array{scale, q.w(), q.x(), q.y(), q.z(), position.x(), position.y(), position.z()}));
}

std::uint64_t hash_motion(const KeyframeMotion& motion) {
  Hash hash;
  add_vector(hash, motion.pivot());
  hash.add(std::uint64_t{motion.loops()});
  for (const Keyframe& one : motion.keyframes()) {
    hash.add(one.time_s);
    add_vector(hash, one.p_S);
    for (int k = 0; k < 4; ++k) hash.add(one.turn.coeffs()[k]);
  }
  return hash.value();
}

std::uint64_t hash_deformation(const MeshDeformation& deformation) {
  Hash hash;
  hash.add(std::uint64_t{deformation.loops()});
  for (const MorphTarget& target : deformation.targets()) {
    hash.add(std::uint64_t{target.vertices.size()});
    for (const std::uint32_t vertex : target.vertices) hash.add(std::uint64_t{vertex});
    for (const Vec3& displacement : target.displacements) add_vector(hash, displacement);
  }
  for (const MorphKey& key : deformation.keys()) {
    hash.add(key.time_s);
    for (const double weight : key.weights) hash.add(weight);
  }
  return hash.value();
}

std::uint64_t hash_sculpt(const SculptSettings& sculpt) {
  Hash hash;
  hash.add(sculpt.voxel_m);
  hash.add(sculpt.tool_radius_m);
  hash.add(std::uint64_t{sculpt.button});
  return hash.value();
}

std::uint64_t combine_hashes(std::uint64_t first, std::uint64_t second) {
  Hash hash;
  hash.add(first);
  hash.add(second);
  return hash.value() == 0 ? 1 : hash.value();
}

namespace {

void add_motions(Hash& hash, const TouchScene& scene) {
  for (const TouchObject& object : scene.objects) hash.add(object.motion != nullptr ? hash_motion(*object.motion) : std::uint64_t{0});
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    const TouchObject& object = scene.objects[o];
    if (object.deformation == nullptr) continue;
    // Where another object could deform alike, the object's number counts too. Elsewhere the hash stays the one of older recordings.
    const auto has_as_many = [&](const TouchObject& other) { return other.mesh->vertices.size() == object.mesh->vertices.size(); };
    if (std::ranges::count_if(scene.objects, has_as_many) > 1) hash.add(std::uint64_t{o});
    hash.add(hash_deformation(*object.deformation));
  }
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    if (!scene.objects[o].stream_reach_m) continue;
    hash.add(std::uint64_t{o});
    hash.add(*scene.objects[o].stream_reach_m);
  }
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    if (!scene.objects[o].command_pivot) continue;
    hash.add(std::uint64_t{o});
    add_vector(hash, *scene.objects[o].command_pivot);
  }
}

}  // namespace

std::uint64_t hash_scene(const TouchScene& scene) {
  Hash hash;
  hash.add(std::uint64_t{scene.objects.size()});
  for (const TouchObject& object : scene.objects) {
    add_mesh(hash, *object.mesh);
    const Material& m = object.material;
    for (const double value : {m.stiffness_n_per_m, m.damping_ns_per_m, m.friction_static, m.friction_dynamic}) hash.add(value);
    hash.add(std::uint64_t{m.two_sided});
  }
  // Force shading uses these normals.
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    if (!scene.objects[o].mesh->has_authored_normals()) continue;
    hash.add(std::uint64_t{o});
    add_normals(hash, *scene.objects[o].mesh);
  }
  if (scene.has_motion()) add_motions(hash, scene);
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    if (!scene.objects[o].sculpt) continue;
    hash.add(std::uint64_t{o});
    hash.add(hash_sculpt(*scene.objects[o].sculpt));
  }
  if (!scene.has_effects()) return hash.value();
  for (const TouchObject& object : scene.objects) add_surface(hash, object.effects);
  for (const SwitchedEffect& one : scene.effects) {
    hash.add(std::uint64_t{one.effect.index()});
    std::visit(AddEffect{hash}, one.effect);
    if (one.on.button != 0) hash.add(std::uint64_t{one.on.button});
  }
  return hash.value();
}

}  // namespace hapton
