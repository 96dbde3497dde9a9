#include "core/tool/patch_front.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace hapton {
namespace {

using Floats4 = float __attribute__((vector_size(16)));

Floats4 lanes_of(const Vec3& v) { return Floats4{static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()), 0.0F}; }

// Of three numbers; the last lane is of no use.
Floats4 lanes_at(const float* from) {
  Floats4 four;
  std::memcpy(&four, from, sizeof(four));
  return four;
}

Floats4 larger(const Floats4& a, const Floats4& b) { return a > b ? a : b; }
Floats4 absolute(const Floats4& x) { return larger(x, -x); }

// The components of v along axes that are given by coordinate.
Floats4 along(const Floats4 (&axes)[3], const Floats4& v) { return v[0] * axes[0] + v[1] * axes[1] + v[2] * axes[2]; }

// What a motion adds to the distance of something at `at` from zero, where it is nearer after it.
Floats4 approach(const Floats4& at, const Floats4& motion) {
  const Floats4 away = at < 0.0F ? -motion : motion;
  return away < 0.0F ? away : Floats4{};
}

// The first three lanes of each, as rows, added up by column: lane j of the result is the sum of vector j.
Floats4 sums_of(const Floats4& a, const Floats4& b, const Floats4& c) {
  const Floats4 low = __builtin_shufflevector(a, b, 0, 4, 1, 5);
  const Floats4 high = __builtin_shufflevector(a, b, 2, 6, 2, 6);
  const Floats4 first = __builtin_shufflevector(low, c, 0, 1, 4, 4);
  const Floats4 second = __builtin_shufflevector(low, c, 2, 3, 5, 5);
  const Floats4 third = __builtin_shufflevector(high, c, 0, 1, 6, 6);
  return first + second + third;
}

using Floats8 = float __attribute__((vector_size(32)));

constexpr std::size_t kLanes = 8;
constexpr float kFarAway = std::numeric_limits<float>::infinity();
constexpr Floats8 kFar = {kFarAway, kFarAway, kFarAway, kFarAway, kFarAway, kFarAway, kFarAway, kFarAway};

Floats8 floats_at(const float* from) {
  Floats8 eight;
  std::memcpy(&eight, from, sizeof(eight));
  return eight;
}

bool any_below(const Floats8& x, float bound) {
  const auto below = x <= bound;
  std::uint64_t masks[4];
  std::memcpy(masks, &below, sizeof(masks));
  return ((masks[0] | masks[1]) | (masks[2] | masks[3])) != 0;
}

float least_of(const Floats8& x) {
  float least = x[0];
  for (std::size_t k = 1; k < kLanes; ++k) least = std::min(least, x[k]);
  return least;
}

float rounded_down(double x) { return static_cast<float>(x - std::fabs(x) * 0x1p-22 - 0x1p-100); }

// Of the positive ones of three lengths.
float squared(const Floats4& lengths) {
  const Floats4 positive = larger(lengths, Floats4{});
  const Floats4 squares = positive * positive;
  return squares[0] + squares[1] + squares[2];
}

float largest_of(const Floats4& a, const Floats4& b) {
  const Floats4 both = larger(a, b);
  return std::max({both[0], both[1], both[2]});
}

}  // namespace

PatchFront::PatchFront(const PatchTree& tool, const PatchTree& scene, double radius, WorkerTeam& team)
    : tool_(&tool),
      scene_(&scene),
      radius_(radius),
      team_(&team),
      walkers_(static_cast<std::size_t>(team.size())),
      ended_(kMostEnded),
      until_(kMostEnded),
      lowest_(kMostEnded / kBlock),
      rest_until_(kMostEnded),
      visited_in_(kMostEnded) {
  places_.reserve(kMostEnded);
  for (Walker& walker : walkers_) {
    walker.boxes.resize(kBoxes);
    walker.added.reserve(kMostEnded);
  }
}

void PatchFront::ToolBox::place(const PatchTree::Node& tool, const SweptMotion& motion) {
  const Vec3 arm = motion.orientation * tool.at();
  half = tool.half_size();
  half_lanes = lanes_of(half);
  for (int i = 0; i < 3; ++i) axes.col(i) = motion.orientation * tool.axis(i);
  for (int k = 0; k < 3; ++k) lanes[k] = lanes_of(axes.row(k).transpose());
  centre = motion.from.position + arm;
  displacement = motion.displacement(arm);
  displacement_lanes = along(lanes, lanes_of(displacement));
  const double radius = half.norm();
  const double length = arm.norm();
  still_slack = 0x1p-17 * radius + 0x1p-45 * (1.0 + length);  // the axes are orthonormal to 2^-20, and tests are in single precision
  slack = still_slack + motion.angle * radius + motion.sagitta * (length + radius) + 0x1p-20 * displacement.cwiseAbs().sum();
}

const PatchFront::ToolBox& PatchFront::placed(Walker& walker, std::uint32_t node, const SweptMotion& motion) const noexcept {
  ToolBox& box = walker.boxes[node % kBoxes];
  if (box.walk != walk_ || box.node != node) {
    box.place(tool_->nodes()[node], motion);
    box.walk = walk_;
    box.node = node;
  }
  return box;
}

bool PatchFront::is_end(Pair pair) const noexcept { return tool_->nodes()[pair.tool].is_leaf() && scene_->nodes()[pair.scene].is_leaf(); }

bool PatchFront::splits_tool(Pair pair) const noexcept {
  const PatchTree::Node& tool = tool_->nodes()[pair.tool];
  const PatchTree::Node& scene = scene_->nodes()[pair.scene];
  return !tool.is_leaf() && (scene.is_leaf() || tool.half[2] > scene.half[2]);
}

// In single precision, which the boxes are stored in. Only the vector between the boxes' centres is a difference of large numbers.
PatchFront::Apart PatchFront::test(const ToolBox& tool, const PatchTree::Node& scene, double clearance) noexcept {
  const Floats4 axes[3] = {lanes_at(scene.axes[0].data()), lanes_at(scene.axes[1].data()), lanes_at(scene.axes[2].data())};
  const Floats4 half = {scene.half[0], scene.half[1], scene.half[2], 0.0F};  // what follows them is no number
  const Vec3 difference = tool.centre - scene.at();
  const Floats4 between = lanes_of(difference);
  // The cosines between the axes of both; by axis of the tool, then of the scene.
  Floats4 cosines[3];
  for (int i = 0; i < 3; ++i) {
    cosines[i] = absolute(tool.lanes[0][i] * axes[0] + tool.lanes[1][i] * axes[1] + tool.lanes[2][i] * axes[2]);
  }
  // The sizes of each body's box along the other's axes.
  const Floats4 tool_size = cosines[0] * tool.half_lanes[0] + cosines[1] * tool.half_lanes[1] + cosines[2] * tool.half_lanes[2];
  const Floats4 scene_size = sums_of(cosines[0] * half, cosines[1] * half, cosines[2] * half);
  const Floats4 by_scene = along(axes, between);
  const Floats4 by_tool = along(tool.lanes, between);
  const Floats4 still_scene = absolute(by_scene) - (half + tool_size);
  const Floats4 still_tool = absolute(by_tool) - (tool.half_lanes + scene_size);
  const Floats4 moved_scene = still_scene + approach(by_scene, along(axes, lanes_of(tool.displacement)));
  const Floats4 moved_tool = still_tool + approach(by_tool, tool.displacement_lanes);
  // The axes are orthonormal to 2^-20. A sum of three products is rounded by at most 6 * 2^-24 of the sum of their sizes, and what is added
  // to it by as much again; tool.slack has what is the tool's.
  const double rounding =
      0x1p-17 * (static_cast<double>(scene.half[0]) + scene.half[1] + scene.half[2]) + 0x1p-20 * difference.cwiseAbs().sum();
  constexpr double kAxisLength = 1.0 - 0x1p-19;  // at least, with the rounding of the root
  // Gaps along axes that are at right angles add up.
  return {std::sqrt(std::max(squared(still_scene), squared(still_tool))) * kAxisLength - 2.0 * (rounding + tool.still_slack),
          largest_of(moved_scene, moved_tool) * kAxisLength - rounding - tool.slack > clearance};
}

void PatchFront::begin(const SweptMotion& motion, double distance) noexcept {
  const double rounding = 0x1p-45 * (1.0 + radius_);
  travelled_ +=
      (motion.from.position - at_.position).norm() + radius_ * turn_between(at_.orientation, motion.from.orientation).norm() + rounding;
  at_ = motion.from;
  ++walk_;
  for (Walker& walker : walkers_) {
    walker.added.clear();
    walker.tests = 0;
  }
  if (count_ == 0 || count_ > 2 * first_count_ + 64) begin_at_roots(motion, distance);
  find_places(-rounded_down(-(travelled_ + motion.shift.norm() + radius_ * motion.angle + distance + rounding)));
}

// A front has tens of thousands of pairs, and a walk begins at few of them.
void PatchFront::find_places(float enough) noexcept {
  places_.clear();
  // The room past the last pair counts as far away.
  std::fill(until_.begin() + count_, until_.begin() + (count_ + kLanes - 1) / kLanes * kLanes, std::numeric_limits<float>::infinity());
  for (std::size_t block = 0; block * kBlock < count_; ++block) {
    if (lowest_[block] > enough) continue;
    const std::size_t before = places_.size();
    Floats8 lowest = kFar;
    const std::size_t end = std::min((block + 1) * kBlock, count_);
    for (std::size_t i = block * kBlock; i < end; i += kLanes) {
      const Floats8 until = floats_at(&until_[i]);
      const std::size_t last = any_below(until, enough) ? std::min(i + kLanes, end) : i;
      for (std::size_t k = i; k < last; ++k) {
        if (until_[k] <= enough && (visited_in_[k] != epoch_ || rest_until_[k] <= enough)) places_.push_back(static_cast<std::uint32_t>(k));
      }
      lowest = lowest < until ? lowest : until;
    }
    // The walk changes what it begins at.
    lowest_[block] = places_.size() > before ? -std::numeric_limits<float>::infinity() : least_of(lowest);
  }
}

// The pairs a few levels below the roots, as if a walk had ended there.
void PatchFront::begin_at_roots(const SweptMotion& motion, double distance) noexcept {
  travelled_ = 0.0;
  first_count_ = 0;
  ended_[0] = {0, 0};
  count_ = 1;
  for (std::size_t before = 0; before != count_ && count_ < kFirst;) {
    before = count_;
    for (std::size_t i = 0; i < before; ++i) {
      const Pair pair = ended_[i];
      if (is_end(pair) || test(placed(walkers_[0], pair.tool, motion), scene_->nodes()[pair.scene], distance).over_motion) continue;
      const bool is_tool = splits_tool(pair);
      const std::uint32_t link = is_tool ? tool_->nodes()[pair.tool].link : scene_->nodes()[pair.scene].link;
      ended_[i] = is_tool ? Pair{link, pair.scene} : Pair{pair.tool, link};
      ended_[count_++] = is_tool ? Pair{link + 1, pair.scene} : Pair{pair.tool, link + 1};
    }
  }
  for (std::size_t i = 0; i < count_; ++i) put(i, {ended_[i], -1.0F, -1.0F, 0});
  std::fill(lowest_.begin(), lowest_.end(), -std::numeric_limits<float>::infinity());
}

PatchFront::End PatchFront::end_of(Pair pair, double distance, double rest, std::uint32_t place) const noexcept {
  return {pair, rounded_down(travelled_ + distance), rounded_down(travelled_ + rest), place};
}

void PatchFront::put(std::size_t i, const End& end) noexcept {
  ended_[i] = end.pair;
  until_[i] = end.until;
  rest_until_[i] = end.rest_until;
  visited_in_[i] = epoch_;
}

bool PatchFront::finish() noexcept {
  std::size_t tests = 0;
  std::size_t added = 0;
  for (const Walker& walker : walkers_) {
    tests += walker.tests;
    added += walker.added.size();
  }
  if (tests > kMostTests || count_ + added > kMostEnded) return false;
  for_each_by_place(
      walkers_, [](const Walker& walker) -> const std::vector<End>& { return walker.added; },
      [&](const End& end) {
        lowest_[count_ / kBlock] = std::min(lowest_[count_ / kBlock], end.until);
        put(count_++, end);
      });
  return true;
}

}  // namespace hapton
