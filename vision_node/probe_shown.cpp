#include "vision_node/probe_shown.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <system_error>

#include "core/math/rotation_vector.h"

namespace hapton {
namespace {

// Framing::view_m (metres) for which the defaults of ProbeSizes were chosen: a workspace on a desk.
constexpr double kDeskView = 0.3;

// A smaller change of the force bar cannot be seen.
constexpr double kForceShare = 0.01;

double force_share(const ProbeShown& probe) {
  return probe.force_limit_n > 0.0 ? std::min(1.0, probe.force_n.norm() / probe.force_limit_n) : 0.0;
}

// The number after `key` in a method text; 0 if there is none.
double find_method_number(std::string_view method, std::string_view key) {
  const auto at = method.find(key);
  if (at == std::string_view::npos) return 0.0;
  double number = 0.0;
  const char* from = method.data() + at + key.size();
  const auto [end, error] = std::from_chars(from, method.data() + method.size(), number);
  return error == std::errc() && end != from ? number : 0.0;
}

}  // namespace

ProbeSizes scale_probe(const Framing& framing) {
  const double scale = framing.view_m / kDeskView;
  ProbeSizes sizes;
  sizes.tip_radius_m *= scale;
  sizes.stylus_length_m *= scale;
  sizes.arrow_m_per_n *= scale;
  sizes.arrow_max_m *= scale;
  sizes.arrow_radius_m *= scale;
  return sizes;
}

ProbeShown make_shown_probe(const ProbeState& state, const Quat& lean) {
  ProbeShown shown;
  shown.contact = state.contact;
  if (state.p_WD.allFinite()) shown.p_WP = state.p_WD;
  shown.p_WD = shown.p_WP;
  if (state.visual_offset_m.allFinite()) shown.p_WP += state.visual_offset_m;
  if (state.force_n.allFinite()) shown.force_n = state.force_n;
  if (std::isfinite(state.force_limit_n)) shown.force_limit_n = std::max(0.0, static_cast<double>(state.force_limit_n));
  if (state.q_WT.coeffs().allFinite() && state.q_WT.squaredNorm() > 0.25) shown.q_WT = state.q_WT.normalized();
  shown.q_WP = state.visual_turn.allFinite() ? turn_by(state.visual_turn) * shown.q_WT : shown.q_WT;
  shown.q_WT = lean * shown.q_WT;
  return shown;
}

double find_probe_radius(std::string_view method) {
  const double radius_m = find_method_number(method, "probe_radius_m=");
  return radius_m > 0.0 && std::isfinite(radius_m) ? radius_m : 0.0;
}

int find_set_size(std::string_view method) {
  constexpr int kDefaultSetSize = 64;  // triangles in a local set, the default of MethodSettings
  const double size = find_method_number(method, "set_size=");
  return size >= 1.0 && size <= 1e4 ? static_cast<int>(size) : kDefaultSetSize;
}

bool touches_surface(const ProbeState& state) { return state.contact && (state.object >= 0 || !state.visual_offset_m.isZero(0.0)); }

// Leans the stylus towards the direction 55 degrees up from the right: it turns about the axis at right angles to z and to that direction.
Quat make_lean(double angle_rad) {
  constexpr double kTowards = 55.0 * std::numbers::pi / 180.0;
  return Quat(Eigen::AngleAxisd(angle_rad, Vec3(-std::sin(kTowards), std::cos(kTowards), 0.0)));
}

Vec3 compute_arrow(const ProbeShown& probe, const ProbeSizes& sizes) {
  const double newtons = probe.force_n.norm();
  if (!(newtons > 0.0)) return Vec3::Zero();
  return probe.force_n / newtons * std::min(newtons * sizes.arrow_m_per_n, sizes.arrow_max_m);
}

PictureWatch::Marks PictureWatch::compute_marks(const ProbeShown& probe, const ProbeSizes& sizes, const StereoScreen& screen,
                                                PictureSize size) {
  const Vec3 end = probe.p_WP + probe.q_WT * (sizes.stylus_length_m * Vec3::UnitZ());
  const Vec3 head = probe.p_WP + compute_arrow(probe, sizes);
  const Vec3 side = probe.p_WP + probe.q_WP * (sizes.tool_radius_m * Vec3::UnitX());
  const Vec3 top = probe.p_WP + probe.q_WP * (sizes.tool_radius_m * Vec3::UnitY());
  Marks marks;
  std::size_t i = 0;
  for (const Eye eye : {Eye::left, Eye::right}) {
    for (const Vec3& p : {probe.p_WP, end, head, side, top}) marks[i++] = project_to_pixel(screen, eye, size, p);
  }
  return marks;
}

bool PictureWatch::differs(const ProbeShown& probe, const ProbeSizes& sizes, const StereoScreen& screen, PictureSize size) const {
  if (!has_drawn_ || contact_ != probe.contact) return true;
  if (std::abs(force_share(probe) - force_share_) > kForceShare) return true;
  const Marks now = compute_marks(probe, sizes, screen, size);
  for (std::size_t i = 0; i < now.size(); ++i) {
    // A mark that is not finite (its point is in the plane of the eye) counts as moved.
    if (!((now[i] - marks_[i]).norm() <= threshold_px_)) return true;
  }
  return false;
}

void PictureWatch::note_drawn(const ProbeShown& probe, const ProbeSizes& sizes, const StereoScreen& screen, PictureSize size) {
  has_drawn_ = true;
  contact_ = probe.contact;
  force_share_ = force_share(probe);
  marks_ = compute_marks(probe, sizes, screen, size);
}

}  // namespace hapton
