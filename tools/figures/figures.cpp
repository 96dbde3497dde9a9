#include "tools/figures/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <memory>
#include <optional>

#include "core/collision/fdh_directions.h"
#include "core/collision/swept_sphere.h"
#include "core/force/force_method.h"
#include "core/force/smooth/smooth_force.h"
#include "core/force/smooth/smooth_scene.h"
#include "core/geometry/mesh_shapes.h"
#include "tools/figures/drawing.h"

namespace hapton {
namespace figures {
namespace {

// --- sweep: figure 4 of the memo -------------------------------------------------------------------------------------------------

Result<Figure> draw_sweep() {
  const Outline outline = {{-0.006, -0.004}, {0.012, -0.004}, {0.012, 0.0}, {-0.006, 0.0}};
  MethodSettings settings;
  settings.name = "sweep";
  settings.offset_m = 0.0008;  // 60 times the memo's offset, so that the picture shows it
  const auto samples = follow(settings, scene_of(make_prism(outline, 0.03, 1)),
                              {at(-4.5, 2.0), at(-2.5, -1.6), at(0.0, -1.6), at(2.5, -1.6), at(5.0, -1.6), at(7.5, -1.6)});
  if (!samples) return tl::unexpected(samples.error());
  Points lines, devices, collisions, offsets, visuals, forces;
  Vec3 start = samples->front().device;
  for (std::size_t i = 1; i < samples->size(); ++i) {
    const Sample& s = (*samples)[i];
    lines.add(start, s.device - start);
    devices.add(s.device);
    collisions.add(s.output.p_SP);
    visuals.add(s.device, s.output.p_SP - s.device);
    const Vec3 direction = s.output.force_n.normalized();
    forces.add(s.device, direction * s.output.force_n.norm() / Material{}.stiffness_n_per_m);
    start = s.output.p_SP + settings.offset_m * direction;
    offsets.add(s.output.p_SP, start - s.output.p_SP);
  }
  std::string script = begin("sweep", 1000, 540) + outline_of(outline).block("solid") + lines.block("lines") + devices.block("devices") +
                       collisions.block("collisions") + offsets.block("offsets") + visuals.block("visuals") + forces.block("forces");
  script += fmt::format(
      "set title 'sweep: each line starts one offset above the last collision point, so the point lags behind the probe'\n"
      "set size ratio -1\n"
      "set xrange [-5.2:9]\n"
      "set yrange [-2.6:2.4]\n"
      "set xlabel 'mm' offset 0,0.4\n"
      "set label 1 'p_{{t-1}}' at -4.4,2.1\n"
      "set label 2 'p_t' at -2.6,-2.0 front\n"
      "plot $solid with filledcurves closed fillcolor rgb '{0}' notitle, $solid with lines linecolor rgb '#404040' linewidth 2 notitle, "
      "\\\n $forces using 1:2:3:4 with vectors head filled size 0.18,18 linewidth 3 linecolor rgb '#f0b070' title 'force / k: height under "
      "the plane', \\\n $visuals using 1:2:3:4 with vectors nohead linewidth 9 linecolor rgb '#b8c8e8' title 'visual offset', \\\n $lines "
      "using 1:2:3:4 with vectors head filled size 0.2,15 linewidth 2 linecolor rgb '{1}' title 'sweep line', \\\n $offsets using 1:2:3:4 "
      "with vectors nohead linewidth 5 linecolor rgb '{2}' title 'offset vector (60 times as long as the memo''s)', \\\n $collisions with "
      "points pointtype 7 pointsize 1.5 linecolor rgb '{3}' title 'collision point', \\\n $devices with points pointtype 7 pointsize 1.5 "
      "linecolor rgb 'black' title 'probe'\n",
      kSolid, kBlue, kGreen, kRed);
  return Figure{"sweep", script};
}

// --- Algorithm 1: edge planes and VCPs --------------------------------------------------------------------------------------------

Result<Figure> draw_algorithm_1() {
  Outline outline;
  for (int degree = 15; degree <= 165; degree += 30)
    outline.emplace_back(0.02 * std::cos(degree * kPi / 180), 0.02 * std::sin(degree * kPi / 180) - 0.008);
  const auto scene = SmoothScene::build(scene_of(make_prism(outline, 0.05, 1)), {});
  if (!scene) return tl::unexpected(scene.error());
  constexpr double kRadius = 0.006;  // metres; RADIUS of the FDH paper, chosen for this figure
  Points planes, smooth, probes, vcps, flat;
  for (std::size_t i = 1; i + 1 < outline.size(); ++i) {  // plane R_i in the cross-section: a line from edge i along its vertex normal n_i
    const Eigen::Vector2d n = ((outline[i] - outline[i - 1]).normalized() + (outline[i + 1] - outline[i]).normalized()).normalized();
    const Vec3 start(outline[i].x(), outline[i].y(), 0.0);
    planes.line(start, start + 0.0085 * Vec3(n.y(), -n.x(), 0.0));
  }
  for (double degree = 48; degree <= 132; degree += 4) {
    const Vec3 P(0.0235 * std::cos(degree * kPi / 180), 0.0235 * std::sin(degree * kPi / 180) - 0.008, kSlice);
    SmoothForceSum sum(P, kRadius);
    scene->for_each_near(FdhBall{P, kRadius}, [&](const SetTriangle& t) { sum.add(t); });
    const SmoothForce force = sum.combine(kRadius, std::array{Material{}});
    if (force.away.isZero(0.0)) continue;
    probes.add(P);
    vcps.add(force.D);
    smooth.add(force.D, P - force.D);
    const SetTriangle* nearest = nullptr;
    double least = 1.0;
    std::vector<SetTriangle> kept;
    scene->for_each_near(FdhBall{P, kRadius}, [&](const SetTriangle& t) { kept.push_back(t); });
    for (const SetTriangle& t : kept) {
      const Separation s = separation_from_triangle(P, t.corner[0], t.corner[1], t.corner[2]);
      if (t.kind != SurfaceKind::face || s.distance >= least) continue;
      least = s.distance;
      nearest = &t;
    }
    if (nearest != nullptr) flat.add(P, 0.0035 * nearest->face_normal);
  }
  std::string script = begin("algorithm1", 1000, 660) + outline_of(outline).block("solid") + planes.block("planes") +
                       smooth.block("smooth") + probes.block("probes") + vcps.block("vcps") + flat.block("flat");
  script += fmt::format(
      "set title 'Algorithm 1 over a faceted ridge: n turns smoothly where a face''s own normal jumps'\n"
      "set size ratio -1\n"
      "set xrange [-19:19]\n"
      "set yrange [2:21]\n"
      "set xlabel 'mm' offset 0,0.4\n"
      "set label 1 'R_i' at -7.9,19.6 textcolor rgb '{2}'\n"
      "set label 2 'R_{{i+1}}' at 7.6,19.6 textcolor rgb '{2}'\n"
      "set label 3 'T' at -0.3,10.2 font 'sans,16'\n"
      "plot $solid with filledcurves closed fillcolor rgb '{0}' notitle, $solid with linespoints pointtype 7 pointsize 0.8 linecolor rgb "
      "'#404040' linewidth 2 notitle, \\\n $planes with lines linewidth 2 dashtype 2 linecolor rgb '{2}' title 'planes R_i: edge and "
      "smooth normal n_i', \\\n $flat using 1:2:3:4 with vectors head filled size 0.4,15 linewidth 1.5 linecolor rgb '#a8a8a8' title "
      "'normal of the nearest face', \\\n $smooth using 1:2:3:4 with vectors nohead linewidth 2 linecolor rgb '{1}' title 'n: from D to "
      "P', \\\n $vcps with points pointtype 7 pointsize 1.1 linecolor rgb '{3}' title 'virtual contact points D', \\\n $probes with points "
      "pointtype 7 pointsize 1.1 linecolor rgb 'black' title 'probe P'\n",
      kSolid, kBlue, kGreen, kRed);
  return Figure{"algorithm1", script};
}

// --- proxy: over a convex edge, in a concave edge --------------------------------------------------------------------------------

Result<Figure> draw_proxy() {
  const Outline outline = {{-0.022, -0.014}, {0.022, -0.014}, {0.022, 0.005}, {0.006, -0.003}, {-0.007, 0.006}, {-0.022, -0.002}};
  std::vector<Vec3> corners = {at(-16, 4), at(-14.5, -1.5), at(-7, 0.5), at(-1.5, -4), at(5.5, -7.5), at(13.5, -2.0)};
  std::vector<Vec3> path;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const int parts = std::max(1, static_cast<int>((corners[i + 1] - corners[i]).norm() / 0.0009));
    for (int k = 0; k < parts; ++k) path.push_back(corners[i] + (corners[i + 1] - corners[i]) * (double(k) / parts));
  }
  path.push_back(corners.back());
  MethodSettings settings;
  settings.name = "proxy";
  const auto samples = follow(settings, scene_of(make_prism(outline, 0.06, 1)), path);
  if (!samples) return tl::unexpected(samples.error());
  Points devices, proxies, springs;
  for (const Sample& s : *samples) {
    devices.add(s.device);
    proxies.add(s.output.p_SP);
    if (s.output.contact) springs.add(s.device, s.output.p_SP - s.device);
  }
  const Vec3 corner(outline[3].x(), outline[3].y(), 0.0);
  Points planes;
  for (const int other : {2, 4}) {
    const Vec3 wall = (Vec3(outline[other].x(), outline[other].y(), 0.0) - corner).normalized();
    planes.line(corner - 0.006 * wall, corner + 0.011 * wall);
  }
  std::string script = begin("proxy", 1000, 580) + outline_of(outline).block("solid") + devices.block("devices") +
                       proxies.block("proxies") + springs.block("springs") + planes.block("planes");
  script += fmt::format(
      "set title 'proxy: the nearest place to the device that can be reached without crossing the surface'\n"
      "set size ratio -1\n"
      "set xrange [-20:20]\n"
      "set yrange [-11.5:8]\n"
      "set xlabel 'mm' offset 0,0.4\n"
      "set label 1 'held by one plane' at -14,3.7 rotate by 28\n"
      "set label 2 'past the convex edge it catches up' at -5.6,5.9\n"
      "set label 3 \"held by two planes: one proxy\\nfor many device points\" at 7,2.6 center\n"
      "plot $solid with filledcurves closed fillcolor rgb '{0}' notitle, $solid with lines linecolor rgb '#404040' linewidth 2 notitle, "
      "\\\n $planes with lines linewidth 2 dashtype 2 linecolor rgb '{3}' title 'contact planes at the concave edge', \\\n $springs using "
      "1:2:3:4 "
      "with vectors nohead linewidth 1.2 linecolor rgb '#909090' title 'spring: force / k', \\\n $devices with linespoints pointtype 7 "
      "pointsize 0.9 linewidth 1 linecolor rgb 'black' title 'device', \\\n $proxies with points pointtype 7 pointsize 1.2 linecolor rgb "
      "'{1}' title 'proxy'\n",
      kSolid, kBlue, kRed, kOrange);
  return Figure{"proxy", script};
}

// --- All methods on one slide ----------------------------------------------------------------------------------------------------

// The top of the block that the slide crosses, left to right: a convex edge of six facets, a groove.
Outline profile() {
  Outline top = {{-0.030, 0.0}};
  for (int degree = 150; degree >= 30; degree -= 20)
    top.emplace_back(-0.012 + 0.014 * std::cos(degree * kPi / 180), 0.014 * std::sin(degree * kPi / 180) - 0.007);
  for (const auto& p :
       {Eigen::Vector2d(0.006, 0.0), Eigen::Vector2d(0.012, -0.006), Eigen::Vector2d(0.018, 0.0), Eigen::Vector2d(0.030, 0.0)})
    top.push_back(p);
  return top;
}

double height_of(const Outline& top, double x) {
  for (std::size_t i = 0; i + 1 < top.size(); ++i) {
    if (x <= top[i + 1].x()) return top[i].y() + (x - top[i].x()) / (top[i + 1].x() - top[i].x()) * (top[i + 1].y() - top[i].y());
  }
  return top.back().y();
}

// The curve of one method in the figure of a slide.
struct SlideCurve {
  const char* block;
  const char* method;
  const char* title;
  double offset_m;  // used only by the method sweep
  const char* style;
};

std::array<SlideCurve, 5> slide_curves() {
  const MethodSettings defaults;
  return {SlideCurve{"memo", "sweep", "sweep, the memo's offset of 12.7 um: lags by centimetres", defaults.offset_m,
                     "linewidth 1.5 dashtype 2 linecolor rgb '#d07000'"},
          SlideCurve{"sweep", "sweep", "sweep, offset 0.5 mm", 0.0005, "linewidth 2 linecolor rgb '#d07000'"},
          SlideCurve{"smooth", "smooth", "smooth", defaults.offset_m, "linewidth 2.5 linecolor rgb '#009e60'"},
          SlideCurve{"proxy", "proxy", "proxy", defaults.offset_m, "linewidth 3.5 linecolor rgb '#70a8ff'"},
          SlideCurve{"reference", "reference", "reference", defaults.offset_m, "linewidth 1.2 linecolor rgb 'black'"}};
}

// The curve's data block for gnuplot: x in mm, size of the force in N, direction of the force in degrees from +y.
Result<std::string> make_slide_data(const SlideCurve& curve, const TouchScene& scene, const std::vector<Vec3>& path) {
  MethodSettings settings;
  settings.name = curve.method;
  settings.offset_m = curve.offset_m;
  const auto samples = follow(settings, scene, path);
  if (!samples) return tl::unexpected(samples.error());
  std::string data = fmt::format("${} << EOD\n", curve.block);
  for (const Sample& s : *samples) {
    const Vec3& F = s.output.force_n;
    const bool has_force = F.norm() > 0.0;
    fmt::format_to(std::back_inserter(data), "{:.5g} {:.5g} {}\n", 1e3 * s.device.x(), F.norm(),
                   has_force ? fmt::format("{:.5g}", std::atan2(F.x(), F.y()) * 180 / kPi) : "NaN");
  }
  return data + "EOD\n";
}

Result<Figure> draw_slide() {
  const Outline top = profile();
  Outline outline = {{-0.030, -0.020}, {0.030, -0.020}};
  outline.insert(outline.end(), top.rbegin(), top.rend());
  const TouchScene scene = scene_of(make_prism(outline, 0.06, 1));
  std::vector<Vec3> path;
  for (int i = 0; i <= 540; ++i) {  // 100 mm/s at 1 kHz; sinks from 2 mm above the surface to 1.2 mm below it
    const double x = -0.027 + 1e-4 * i;
    path.emplace_back(x, height_of(top, x) + 0.002 - 0.0032 * std::min(1.0, i / 30.0), kSlice);
  }
  std::string data;
  std::string plot_size;
  std::string plot_direction;
  for (const SlideCurve& curve : slide_curves()) {
    const auto block = make_slide_data(curve, scene, path);
    if (!block) return tl::unexpected(block.error());
    data += *block;
    const char* comma = plot_size.empty() ? "" : ", ";
    plot_size += fmt::format("{}${} using 1:2 with lines {} title \"{}\"", comma, curve.block, curve.style, curve.title);
    plot_direction += fmt::format("{}${} using 1:3 with lines {} notitle", comma, curve.block, curve.style);
  }
  Points device;
  for (const Vec3& p : path) device.add(p);
  std::string script = begin("slide", 1000, 860) + data + outline_of(outline).block("solid") + device.block("device");
  script += fmt::format(
      "set multiplot\n"
      "set key inside top right height 0\n"
      "set lmargin at screen 0.09\n"
      "set rmargin at screen 0.98\n"
      "set xrange [-28:28]\n"
      "set grid xtics ytics linecolor rgb '#e4e4e4'\n"
      "set tmargin at screen 0.95\n"
      "set bmargin at screen 0.76\n"
      "set yrange [-9:9]\n"
      "set ylabel 'mm'\n"
      "set format x ''\n"
      "set title 'One slide at 100 mm/s, 1.2 mm under a faceted ridge and a groove, k = 1000 N/m'\n"
      "plot $solid with filledcurves closed fillcolor rgb '{}' notitle, $solid with lines linecolor rgb '#404040' linewidth 2 notitle, "
      "$device with lines linewidth 1.5 linecolor rgb '{}' title 'device'\n"
      "unset title\n"
      "set tmargin at screen 0.74\n"
      "set bmargin at screen 0.42\n"
      "set yrange [0:3.6]\n"
      "set ylabel '|F|, N'\n"
      "set key top right Left reverse height 0\n"
      "plot {}\n"
      "set tmargin at screen 0.39\n"
      "set bmargin at screen 0.07\n"
      "set yrange [-80:80]\n"
      "set ytics 20\n"
      "set ylabel 'direction of F, degrees from upright'\n"
      "set xlabel 'device, x in mm' offset 0,0.4\n"
      "set format x '%g'\n"
      "plot {}\n"
      "unset multiplot\n"
      "set key inside top right height 0\n",
      kSolid, kRed, plot_size, plot_direction);
  return Figure{"slide", script};
}

}  // namespace
}  // namespace figures

Result<std::vector<Figure>> make_figures() {
  using namespace figures;
  std::vector<Figure> figures;
  for (const auto draw : {draw_sweep, draw_hulls, draw_algorithm_1, draw_proxy, draw_contact_offset, draw_slide}) {
    auto figure = draw();
    if (!figure) return tl::unexpected(figure.error());
    figures.push_back(std::move(*figure));
  }
  return figures;
}

}  // namespace hapton
