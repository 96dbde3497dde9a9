#include "core/tool/obb_front.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/tool/box_lanes.h"

namespace hapton {
namespace {

// How much a motion changes the distance |at| of something from zero, if it makes that smaller (a negative value); otherwise 0.
Lanes4 approach(const Lanes4& at, const Lanes4& motion) {
  const Lanes4 away = at < 0.0 ? -motion : motion;
  return detail::lane_min(away, Lanes4{});
}

// The sum of the squares of those of three lengths that are positive.
double squared(const Lanes4& lengths) {
  const Lanes4 positive = detail::lane_max(lengths, Lanes4{});
  const Lanes4 squares = positive * positive;
  return squares[0] + squares[1] + squares[2];
}

// The vector with the positive gaps as its parts along the axes; `at`: position of tool minus scene along the axes, for the signs.
Vec3 direction_of(const Lanes4 (&axes)[3], const Lanes4& gaps, const Lanes4& at) {
  const Lanes4 positive = detail::lane_max(gaps, Lanes4{});
  const Lanes4 along_axes = at < 0.0 ? -positive : positive;
  Vec3 direction;
  for (int k = 0; k < 3; ++k) {
    const Lanes4 part = along_axes * axes[k];
    direction[k] = part[0] + part[1] + part[2];
  }
  return direction;
}

double largest_of(const Lanes4& a, const Lanes4& b) {
  const Lanes4 both = detail::lane_max(a, b);
  return std::max({both[0], both[1], both[2]});
}

}  // namespace

ObbFront::ObbFront(const ObbTree& tool, const ObbTree& scene, double radius, WorkerTeam& team)
    : tool_(&tool),
      scene_(&scene),
      radius_(radius),
      team_(&team),
      walkers_(static_cast<std::size_t>(team.size())),
      front_pairs_(kMaxFrontPairs),
      until_(kMaxFrontPairs / SeparatingPlanes::kTogether),
      block_bounds_(kMaxFrontPairs / kBlock),
      rest_until_(kMaxFrontPairs),
      visited_in_(kMaxFrontPairs),
      near_(kMaxFrontPairs),
      planes_(kMaxFrontPairs, radius) {
  places_.reserve(kMaxFrontPairs);
  for (Walker& walker : walkers_) {
    walker.boxes.resize(kCachedBoxes);
    walker.added.reserve(kMaxFrontPairs);
  }
}

void ObbFront::ToolBox::place(const ObbTree::Node& tool, const LinearizedMotion& motion) {
  const Vec3 arm = motion.orientation * tool.at();
  half = tool.half_size();
  half_lanes = lanes_of(half);
  for (int i = 0; i < 3; ++i) axes.col(i) = motion.orientation * tool.axis(i);
  for (int k = 0; k < 3; ++k) lanes[k] = lanes_of(axes.row(k).transpose());
  centre = motion.from.position + arm;
  displacement = motion.displacement(arm);
  displacement_lanes = along(lanes, displacement);
  const double radius = half.norm();
  const double length = arm.norm();
  still_slack = 0x1p-18 * radius + 0x1p-45 * (1.0 + length);  // the axes are orthonormal within 2^-20
  slack = still_slack + motion.angle * radius + motion.sagitta * (length + radius);
}

const ObbFront::ToolBox& ObbFront::placed(Walker& walker, std::uint32_t node, const LinearizedMotion& motion) const noexcept {
  ToolBox& box = walker.boxes[node % kCachedBoxes];
  if (box.walk != walk_ || box.node != node) {
    box.place(tool_->nodes()[node], motion);
    box.walk = walk_;
    box.node = node;
  }
  return box;
}

bool ObbFront::is_end(Pair pair) const noexcept { return tool_->nodes()[pair.tool].is_leaf() && scene_->nodes()[pair.scene].is_leaf(); }

bool ObbFront::splits_tool(Pair pair) const noexcept {
  const ObbTree::Node& tool = tool_->nodes()[pair.tool];
  const ObbTree::Node& scene = scene_->nodes()[pair.scene];
  return !tool.is_leaf() && (scene.is_leaf() || tool.half[2] > scene.half[2]);
}

ObbFront::BoxGap ObbFront::test(const ToolBox& tool, const ObbTree::Node& scene, double clearance, bool wants_direction) noexcept {
  const Lanes4 axes[3] = {lanes_at(scene.axes[0].data()), lanes_at(scene.axes[1].data()), lanes_at(scene.axes[2].data())};
  const Vec3 half = scene.half_size();
  const Vec3 between = tool.centre - scene.at();
  // The sizes of each body's box along the other's axes.
  Lanes4 tool_size{};
  Lanes4 scene_size{};
  for (int i = 0; i < 3; ++i) {
    tool_size += absolute(along(axes, tool.axes.col(i))) * tool.half[i];
    scene_size += absolute(along(tool.lanes, scene.axis(i))) * half[i];
  }
  const Lanes4 by_scene = along(axes, between);
  const Lanes4 by_tool = along(tool.lanes, between);
  const Lanes4 still_scene = absolute(by_scene) - (lanes_of(half) + tool_size);
  const Lanes4 still_tool = absolute(by_tool) - (tool.half_lanes + scene_size);
  const Lanes4 moved_scene = still_scene + approach(by_scene, along(axes, tool.displacement));
  const Lanes4 moved_tool = still_tool + approach(by_tool, tool.displacement_lanes);
  // The axes are orthonormal within 2^-20, coordinates are about 1.
  const double rounding = 0x1p-18 * half.sum() + 0x1p-45 * between.cwiseAbs().sum();
  constexpr double kAxisLength = 1.0 - 0x1p-20;  // least length of an axis
  // The squares of gaps along perpendicular axes add up.
  BoxGap box_gap{std::sqrt(std::max(squared(still_scene), squared(still_tool))) * kAxisLength - 2.0 * (rounding + tool.still_slack),
                 largest_of(moved_scene, moved_tool) * kAxisLength - rounding - tool.slack > clearance, Vec3::Zero()};
  if (wants_direction && box_gap.is_apart_over_motion) {
    box_gap.direction = squared(moved_scene) > squared(moved_tool) ? direction_of(axes, moved_scene, by_scene)
                                                                   : direction_of(tool.lanes, moved_tool, by_tool);
  }
  return box_gap;
}

void ObbFront::begin(const LinearizedMotion& motion, double distance) noexcept {
  const double rounding = 0x1p-45 * (1.0 + radius_);
  const double turned = turn_between(last_start_.orientation, motion.from.orientation).norm();
  travelled_ += (motion.from.position - last_start_.position).norm() + radius_ * turned + rounding;
  last_start_ = motion.from;
  ++walk_;
  for (Walker& walker : walkers_) {
    walker.added.clear();
    walker.tests = 0;
  }
  const bool is_at_roots = count_ == 0 || count_ > 2 * first_count_ + 64;
  if (is_at_roots) begin_at_roots(motion, distance);
  planes_.begin(motion, turned + 0x1p-45);
  find_places(float_at_least(travelled_ + motion.shift.norm() + radius_ * motion.angle + distance + rounding), float_at_least(distance));
}

// A front has tens of thousands of pairs; a walk begins at few of them. It leaves out pairs for which the tool has not travelled far enough
// to come near, and pairs with a stored plane that separates the boxes over the motion.
void ObbFront::find_places(float max_travel, float clearance) noexcept {
  constexpr std::size_t kLanes = SeparatingPlanes::kTogether;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const Float8 travelled(float_at_most(travelled_));
  places_.clear();
  max_travel_ = max_travel;
  for (std::size_t block = 0; block * kBlock < count_; ++block) {
    if (block_bounds_[block] > max_travel) continue;
    const std::size_t before = places_.size();
    Float8 lowest(kInfinity);
    const std::size_t end = std::min((block + 1) * kBlock, count_);
    for (std::size_t first = block * kBlock; first < end; first += kLanes) {
      float* const bounds = until_[first / kLanes].of.data();
      Float8 until = Float8::load(bounds);
      unsigned low = sign_bits(until <= Float8(max_travel));
      if (low != 0) {
        const SeparatingPlanes::Gaps gaps = planes_.find_gaps(first / kLanes);
        until = max((travelled + gaps.start) * Float8(1.0F - 0x1p-22F), until);
        store(bounds, until);
        low = sign_bits(until <= Float8(max_travel)) & ~sign_bits(gaps.over > Float8(clearance));
      }
      lowest = min(lowest, until);
      if (end - first < kLanes) low &= (1U << (end - first)) - 1U;
      for (; low != 0; low &= low - 1U) {
        const std::size_t i = first + static_cast<std::size_t>(std::countr_zero(low));
        if (visited_in_[i] != epoch_ || rest_until_[i] <= max_travel) places_.push_back(static_cast<std::uint32_t>(i));
      }
    }
    // The walk changes the bounds of the pairs at which it begins, so the block's bound is not known yet.
    block_bounds_[block] = -kInfinity;
    if (places_.size() > before) continue;
    block_bounds_[block] = kInfinity;
    for (int lane = 0; lane < static_cast<int>(kLanes); ++lane) block_bounds_[block] = std::min(block_bounds_[block], lowest[lane]);
  }
}

// Starts the front with the pairs a few levels below the roots, as if a walk had ended at these.
void ObbFront::begin_at_roots(const LinearizedMotion& motion, double distance) noexcept {
  travelled_ = 0.0;
  first_count_ = 0;
  planes_.restart(motion.from);
  front_pairs_[0] = {0, 0};
  count_ = 1;
  for (std::size_t before = 0; before != count_ && count_ < kMinFirstPairs;) {
    before = count_;
    for (std::size_t i = 0; i < before; ++i) {
      const Pair pair = front_pairs_[i];
      if (is_end(pair) || test(placed(walkers_[0], pair.tool, motion), scene_->nodes()[pair.scene], distance).is_apart_over_motion)
        continue;
      const bool is_tool = splits_tool(pair);
      const std::uint32_t link = is_tool ? tool_->nodes()[pair.tool].link : scene_->nodes()[pair.scene].link;
      front_pairs_[i] = is_tool ? Pair{link, pair.scene} : Pair{pair.tool, link};
      front_pairs_[count_++] = is_tool ? Pair{link + 1, pair.scene} : Pair{pair.tool, link + 1};
    }
  }
  for (std::size_t i = 0; i < count_; ++i) put(i, {front_pairs_[i], -1.0F, -1.0F, 0, 0});
  std::fill(block_bounds_.begin(), block_bounds_.end(), -std::numeric_limits<float>::infinity());
}

ObbFront::End ObbFront::end_of(Pair pair, double distance, double rest, std::uint32_t place, std::uint64_t visited_in) const noexcept {
  constexpr double kFar = 0x1p100;  // a visitor to whom a pair does not matter gives an infinite distance; bounds are finite
  return {pair, float_at_most(travelled_ + std::min(distance, kFar)), float_at_most(travelled_ + std::min(rest, kFar)), place, visited_in};
}

void ObbFront::put(std::size_t i, const End& end) noexcept {
  front_pairs_[i] = end.pair;
  until(i) = end.until;
  rest_until_[i] = end.rest_until;
  visited_in_[i] = end.visited_in;
  near_[i] = end.near;
  planes_.clear(i);
  put_plane(i, end);
}

void ObbFront::put_again(std::size_t i, const End& end) noexcept {
  until(i) = std::max(until(i), end.until);
  // Each bound leaves out other near features: the larger one holds for the features that both of them include.
  const bool is_again = visited_in_[i] == epoch_;
  rest_until_[i] = is_again ? std::max(rest_until_[i], end.rest_until) : end.rest_until;
  near_[i] = static_cast<std::uint16_t>(is_again ? near_[i] | end.near : end.near);
  visited_in_[i] = end.visited_in;
  put_plane(i, end);
}

void ObbFront::put_plane(std::size_t i, const End& end) noexcept {
  if (end.has_plane) planes_.put(i, end.normal, end.along_normal, tool_->nodes()[end.pair.tool]);
}

bool ObbFront::finish() noexcept {
  std::size_t tests = 0;
  std::size_t added = 0;
  for (const Walker& walker : walkers_) {
    tests += walker.tests;
    added += walker.added.size();
  }
  if (tests > kMaxTests || count_ + added > kMaxFrontPairs) return false;
  for_each_by_place(
      walkers_, [](const Walker& walker) -> const std::vector<End>& { return walker.added; },
      [&](const End& end) {
        block_bounds_[count_ / kBlock] = std::min(block_bounds_[count_ / kBlock], end.until);
        put(count_++, end);
      });
  return true;
}

}  // namespace hapton
