#include "bench/frames/frames_run.h"

#include <ctime>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "bench/frames/plain_vtk_view.h"
#include "runtime/clock.h"
#include "runtime/latency_histogram.h"
#include "vision_node/knob_box.h"
#include "vision_node/stereo_view.h"

namespace hapton {
namespace {

constexpr PictureSize kWindow{1280, 720};                             // pixels, size of the window; a free choice
constexpr double kDegreesPerFrame = 3.0;                              // turn of the dial y; a free choice
constexpr std::int64_t kLongestWaitNs = 120 * kNanosecondsPerSecond;  // limit of the wait for the levels of detail; a free choice

std::int64_t cpu_time_ns() {
  std::timespec t = {};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return t.tv_sec * kNanosecondsPerSecond + t.tv_nsec;
}

// Measures the frames of one program: their wall-clock time and the CPU time of the process.
class Meter {
 public:
  explicit Meter(const Clock& clock) : clock_(clock) {}

  template <class Draw>
  void time(Draw&& draw) {
    const std::int64_t cpu_ns = cpu_time_ns();
    const std::int64_t start_ns = clock_.now_ns();
    draw();
    const std::int64_t took_ns = clock_.now_ns() - start_ns;
    times_.record(took_ns);
    wall_ns_ += took_ns;
    cpu_ns_ += cpu_time_ns() - cpu_ns;
    ++frames_;
  }

  FramesRate rate() const {
    const double frames = std::max(1, frames_);
    return {frames * 1e9 / static_cast<double>(std::max<std::int64_t>(1, wall_ns_)), times_.quantile_ns(0.5) * 1e-6,
            times_.quantile_ns(0.99) * 1e-6, static_cast<double>(cpu_ns_) * 1e-6 / frames};
  }

 private:
  const Clock& clock_;
  LatencyHistogram times_;
  std::int64_t wall_ns_ = 0;
  std::int64_t cpu_ns_ = 0;
  int frames_ = 0;
};

ViewSettings settings_for(const TriangleMesh& mesh, bool offscreen) {
  double radius = 0.0;
  for (const Vec3& p : mesh.vertices) radius = std::max(radius, p.norm());
  ViewSettings settings;
  settings.stereo = StereoMode::side_by_side;
  settings.width_px = kWindow.width_px;
  settings.height_px = kWindow.height_px;
  settings.offscreen = offscreen;
  settings.framing = frame_sphere(Vec3::Zero(), radius, kEyeDistance);
  return settings;
}

ProbeShown probe_at(double phase) {
  ProbeShown probe;
  probe.p_WP = 0.05 * Vec3(std::cos(phase), std::sin(phase), 1.0);
  probe.force_n = Vec3(0.0, 0.0, 1.0 + std::sin(phase));
  probe.contact = true;
  return probe;
}

void draw_turned(StereoView& view, const Dials& dials, int frame) {
  view.set_scene_pose(dials.compute_pose(Vec3::Zero()));
  view.set_probe(probe_at(0.05 * frame));
  view.poll_events();
  view.draw();
}

}  // namespace

Result<FramesRow> run_frames(const FramesMesh& mesh, const FramesSettings& settings) {
  SteadyClock clock;
  FramesRow row;
  row.mesh = mesh.name;
  row.triangles = mesh.mesh->triangles.size();
  const ViewSettings ours = settings_for(*mesh.mesh, settings.offscreen);
  const std::int64_t begin_ns = clock.now_ns();
  auto view = StereoView::open(ours, {{mesh.mesh, {0.7, 0.7, 0.72}}});
  if (!view) return tl::unexpected(view.error());
  (*view)->draw();
  row.first_frame_ms = static_cast<double>(clock.now_ns() - begin_ns) * 1e-6;
  while ((*view)->detail_progress() < 1.0 && clock.now_ns() - begin_ns < kLongestWaitNs) clock.sleep_until_ns(clock.now_ns() + 5'000'000);
  row.levels_s = static_cast<double>(clock.now_ns() - begin_ns) * 1e-9;
  auto plain = PlainVtkView::open(*mesh.mesh, ours.framing, kWindow, settings.offscreen);
  if (!plain) return tl::unexpected(plain.error());
  (*view)->set_hud("servo 1000 Hz   round trip p50 30  p99 60 us\nforce 1.00 N   touching\n60 frames/s", "x X y Y z Z dials");
  Dials dials;
  draw_turned(**view, dials, 0);
  (*plain)->draw();

  Meter plain_meter(clock);
  Meter our_meter(clock);
  for (int frame = 0; frame < settings.frames; frame += settings.block) {
    const Dials from = dials;
    for (int i = 0; i < settings.block; ++i) {
      dials.turn(1, kDegreesPerFrame);
      plain_meter.time([&] {
        (*plain)->set_scene_pose(dials.compute_pose(Vec3::Zero()));
        (*plain)->draw();
      });
    }
    dials = from;
    for (int i = 0; i < settings.block; ++i) {
      dials.turn(1, kDegreesPerFrame);
      our_meter.time([&] { draw_turned(**view, dials, frame + i); });
    }
  }
  row.plain = plain_meter.rate();
  row.hapton = our_meter.rate();
  row.shown_triangles = (*view)->paint_count().triangles;
  row.error_px = (*view)->paint_count().largest_error_px;
  Meter probe_meter(clock);
  for (int frame = 0; frame < settings.frames; ++frame) probe_meter.time([&] { draw_turned(**view, dials, frame); });
  row.probe_hz = probe_meter.rate().hz;
  row.probe_cpu_ms = probe_meter.rate().cpu_ms;
  return row;
}

std::string describe_frames(const std::vector<FramesRow>& rows) {
  std::string text =
      "two eyes, 1280 x 720; the scene turns from frame to frame; plain: VTK alone, two renderers, same mesh, same eyes\n"
      "mesh            triangles   plain VTK            Hapton               ratio   level      error   first  levels   probe alone\n"
      "                            Hz    p99 ms  CPU ms   Hz    p99 ms  CPU ms           triangles  px      ms     s        Hz\n";
  for (const FramesRow& r : rows) {
    text += fmt::format(
        "{:<15} {:>9}   {:>5.1f} {:>7.1f} {:>7.1f}   {:>5.1f} {:>7.1f} {:>7.1f} {:>6.1f}x   {:>9}  {:>5.2f}  {:>5.0f}  {:>5.1f}   "
        "{:>8.1f}\n",
        r.mesh, r.triangles, r.plain.hz, r.plain.p99_ms, r.plain.cpu_ms, r.hapton.hz, r.hapton.p99_ms, r.hapton.cpu_ms, r.ratio(),
        r.shown_triangles, r.error_px, r.first_frame_ms, r.levels_s, r.probe_hz);
  }
  return text;
}

std::string frames_csv(const std::vector<FramesRow>& rows) {
  std::string text =
      "mesh,triangles,plain_hz,plain_p50_ms,plain_p99_ms,plain_cpu_ms,hapton_hz,hapton_p50_ms,hapton_p99_ms,hapton_cpu_ms,ratio,"
      "level_triangles,level_error_px,first_frame_ms,levels_s,probe_hz,probe_cpu_ms\n";
  for (const FramesRow& r : rows) {
    text +=
        fmt::format("{},{},{:.2f},{:.2f},{:.2f},{:.2f},{:.2f},{:.2f},{:.2f},{:.2f},{:.2f},{},{:.3f},{:.1f},{:.2f},{:.2f},{:.2f}\n", r.mesh,
                    r.triangles, r.plain.hz, r.plain.p50_ms, r.plain.p99_ms, r.plain.cpu_ms, r.hapton.hz, r.hapton.p50_ms, r.hapton.p99_ms,
                    r.hapton.cpu_ms, r.ratio(), r.shown_triangles, r.error_px, r.first_frame_ms, r.levels_s, r.probe_hz, r.probe_cpu_ms);
  }
  return text;
}

}  // namespace hapton
