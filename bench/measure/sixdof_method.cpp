#include "bench/measure/sixdof_method.h"

#include <fmt/core.h>

#include "core/tool/held_tool.h"
#include "core/tool/voxel_tool.h"
#include "runtime/worker_threads.h"

namespace hapton {
namespace {

class ProxyTool final : public SixdofMethod {
 public:
  explicit ProxyTool(std::unique_ptr<ToolStep> tool) : tool_(std::move(tool)) {}
  void reset(const Pose& X_SD) override { tool_->reset({X_SD}); }
  ToolOutput step(const Pose& X_SD) override { return tool_->step({X_SD}); }
  Placement placement(const ToolStep&) const override { return tool_->proxy().placement(); }

 private:
  std::unique_ptr<ToolStep> tool_;
};

class ForceTask final : public SixdofMethod {
 public:
  ForceTask(std::unique_ptr<ToolStep> tool, int every) : held_(std::move(tool)), samples_per_follow_(every) {}
  void reset(const Pose& X_SD) override {
    held_.begin_anew();
    held_.forget_motion();
    since_reset_ = 0;
    (void)step(X_SD);
    held_.follow();
  }
  ToolOutput step(const Pose& X_SD) override {
    ++samples_;
    ++since_reset_;
    return held_.step({X_SD}, samples_ * kSampleNs);
  }
  void follow() override {
    if (since_reset_ % samples_per_follow_ == 0) held_.follow();
  }
  Placement placement(const ToolStep&) const override { return held_.tool().proxy().placement(); }

 private:
  static constexpr std::int64_t kSampleNs = 1'000'000;  // 1 kHz

  HeldTool held_;
  std::int64_t samples_ = 0;  // samples since construction, the clock of the held tool
  std::int64_t since_reset_ = 0;
  std::int64_t samples_per_follow_;
};

class VoxelMethod final : public SixdofMethod {
 public:
  explicit VoxelMethod(std::unique_ptr<VoxelTool> tool) : tool_(std::move(tool)) {}
  void reset(const Pose& X_SD) override { tool_->reset({X_SD}); }
  ToolOutput step(const Pose& X_SD) override { return tool_->step({X_SD}); }
  Placement placement(const ToolStep& exact) const override {
    Pose X = Pose::Identity();
    X.translation() = tool_->placement().position;
    X.linear() = tool_->placement().orientation.toRotationMatrix();
    return local_placement(exact, X);
  }

 private:
  std::unique_ptr<VoxelTool> tool_;
};

}  // namespace

Placement local_placement(const ToolStep& exact, const Pose& X_SP) { return exact.to_local({X_SP}); }

SixdofMethodKind proxy_tool(int threads) {
  return {.name = threads > 1 ? fmt::format("proxy x{}", threads) : "proxy",
          .what = threads > 1 ? fmt::format("the same on {} threads", threads) : "the 6-DOF god-object of haptics_node --tool",
          .make = [threads](const SixdofScenario& scenario) -> Result<std::unique_ptr<SixdofMethod>> {
            auto tool = ToolStep::make(*scenario.tool, {scenario.scene}, scenario.coupling, {}, make_worker_team(threads));
            if (!tool) return tl::unexpected(tool.error());
            return std::make_unique<ProxyTool>(std::move(*tool));
          }};
}

SixdofMethodKind force_task(int every) {
  return {.name = every > 1 ? fmt::format("force, {} ms", every) : "force",
          .what = fmt::format(
              "the force of each sample from the contacts of the last pose, as haptics_node computes it, with a pose every {} ms; "
              "only the force is timed",
              every),
          .make = [every](const SixdofScenario& scenario) -> Result<std::unique_ptr<SixdofMethod>> {
            auto tool = ToolStep::make(*scenario.tool, {scenario.scene}, scenario.coupling);
            if (!tool) return tl::unexpected(tool.error());
            return std::make_unique<ForceTask>(std::move(*tool), every);
          }};
}

SixdofMethodKind voxel_tool(double voxel_m) {
  return {.name = fmt::format("voxels, {:.4g} mm", 1e3 * voxel_m),
          .what = "voxels and a shell of points (McNeely et al. 1999), quasi-static",
          .make = [voxel_m](const SixdofScenario& scenario) -> Result<std::unique_ptr<SixdofMethod>> {
            auto tool = VoxelTool::make(*scenario.tool, {scenario.scene}, scenario.coupling, voxel_m);
            if (!tool) return tl::unexpected(tool.error());
            return std::make_unique<VoxelMethod>(std::move(*tool));
          }};
}

}  // namespace hapton
