#include "tools/bench/tool_stress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <random>
#include <utility>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "core/tool/penetration_check.h"
#include "core/tool/tool_step.h"

namespace hapton {
namespace {

constexpr std::uint64_t kEpisodeSteps = 250;  // steps of one motion; a free choice

// The seed depends on the names, so that a body that is tested alone gets the same motions as among others. FNV-1a.
std::uint64_t seed_of(std::uint64_t seed, const std::string& body, const std::string& tool) {
  std::uint64_t hash = 0xCBF29CE484222325U ^ seed;
  for (const char c : body + "/" + tool) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3U;
  return hash;
}

struct StressTool {
  std::string name;
  TriangleMesh mesh;  // for a body whose longest side is 1
};

std::vector<StressTool> make_tools() {
  const double tan_half_angle = std::tan(0.5 * 3.0 * 3.14159265358979 / 180.0);
  return {{"ball", make_icosphere(0.08, 2)},
          {"box", make_box({0.15, 0.1, 0.2}, 2)},
          {"plate", make_thin_wall(0.25, 1e-3, 3)},
          {"wedge", make_prism({{0.0, 0.0}, {0.2, -0.2 * tan_half_angle}, {0.2, 0.2 * tan_half_angle}}, 0.15, 2)},
          {"rod", make_cylinder(0.01, 0.4, 12, 4)},
          {"bracket", make_prism({{0.0, 0.0}, {0.2, 0.0}, {0.2, 0.05}, {0.05, 0.05}, {0.05, 0.2}, {0.0, 0.2}}, 0.1, 2)}};
}

constexpr std::uint64_t kInsideEvery = 4;  // one of so many episodes begins inside the body; which one depends on body, tool and seed

// The episodes of one tool on one body at one scale.
class ToolEpisodes {
 public:
  ToolEpisodes(ToolStep& step, double size, std::uint64_t seed) : step_(step), size_(size), random_(seed) {
    checks_.push_back(std::make_unique<PenetrationCheck>(step.tool(), step.scene()));
    for (std::size_t p = 0; p < step.moving_count(); ++p) {
      checks_.push_back(std::make_unique<PenetrationCheck>(step.tool(), step.moving(p)));
    }
  }

  // The lengths here are shares of the body's longest side; like the angles and shares of chance, they are free choices.
  void run(bool begins_inside, ToolStressCount& count) {
    Pose device = Pose::Identity();
    device.translation() = size_ * (begins_inside ? 0.2 : 1.4) * draw_vector().normalized();
    device.linear() = turn_by(3.0 * draw_vector()).toRotationMatrix();
    X_SO_ = Pose::Identity();
    step_.reset(input(device));
    const double speed = size_ * std::pow(10.0, -3.5 + 2.0 * uniform(0.0, 1.0));  // metres per step
    const double turn = 0.05 * std::pow(uniform(0.0, 1.0), 2.0);                  // radians per step; up to 50 rad/s at 1 kHz
    const double jitter = uniform(0.0, 1.0) < 0.3 ? uniform(0.0, 2.0) : 0.1;
    const Vec3 axis = draw_vector().normalized();
    Vec3 direction = -device.translation().normalized();
    count.overlaps += step_.step(input(device)).proxy.is_blocked ? 1 : 0;
    // One step takes the tool close to the body; it touches nothing on the way.
    if (!begins_inside) device.translation() *= 0.7;
    for (std::uint64_t n = 0; n < kEpisodeSteps; ++n) {
      if (n % 50 == 49) direction = (direction + 0.7 * draw_vector()).normalized();
      device.translation() += speed * (direction + jitter * draw_vector());
      device.linear() = turn_by(turn * (axis + jitter * draw_vector())).toRotationMatrix() * device.linear();
      device.linear() = Quat(device.linear()).normalized().toRotationMatrix();
      move_body(speed, turn, jitter);
      evaluate(step_.step(input(device)), count);
    }
    // Far away from the body, an overlap of the beginning must end.
    device.translation() = size_ * 3.0 * axis;
    step_.step(input(device));
    for (int n = 0; n < 50; ++n) {
      device.translation() += 1e-3 * size_ * axis;
      if (!step_.step(input(device)).proxy.is_blocked) return;
    }
    ++count.stuck;
  }

 private:
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vec3 draw_vector() { return {uniform(-1.0, 1.0), uniform(-1.0, 1.0), uniform(-1.0, 1.0)}; }

  ToolInput input(const Pose& device) const { return {.X_WD = device, .X_SO = {&X_SO_, step_.moving_count()}}; }

  // The body moves at random about the place where it began, more slowly than the device.
  void move_body(double speed, double turn, double jitter) {
    if (step_.moving_count() == 0) return;
    X_SO_.translation() += 0.5 * speed * (draw_vector() - X_SO_.translation() / (0.3 * size_));
    X_SO_.linear() = turn_by(0.5 * turn * (Vec3::UnitZ() + jitter * draw_vector())).toRotationMatrix() * X_SO_.linear();
    X_SO_.linear() = Quat(X_SO_.linear()).normalized().toRotationMatrix();
  }

  // The placement of the tool relative to the part, with the part at the pose with which the tool's force was computed.
  Placement placement_relative_to(std::size_t part) const {
    const Placement& at = step_.proxy().placement();
    return part == 0 ? at : step_.proxy().part_placement(part - 1).inverse() * at;
  }

  void evaluate(const ToolOutput& out, ToolStressCount& count) {
    ++count.steps;
    if (!out.force_n.allFinite() || !out.torque_nm.allFinite() || !out.X_WP.matrix().allFinite()) ++count.not_finite;
    if (out.proxy.is_blocked) return;
    count.contact_steps += out.contact ? 1 : 0;
    count.unconverged += out.proxy.converged ? 0 : 1;
    count.squeezed += out.proxy.is_squeezed ? 1 : 0;
    for (std::size_t p = 0; p < checks_.size(); ++p) {
      // The smallest gap that ToolProxy allows, less 2^-12 of it for rounding.
      constexpr double kMinAllowedGap = (1.0 - 0x1p-12) * ToolProxy::kMinGap * ToolProxy::kContactOffset;
      if (checks_[p]->penetrates(placement_relative_to(p))) {
        ++count.penetrations;
      } else if (checks_[p]->find_gap(placement_relative_to(p), ToolProxy::kContactOffset) < kMinAllowedGap) {
        ++count.too_near;
      }
    }
  }

  ToolStep& step_;
  std::vector<std::unique_ptr<PenetrationCheck>> checks_;  // for the objects that stand still, then for each moving part
  Pose X_SO_ = Pose::Identity();                           // pose of the body, if it moves
  double size_;                                            // longest side of the body
  std::mt19937_64 random_;
};

Result<void> stress_tool(const StressBody& body, const StressTool& tool, double scale, const CoulombFriction& friction,
                         std::uint64_t episodes, const ToolStressPlan& plan, ToolStressCount& count) {
  const double side = compute_bounds(body.touched).extent();
  std::vector<std::shared_ptr<const TriangleMesh>> scene = {
      std::make_shared<TriangleMesh>(scaled_and_moved(body.touched, scale, Vec3::Zero()))};
  std::vector<int> parts;
  if (plan.moving) {
    const Vec3 beside = 1.2 * scale * side * Vec3::UnitX();
    scene.push_back(std::make_shared<TriangleMesh>(scaled_and_moved(make_icosphere(0.4 * scale * side, 2), 1.0, beside)));
    parts = {1, 0};
  }
  const std::vector<CoulombFriction> frictions(scene.size(), friction);
  auto step = ToolStep::make(scaled_and_moved(tool.mesh, scale * side, Vec3::Zero()), std::move(scene), {}, frictions, nullptr, parts);
  if (!step) return tl::unexpected(step.error());
  const std::uint64_t seed = seed_of(plan.seed, body.name, tool.name);
  ToolEpisodes run(**step, scale * side, seed);
  for (std::uint64_t episode = 0; episode < episodes; ++episode) {
    const std::uint64_t before = count.faults();
    run.run((episode + seed) % kInsideEvery == 0, count);
    if (before > 0 || count.faults() == 0) continue;
    count.first_fault = fmt::format("tool {}, scale {:g}, friction {:g}, episode {}", tool.name, scale, friction.friction_static, episode);
  }
  return {};
}

}  // namespace

Result<std::vector<ToolStressResult>> run_tool_stress(const std::vector<StressBody>& bodies, const ToolStressPlan& plan,
                                                      const std::function<void(const ToolStressResult&)>& progress) {
  const std::vector<StressTool> tools = make_tools();
  const std::uint64_t runs = bodies.size() * tools.size() * plan.scales.size() * plan.frictions.size();
  const std::uint64_t episodes = std::max<std::uint64_t>(1, (plan.steps + runs * kEpisodeSteps - 1) / (runs * kEpisodeSteps));
  std::vector<ToolStressResult> results;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    ToolStressResult result{.body = bodies[b].name, .count = {}};
    for (std::size_t t = 0; t < tools.size(); ++t) {
      for (const double scale : plan.scales) {
        for (const CoulombFriction& friction : plan.frictions) {
          if (const auto run = stress_tool(bodies[b], tools[t], scale, friction, episodes, plan, result.count); !run) {
            return tl::unexpected(run.error());
          }
        }
      }
    }
    progress(result);
    results.push_back(std::move(result));
  }
  return results;
}

std::string to_text(const std::vector<ToolStressResult>& results) {
  std::string text = fmt::format("{:<28} {:>9} {:>9} {:>9} {:>9} | {:>9} {:>9} {:>9} {:>9} {:>9}\n", "body", "pene-", "too", "not", "stuck",
                                 "steps", "in", "uncon-", "no", "begun in");
  text += fmt::format("{:<28} {:>9} {:>9} {:>9} {:>9} | {:>9} {:>9} {:>9} {:>9} {:>9}\n", "", "trations", "near", "finite", "", "",
                      "contact", "verged", "room", "overlap");
  for (const ToolStressResult& result : results) {
    const ToolStressCount& count = result.count;
    fmt::format_to(std::back_inserter(text), "{:<28} {:>9} {:>9} {:>9} {:>9} | {:>9} {:>9} {:>9} {:>9} {:>9}\n", result.body,
                   count.penetrations, count.too_near, count.not_finite, count.stuck, count.steps, count.contact_steps, count.unconverged,
                   count.squeezed, count.overlaps);
    if (!count.first_fault.empty()) fmt::format_to(std::back_inserter(text), "  first: {}\n", count.first_fault);
  }
  return text +
         "penetrations: steps in which a triangle of the tool intersects the body, by exact signs. too near: below half the contact "
         "offset. "
         "stuck: an overlap at the start that still blocks outside. unconverged: what is left of the motion is made in the next steps. "
         "no room: between a body that moves and one that stands still; the first is felt behind.\n";
}

}  // namespace hapton
