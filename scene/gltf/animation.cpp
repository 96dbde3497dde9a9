#include "scene/gltf/animation.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "scene/gltf/morph_weights.h"
#include "scene/gltf/spline.h"
#include "scene/gltf/transform.h"
#include "scene/text_cursor.h"

namespace hapton::gltf {
namespace {

// A motion or scale that deviates from a rigid one by at most this is no deformation: numbers in a file have seven digits.
constexpr double kRigidMotionTolerance = 1e-5;

template <class Value>
struct Track {
  std::vector<double> times;
  std::vector<Value> values;
};

// What an animation does to a node.
struct NodeTracks {
  std::optional<Track<Vec3>> translation;
  std::optional<Track<Quat>> rotation;
  std::optional<Track<std::vector<double>>> weights;  // at each time, one for each morph target of the node
};

struct LeftOut {
  std::size_t scales = 0;  // channels of scales, and all others but translations, rotations and weights
  std::size_t steps = 0;
  std::size_t deformed = 0;
};

// Bounds the memory and time that the animations of a file take. The size of the file alone does not bound them: channels may share a
// sampler, and parts may share the nodes above them. Each bound is a constant, enough for small files, plus an amount for each byte read.
class AnimationBudget {
 public:
  explicit AnimationBudget(const Buffers& buffers) : buffers_(buffers) {}

  // False: the bound is exceeded.
  bool take_numbers(std::size_t count) { return take(numbers_, count, std::size_t{1} << 22, 16); }
  bool take_keyframes(std::size_t count) { return take(keyframes_, count, std::size_t{1} << 22, 4); }
  bool take_poses(std::size_t count) { return take(poses_, count, std::size_t{1} << 24, 16); }

 private:
  bool take(std::size_t& taken, std::size_t count, std::size_t base_count, std::size_t per_byte) const {
    taken += count;
    return taken <= base_count + per_byte * buffers_.bytes_read();
  }

  const Buffers& buffers_;
  std::size_t numbers_ = 0;    // numbers in all channels
  std::size_t keyframes_ = 0;  // keyframes of all parts
  std::size_t poses_ = 0;      // poses of the nodes on the path to each part, at rest and at each of its keyframes
};

template <class Value, class Mix>
Value value_at(const Track<Value>& track, double time, const Mix& mix) {
  const auto after = std::upper_bound(track.times.begin(), track.times.end(), time);
  if (after == track.times.begin()) return track.values.front();
  if (after == track.times.end()) return track.values.back();
  const auto i = static_cast<std::size_t>(after - track.times.begin());
  const double share = (time - track.times[i - 1]) / (track.times[i] - track.times[i - 1]);
  return mix(track.values[i - 1], track.values[i], share);
}

struct NodeAtRest {
  Eigen::Affine3d X_PN;
  Mat3 R_PN;  // the rotation in X_PN, whose remaining factor scales and may mirror
};

// A node's own transform at a time: an animated translation or rotation replaces the one at rest.
Eigen::Affine3d local_at(const NodeTracks* tracks, const NodeAtRest& rest, double time) {
  Eigen::Affine3d moved = rest.X_PN;
  if (tracks == nullptr) return moved;
  if (tracks->translation) {
    moved.translation() =
        value_at(*tracks->translation, time, [](const Vec3& a, const Vec3& b, double s) { return Vec3(a + s * (b - a)); });
  }
  if (tracks->rotation) {
    const auto slerp = [](const Quat& a, const Quat& b, double s) { return a.slerp(s, b).normalized(); };
    moved.linear() = value_at(*tracks->rotation, time, slerp).toRotationMatrix() * rest.R_PN.transpose() * rest.X_PN.linear();
  }
  return moved;
}

tl::unexpected<Error> too_many_numbers(const std::string& where) {
  return fail("{}: the channels of all animations have too many numbers for the size of the file: {}", where, kExportAgain);
}

Result<std::vector<double>> read_times(const Document& document, const Json& sampler, const std::string& where, AnimationBudget& budget) {
  const auto input = read_accessor(document, member(sampler, "input"), where + ".input", "SCALAR", 1);
  if (!input) return tl::unexpected(input.error());
  if (!budget.take_numbers(input->count)) return too_many_numbers(where);
  std::vector<double> times;
  for (std::size_t i = 0; i < input->count; ++i) {
    times.push_back(input->component(i, 0));
    const bool grows = times.size() < 2 || times.back() > times[times.size() - 2];
    if (!(times.back() >= 0.0) || !std::isfinite(times.back()) || !grows) {
      return fail("{}: its times do not increase from 0: {}", where, kExportAgain);
    }
  }
  if (times.empty()) return fail("{} has no keyframes: {}", where, kExportAgain);
  return times;
}

// A row of `width` numbers at each time: one item of that type, or `width` items of type SCALAR, as for weights (glTF 2.0, 3.11).
Result<NumberTrack> read_numbers(const Document& document, const Json& sampler, const std::string& where, const char* type,
                                 std::size_t width, AnimationBudget& budget) {
  auto times = read_times(document, sampler, where, budget);
  if (!times) return tl::unexpected(times.error());
  const bool is_scalar = std::string_view(type) == "SCALAR";
  const auto output = read_accessor(document, member(sampler, "output"), where + ".output", type, is_scalar ? 1 : width);
  if (!output) return tl::unexpected(output.error());
  const bool is_spline = text_of(member(sampler, "interpolation")) == "CUBICSPLINE";
  const std::size_t rows = (is_spline ? 3 : 1) * times->size();
  if (is_scalar && output->count != rows * width) {
    return fail("{} has {} times, {} morph targets and {} weights: {}", where, times->size(), width, output->count, kExportAgain);
  }
  if (!is_scalar && output->count != rows) {
    return fail("{} has {} times and {} values: {}", where, times->size(), output->count, kExportAgain);
  }
  if (!budget.take_numbers(rows * (1 + width) - times->size())) return too_many_numbers(where);
  std::vector<std::vector<double>> numbers(rows, std::vector<double>(width));
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t k = 0; k < width; ++k) {
      numbers[i][k] = is_scalar ? output->component(i * width + k, 0) : output->component(i, k);
      if (!std::isfinite(numbers[i][k])) return fail("{}: value {} is not finite: {}", where, i, kExportAgain);
    }
  }
  return is_spline ? straighten_spline(*times, numbers) : NumberTrack{std::move(*times), std::move(numbers)};
}

Track<Vec3> to_vectors(const NumberTrack& numbers) {
  Track<Vec3> track{numbers.times, {}};
  for (const std::vector<double>& row : numbers.values) track.values.emplace_back(row[0], row[1], row[2]);
  return track;
}

Result<Track<Quat>> to_rotations(const NumberTrack& numbers, const std::string& where) {
  Track<Quat> track{numbers.times, {}};
  for (const std::vector<double>& row : numbers.values) {
    const Quat turn(row[3], row[0], row[1], row[2]);
    if (!(turn.norm() > 0.0)) return fail("{}: value {} is not a rotation: {}", where, track.values.size(), kExportAgain);
    track.values.push_back(turn.normalized());
  }
  return track;
}

// True if the values are the same at all times: such a channel does not jump, even with STEP, and a scale does not change.
bool is_constant(const NumberTrack& track) {
  return std::all_of(track.values.begin(), track.values.end(), [&](const auto& row) { return row == track.values.front(); });
}

// Exporters write a scale for each bone. A channel that keeps the scale of the node at rest changes nothing, and needs no note.
bool is_scale_at_rest(const Document& document, const Json& sampler, const Json& node, const std::string& where, AnimationBudget& budget) {
  const auto scales = read_numbers(document, sampler, where, "VEC3", 3, budget);
  if (!scales || !is_constant(*scales) || !member(node, "matrix").is_null()) return false;
  const Json& given = member(node, "scale");
  const auto at_rest = given.is_null() ? Result<std::array<double, 3>>(std::array{1.0, 1.0, 1.0}) : numbers_of<3>(given, where);
  if (!at_rest) return false;
  double most = 0.0;
  for (std::size_t k = 0; k < 3; ++k) most = std::max(most, std::fabs(scales->values[0][k] - (*at_rest)[k]));
  return most <= kRigidMotionTolerance;
}

Result<std::map<std::size_t, NodeTracks>> read_tracks(const Document& document, const Json& animation, const std::string& where,
                                                      const std::map<std::size_t, MeshMorphs>& morphs, AnimationBudget& budget,
                                                      LeftOut& left_out) {
  std::map<std::size_t, NodeTracks> tracks;
  const Json& samplers = member(animation, "samplers");
  const Json& channels = member(animation, "channels");
  for (std::size_t c = 0; c < size_of_array(channels); ++c) {
    const std::string place = fmt::format("{}.channels[{}]", where, c);
    const Json& target = member(channels[c], "target");
    const std::string path = text_of(member(target, "path"));
    const bool is_read = path == "translation" || path == "rotation" || path == "weights" || path == "scale";
    if (member(target, "node").is_null() || !is_read) {
      ++left_out.scales;
      continue;
    }
    const Json& nodes = member(document.root, "nodes");
    const auto node = index_of(member(target, "node"), nodes, place + ".target.node");
    if (!node) return tl::unexpected(node.error());
    const auto index = index_of(member(channels[c], "sampler"), samplers, place + ".sampler");
    if (!index) return tl::unexpected(index.error());
    const Json& sampler = samplers[*index];
    const std::string from = fmt::format("{}.samplers[{}]", where, *index);
    if (path == "scale") {
      left_out.scales += is_scale_at_rest(document, sampler, nodes[*node], from, budget) ? 0 : 1;
      if (!budget.take_numbers(0)) return too_many_numbers(from);
      continue;
    }
    const auto targets = morphs.find(*node);
    if (path == "weights" && targets == morphs.end()) continue;  // the node has no triangles, or a note says that its morphs cannot be read
    const auto numbers = path == "weights" ? read_numbers(document, sampler, from, "SCALAR", targets->second.displacements.size(), budget)
                         : path == "rotation" ? read_numbers(document, sampler, from, "VEC4", 4, budget)
                                              : read_numbers(document, sampler, from, "VEC3", 3, budget);
    if (!numbers) return tl::unexpected(numbers.error());
    if (text_of(member(sampler, "interpolation")) == "STEP" && !is_constant(*numbers)) {
      ++left_out.steps;
    } else if (path == "weights") {
      tracks[*node].weights = Track<std::vector<double>>{numbers->times, numbers->values};
    } else if (path == "translation") {
      tracks[*node].translation = to_vectors(*numbers);
    } else {
      auto turns = to_rotations(*numbers, from);
      if (!turns) return tl::unexpected(turns.error());
      tracks[*node].rotation = std::move(*turns);
    }
  }
  return tracks;
}

// The nodes of the file, each with its parent.
class NodeTree {
 public:
  static Result<NodeTree> make(const Json& root) {
    const Json& nodes = member(root, "nodes");
    NodeTree tree;
    tree.parents_.resize(size_of_array(nodes));
    for (std::size_t n = 0; n < tree.parents_.size(); ++n) {
      const auto local = transform_of(nodes[n], fmt::format("nodes[{}]", n));
      if (!local) return tl::unexpected(local.error());
      tree.locals_.push_back({*local, rest_rotation_of(nodes[n], *local)});
      for (const Json& child : member(nodes[n], "children")) {
        const auto index = index_of(child, nodes, fmt::format("a child of nodes[{}]", n));
        if (!index) return tl::unexpected(index.error());
        tree.parents_[*index] = n;
      }
    }
    return tree;
  }

  // The nodes from the root down to `node`. Pre: no node has two parents or is its own ancestor.
  std::vector<std::size_t> path_to(std::size_t node) const {
    std::vector<std::size_t> path = {node};
    while (parents_[path.back()] && path.size() <= parents_.size()) path.push_back(*parents_[path.back()]);
    std::reverse(path.begin(), path.end());
    return path;
  }
  const NodeAtRest& local(std::size_t node) const { return locals_[node]; }

 private:
  std::vector<std::optional<std::size_t>> parents_;
  std::vector<NodeAtRest> locals_;
};

// The pose of the path's last node. tracks: null for the pose at rest.
Eigen::Affine3d pose_of_path(const NodeTree& tree, std::span<const std::size_t> path, const std::map<std::size_t, NodeTracks>* tracks,
                             double time) {
  Eigen::Affine3d X_FN = Eigen::Affine3d::Identity();
  for (const std::size_t node : path) {
    const NodeTracks* moves = tracks != nullptr && tracks->contains(node) ? &tracks->at(node) : nullptr;
    X_FN = X_FN * local_at(moves, tree.local(node), time);
  }
  return X_FN;
}

void add_times(const NodeTracks& tracks, std::set<double>& times) {
  if (tracks.translation) times.insert(tracks.translation->times.begin(), tracks.translation->times.end());
  if (tracks.rotation) times.insert(tracks.rotation->times.begin(), tracks.rotation->times.end());
}

// The weights less those at rest, which the mesh already contains. The last are held until duration_s: all parts begin again together.
std::vector<MorphKey> find_weights(const Track<std::vector<double>>& track, const std::vector<double>& at_rest, double duration_s) {
  std::vector<MorphKey> keys;
  for (std::size_t i = 0; i < track.times.size(); ++i) {
    MorphKey& key = keys.emplace_back(MorphKey{track.times[i], track.values[i]});
    for (std::size_t t = 0; t < std::min(at_rest.size(), key.weights.size()); ++t) key.weights[t] -= at_rest[t];
  }
  if (keys.back().time_s < duration_s) keys.push_back({duration_s, keys.back().weights});
  return keys;
}

// Nullopt: the part does not move, or it would be deformed.
Result<std::optional<KeyframeMotion>> find_motion(const NodeTree& tree, const std::map<std::size_t, NodeTracks>& tracks, std::size_t node,
                                                  double duration_s, AnimationBudget& budget, LeftOut& left_out) {
  const std::vector<std::size_t> path = tree.path_to(node);
  std::set<double> times;
  std::size_t last_moved = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const auto found = tracks.find(path[i]);
    if (found == tracks.end()) continue;
    add_times(found->second, times);
    last_moved = i;
  }
  if (!budget.take_poses(path.size() * (1 + times.size())) || !budget.take_keyframes(times.size())) {
    return fail("the parts have too many keyframes in all animations, or too many nodes above them: {}", kExportAgain);
  }
  if (times.empty()) return std::nullopt;
  times.insert(duration_s);  // all parts begin again together
  if (times.size() < 2) return std::nullopt;
  const Vec3 pivot = pose_of_path(tree, std::span(path).first(last_moved + 1), nullptr, 0.0).translation();
  const Eigen::Affine3d X_FN = pose_of_path(tree, path, nullptr, 0.0);
  std::vector<Keyframe> keyframes;
  for (const double time : times) {
    const Eigen::Affine3d moved = pose_of_path(tree, path, &tracks, time) * X_FN.inverse();
    const bool is_rigid = moved.matrix().allFinite() &&
                          (moved.linear() * moved.linear().transpose() - Mat3::Identity()).cwiseAbs().maxCoeff() <= kRigidMotionTolerance &&
                          moved.linear().determinant() > 0.0;
    if (!is_rigid) {
      ++left_out.deformed;
      return std::nullopt;
    }
    keyframes.push_back({time, moved * pivot, Quat(moved.rotation()).normalized()});
  }
  return std::optional(KeyframeMotion(pivot, std::move(keyframes), false));
}

double last_time(const std::map<std::size_t, NodeTracks>& tracks) {
  std::set<double> times = {0.0};
  for (const auto& [node, each] : tracks) {
    add_times(each, times);
    if (each.weights) times.insert(each.weights->times.begin(), each.weights->times.end());
  }
  return *times.rbegin();
}

void add_notes(const MeshAnimation& animation, const LeftOut& left_out, RawMesh& raw) {
  const std::string name = printable(animation.name);
  const std::pair<std::size_t, std::string_view> notes[] = {
      {left_out.scales, "animation '{}': {} channels of scales or pointers are left out"},
      {left_out.steps, "animation '{}': {} channels that jump (STEP) are left out"},
      {left_out.deformed, "animation '{}': {} parts would deform, which is not supported; they stay at rest"}};
  for (const auto& [count, text] : notes) {
    if (count > 0) raw.notes.push_back(fmt::format(fmt::runtime(text), name, count));
  }
  if (animation.motions.empty() && animation.weights.empty()) return;
  raw.notes.push_back(
      fmt::format("has the animation '{}', {:g} s: 'animation' of an [[object]] in a scene file plays it", name, animation.duration_s));
}

}  // namespace

Result<void> read_animations(const Document& document, RawMesh& raw) {
  const Json& animations = member(document.root, "animations");
  if (size_of_array(animations) == 0) return {};
  const auto tree = NodeTree::make(document.root);
  if (!tree) return tl::unexpected(tree.error());
  const Json& nodes = member(document.root, "nodes");
  AnimationBudget budget(document.buffers);
  for (std::size_t a = 0; a < size_of_array(animations); ++a) {
    LeftOut left_out;
    const auto tracks = read_tracks(document, animations[a], fmt::format("animations[{}]", a), raw.morphs, budget, left_out);
    if (!tracks) return tl::unexpected(tracks.error());
    MeshAnimation animation{.name = text_of(member(animations[a], "name")), .duration_s = last_time(*tracks), .motions = {}};
    if (animation.name.empty()) animation.name = fmt::format("animation {}", a);
    for (const MeshPart& part : raw.parts) {
      if (animation.motions.contains(part.node) || animation.weights.contains(part.node)) continue;
      if (!member(nodes[part.node], "skin").is_null()) continue;  // its skeleton would move it, not its node
      auto motion = find_motion(*tree, *tracks, part.node, animation.duration_s, budget, left_out);
      if (!motion) return tl::unexpected(motion.error());
      if (*motion) animation.motions.emplace(part.node, std::move(**motion));
      const auto own = tracks->find(part.node);
      if (own != tracks->end() && own->second.weights) {
        const auto at_rest = weights_at_rest(document.root, nodes[part.node], fmt::format("nodes[{}]", part.node));
        if (!at_rest) return tl::unexpected(at_rest.error());
        animation.weights.emplace(part.node, find_weights(*own->second.weights, *at_rest, animation.duration_s));
      }
    }
    add_notes(animation, left_out, raw);
    raw.animations.push_back(std::move(animation));
  }
  return {};
}

}  // namespace hapton::gltf
