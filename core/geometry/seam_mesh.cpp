#include "core/geometry/seam_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace hapton {
namespace {

constexpr double kNoArea = 1e-14;           // twice the area, over the longest edge squared, up to which a triangle has no valid normal
constexpr double kMinCosine = 1e-3;         // least cosine between a triangle's normals before and after
constexpr double kMinCosineOfShort = 0.75;  // the same with Turning::little, for a triangle with a short edge: 41 degrees
constexpr double kShortEdge = 2.0;          // in tolerances: a shorter edge is short
constexpr double kMinHeightShare = 0.1;     // least share of its height that a triangle keeps, where kMinHeight would require more
constexpr std::ptrdiff_t kMaxFlooded = 64;  // triangles that flood() adds before it gives up

bool repeats_vertex(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

struct Shape {
  Vec3 normal;  // its length is twice the area
  double longest_squared = 0.0;
  double shortest_squared = 0.0;
  bool has_area() const { return normal.norm() > kNoArea * longest_squared; }
  double height() const { return longest_squared > 0.0 ? normal.norm() / std::sqrt(longest_squared) : 0.0; }
};

Shape shape_of(const std::array<Vec3, 3>& corners) {
  const Vec3 ab = corners[1] - corners[0];
  const Vec3 ac = corners[2] - corners[0];
  const auto [shortest, longest] = std::minmax({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()});
  return {ab.cross(ac), longest, shortest};
}

double distance_to_segment(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 along = b - a;
  const double length = along.squaredNorm();
  const double share = length > 0.0 ? std::clamp(along.dot(p - a) / length, 0.0, 1.0) : 0.0;
  return (p - a - share * along).norm();
}

void replace(Triangle& triangle, std::uint32_t from, std::uint32_t to) {
  for (std::uint32_t& v : triangle) {
    if (v == from) v = to;
  }
}

bool has_vertex(const Triangle& t, std::uint32_t vertex) { return t[0] == vertex || t[1] == vertex || t[2] == vertex; }

}  // namespace

bool is_sound_change(const std::array<Vec3, 3>& before, const std::array<Vec3, 3>& after, double tolerance, Turning turning) {
  const Shape shape_before = shape_of(before);
  if (!shape_before.has_area()) return true;
  const Shape shape_after = shape_of(after);
  if (!shape_after.has_area() ||
      !(shape_after.height() >= std::min(SeamMesh::kMinHeight * tolerance, kMinHeightShare * shape_before.height())))
    return false;
  const bool has_short_edge = shape_after.shortest_squared < kShortEdge * kShortEdge * tolerance * tolerance;
  const double least_cosine = turning == Turning::little && has_short_edge ? kMinCosineOfShort : kMinCosine;
  return shape_before.normal.dot(shape_after.normal) > least_cosine * shape_before.normal.norm() * shape_after.normal.norm();
}

std::vector<std::uint8_t> find_boundary_vertices(const TriangleMesh& mesh) {
  // Edges are collected by their lower vertex; among those of one vertex, the few with the same upper vertex are found.
  std::vector<std::uint32_t> first(mesh.vertices.size() + 2, 0);
  const auto for_each_edge = [&](auto&& visit) {
    for (const Triangle& t : mesh.triangles) {
      if (repeats_vertex(t)) continue;
      for (int k = 0; k < 3; ++k) {
        const auto [low, high] = std::minmax(t[k], t[k == 2 ? 0 : k + 1]);
        visit(low, high);
      }
    }
  };
  for_each_edge([&](std::uint32_t low, std::uint32_t) { ++first[low + 2]; });
  for (std::size_t v = 2; v < first.size(); ++v) first[v] += first[v - 1];
  std::vector<std::uint32_t> highs(first.back());
  for_each_edge([&](std::uint32_t low, std::uint32_t high) { highs[first[low + 1]++] = high; });
  std::vector<std::uint8_t> at_boundary(mesh.vertices.size(), 0);
  bool has_any = false;
  for (std::uint32_t low = 0; low < mesh.vertices.size(); ++low) {
    const auto begin = highs.begin() + first[low];
    const auto end = highs.begin() + first[low + 1];
    std::sort(begin, end);
    for (auto it = begin; it != end;) {
      auto next = it + 1;
      while (next != end && *next == *it) ++next;
      if (next == it + 1) {
        at_boundary[low] = 1;
        at_boundary[*it] = 1;
        has_any = true;
      }
      it = next;
    }
  }
  if (!has_any) at_boundary.clear();
  return at_boundary;
}

SeamMesh::EdgeTable::EdgeTable() : keys_(1024, kEmpty), states_(1024) {}

std::size_t SeamMesh::EdgeTable::slot_of(std::uint64_t key) const {
  std::uint64_t h = key * 0x9E3779B97F4A7C15ULL;
  h = (h ^ (h >> 32)) * 0xD6E8FEB86659FD93ULL;
  std::size_t slot = static_cast<std::size_t>(h ^ (h >> 32)) & (keys_.size() - 1);
  while (keys_[slot] != kEmpty && keys_[slot] != key) slot = (slot + 1) & (keys_.size() - 1);
  return slot;
}

SeamMesh::EdgeState& SeamMesh::EdgeTable::at(std::uint64_t key) {
  std::size_t slot = slot_of(key);
  if (keys_[slot] == key) return states_[slot];
  if (2 * ++used_ > keys_.size()) {
    const std::vector<std::uint64_t> keys = std::exchange(keys_, std::vector<std::uint64_t>(2 * keys_.size(), kEmpty));
    const std::vector<EdgeState> states = std::exchange(states_, std::vector<EdgeState>(keys_.size()));
    for (std::size_t i = 0; i < keys.size(); ++i) {
      if (keys[i] == kEmpty) continue;
      const std::size_t to = slot_of(keys[i]);
      keys_[to] = keys[i];
      states_[to] = states[i];
    }
    slot = slot_of(key);
  }
  keys_[slot] = key;
  return states_[slot];
}

SeamMesh::SeamMesh(TriangleMesh& mesh, std::vector<std::uint8_t> at_boundary, double tolerance, Turning turning)
    : mesh_(mesh),
      tolerance_(tolerance),
      turning_(turning),
      original_(mesh.triangles),
      fan_number_(mesh.vertices.size(), kNone),
      boundary_count_(mesh.vertices.size(), 0),
      welded_to_(mesh.vertices.size(), kNone) {
  for (std::uint32_t v = 0; v < at_boundary.size(); ++v) {
    if (at_boundary[v] == 0) continue;
    fan_number_[v] = static_cast<std::uint32_t>(vertex_of_fan_.size());
    next_member_.push_back(v);
    vertex_of_fan_.push_back(v);
  }
  fans_.resize(vertex_of_fan_.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& triangle = mesh.triangles[t];
    if (repeats_vertex(triangle)) continue;
    bool is_at_boundary = false;
    for (const std::uint32_t v : triangle) {
      if (!is_tracked(v)) continue;
      fan_of(v).push_back(t);
      is_at_boundary = true;
    }
    if (is_at_boundary) add_edges(t);
  }
  zipped_ = 0;
}

std::uint32_t SeamMesh::representative_of(std::uint32_t vertex) const {
  while (welded_to_[vertex] != kNone) vertex = welded_to_[vertex];
  return vertex;
}

bool SeamMesh::is_boundary(std::uint32_t a, std::uint32_t b) const { return is_tracked(a) && is_tracked(b) && find(a, b).count == 1; }

SeamMesh::Edge SeamMesh::edge_of(std::uint32_t triangle, std::uint32_t k) const {
  const Triangle& v = mesh_.triangles[triangle];
  return {v[k], v[(k + 1) % 3], triangle, v[(k + 2) % 3], 3 * source_of(triangle) + k};
}

SeamMesh::Edge SeamMesh::boundary_edge(std::uint32_t a, std::uint32_t b) const {
  const std::uint32_t t = find(a, b).triangles;
  const Triangle& v = mesh_.triangles[t];
  std::uint32_t k = 0;
  while ((v[k] != a || v[(k + 1) % 3] != b) && (v[k] != b || v[(k + 1) % 3] != a)) ++k;
  return edge_of(t, k);
}

std::pair<Vec3, Vec3> SeamMesh::chord_of(const Edge& edge) const {
  const Triangle& original = original_[edge.chord / 3];
  const std::uint32_t k = edge.chord % 3;
  return {position(representative_of(original[k])), position(representative_of(original[(k + 1) % 3]))};
}

std::vector<std::uint32_t> SeamMesh::boundary_vertices() const {
  std::vector<std::uint32_t> vertices;
  for (const std::uint32_t v : vertex_of_fan_) {
    if (boundary_count_[v] > 0) vertices.push_back(v);
  }
  return vertices;
}

void SeamMesh::find_boundary_edges_at(std::uint32_t vertex, std::vector<Edge>& edges) const {
  edges.clear();
  if (boundary_count_[vertex] == 0) return;
  work_ += fan_of(vertex).size();
  for (const std::uint32_t t : fan_of(vertex)) {
    const Triangle& triangle = mesh_.triangles[t];
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t from = triangle[k];
      const std::uint32_t to = triangle[(k + 1) % 3];
      if ((from == vertex || to == vertex) && is_boundary(from, to)) edges.push_back(edge_of(t, k));
    }
  }
}

std::vector<SeamMesh::Edge> SeamMesh::boundary_edges() const {
  std::vector<Edge> all;
  std::vector<Edge> here;
  for (const std::uint32_t v : vertex_of_fan_) {
    find_boundary_edges_at(v, here);
    for (const Edge& edge : here) {
      if (edge.from == v) all.push_back(edge);
    }
  }
  std::sort(all.begin(), all.end(),
            [](const Edge& a, const Edge& b) { return a.triangle != b.triangle ? a.triangle < b.triangle : a.from < b.from; });
  return all;
}

Vec3 SeamMesh::inward(const Edge& edge) const {
  const Vec3 along = position(edge.to) - position(edge.from);
  const Vec3 to_apex = position(edge.apex) - position(edge.from);
  const double length = along.squaredNorm();
  const Vec3 off = length > 0.0 ? Vec3(to_apex - along.dot(to_apex) / length * along) : Vec3(to_apex);
  const double norm = off.norm();
  return norm > kNoArea * to_apex.norm() ? Vec3(off / norm) : Vec3(Vec3::Zero());
}

bool SeamMesh::flood(std::vector<std::uint32_t> reached, std::uint32_t to, const Vec3& near, double radius) const {
  std::sort(reached.begin(), reached.end());
  const auto start_end = static_cast<std::ptrdiff_t>(reached.size());
  for (std::size_t i = 0; i < reached.size(); ++i) {
    ++work_;
    const Triangle& triangle = mesh_.triangles[reached[i]];
    if (has_vertex(triangle, to)) return true;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = triangle[k];
      const std::uint32_t b = triangle[(k + 1) % 3];
      const EdgeState edge = find(a, b);
      if (edge.count != 2 || distance_to_segment(position(a), position(b), near) > radius) continue;
      const std::uint32_t next = edge.triangles ^ reached[i];
      const auto behind = reached.begin() + start_end;
      if (std::binary_search(reached.begin(), behind, next) || std::find(behind, reached.end(), next) != reached.end()) continue;
      if (reached.end() - behind == kMaxFlooded) return true;
      reached.push_back(next);
    }
  }
  return false;
}

bool SeamMesh::is_joined_nearby(std::uint32_t u, std::uint32_t v, const Vec3& near, double radius) const {
  return valence(u) < valence(v) ? flood(fan_of(u), v, near, radius) : flood(fan_of(v), u, near, radius);
}

bool SeamMesh::is_triangle_joined_nearby(std::uint32_t triangle, std::uint32_t to, const Vec3& near, double radius) const {
  return flood({triangle}, to, near, radius);
}

std::uint32_t SeamMesh::source_of(std::uint32_t triangle) const {
  return triangle < original_.size() ? triangle : sources_[triangle - original_.size()];
}

void SeamMesh::count_boundary(std::uint32_t a, std::uint32_t b, bool is_boundary_now) {
  if (!is_tracked(a) || !is_tracked(b)) return;
  boundary_count_[a] += is_boundary_now ? 1U : ~0U;
  boundary_count_[b] += is_boundary_now ? 1U : ~0U;
}

void SeamMesh::add_edge(std::uint32_t a, std::uint32_t b, std::uint32_t triangle) {
  EdgeState& edge = edges_.at(key_of(a, b));
  edge.triangles ^= triangle;
  ++edge.count;
  if (edge.count == 1) count_boundary(a, b, true);
  if (edge.count == 2) {
    count_boundary(a, b, false);
    ++zipped_;
  }
}

void SeamMesh::remove_edge(std::uint32_t a, std::uint32_t b, std::uint32_t triangle) {
  EdgeState& edge = edges_.at(key_of(a, b));
  edge.triangles ^= triangle;
  --edge.count;
  if (edge.count == 0) count_boundary(a, b, false);
  if (edge.count == 1) {
    count_boundary(a, b, true);
    --zipped_;
  }
}

void SeamMesh::add_edges(std::uint32_t triangle) {
  const Triangle& v = mesh_.triangles[triangle];
  for (int k = 0; k < 3; ++k) add_edge(v[k], v[(k + 1) % 3], triangle);
}

void SeamMesh::remove_edges(std::uint32_t triangle) {
  const Triangle& v = mesh_.triangles[triangle];
  for (int k = 0; k < 3; ++k) remove_edge(v[k], v[(k + 1) % 3], triangle);
}

bool SeamMesh::is_sound(std::uint32_t source, const Triangle& triangle) const {
  const auto corners = [&](const Triangle& t) { return std::array<Vec3, 3>{position(t[0]), position(t[1]), position(t[2])}; };
  return is_sound_change(corners(original_[source]), corners(triangle), tolerance_, turning_);
}

bool SeamMesh::keeps_members_near(std::uint32_t u, std::uint32_t v) const {
  bool is_near = true;
  for_each_member(u, [&](std::uint32_t member) { is_near &= (position(member) - position(v)).norm() <= tolerance_; });
  return is_near;
}

// True if, where edges would coincide, each has one triangle, and these two would not get the same three vertices.
bool SeamMesh::keeps_edges_apart(std::uint32_t u, std::uint32_t v) const {
  for (const std::uint32_t t : fan_of(u)) {
    for (const std::uint32_t w : mesh_.triangles[t]) {
      if (w == u) continue;
      const EdgeState there = find(v, w);
      if (there.count == 0) continue;
      if (there.count != 1 || find(u, w).count != 1) return false;
      bool is_same = true;
      for (const std::uint32_t corner : mesh_.triangles[t]) is_same &= corner == u || has_vertex(mesh_.triangles[there.triangles], corner);
      if (is_same) return false;
    }
  }
  return true;
}

// True if the triangles at u stay sound when u moves to the position of v.
bool SeamMesh::stays_sound(std::uint32_t u, std::uint32_t v) const {
  return std::all_of(fan_of(u).begin(), fan_of(u).end(), [&](std::uint32_t t) {
    Triangle moved = mesh_.triangles[t];
    replace(moved, u, v);
    return is_sound(source_of(t), moved);
  });
}

void SeamMesh::rename(std::uint32_t u, std::uint32_t v) {
  for (const std::uint32_t t : fan_of(u)) {
    remove_edges(t);
    replace(mesh_.triangles[t], u, v);
    add_edges(t);
  }
  const std::vector<std::uint32_t> moved = std::move(fan_of(u));
  fan_of(u).clear();
  fan_of(v).insert(fan_of(v).end(), moved.begin(), moved.end());
}

SeamMesh::Weld SeamMesh::weld(std::uint32_t u, std::uint32_t v) {
  work_ += fan_of(u).size();
  if (u == v || is_edge(u, v) || !keeps_edges_apart(u, v) || !stays_sound(u, v)) return Weld::rejected;
  if (!keeps_members_near(u, v)) return Weld::too_far;
  rename(u, v);
  std::swap(next_member_[fan_number_[u]], next_member_[fan_number_[v]]);
  welded_to_[u] = v;
  ++welded_;
  return Weld::done;
}

bool SeamMesh::move_to_member(std::uint32_t u, std::uint32_t member) {
  if (u == member) return true;
  work_ += fan_of(u).size();
  if (!keeps_members_near(u, member) || !stays_sound(u, member)) return false;
  rename(u, member);
  welded_to_[u] = member;
  welded_to_[member] = kNone;
  return true;
}

bool SeamMesh::split(std::uint32_t a, std::uint32_t b, std::uint32_t at) {
  if (!is_boundary(a, b) || at == a || at == b) return false;
  const Edge edge = boundary_edge(a, b);
  if (is_edge(at, edge.apex) || at == edge.apex || find(a, at).count > 1 || find(b, at).count > 1) return false;
  const std::uint32_t source = source_of(edge.triangle);
  Triangle first = mesh_.triangles[edge.triangle];
  Triangle last = first;
  replace(first, edge.to, at);
  replace(last, edge.from, at);
  if (!is_sound(source, first) || !is_sound(source, last)) return false;

  const auto added_triangle = static_cast<std::uint32_t>(mesh_.triangles.size());
  remove_edges(edge.triangle);
  mesh_.triangles[edge.triangle] = first;
  mesh_.triangles.push_back(last);
  sources_.push_back(source);
  add_edges(edge.triangle);
  add_edges(added_triangle);
  --zipped_;  // add_edges() has counted the edge between the two parts, which is not a seam
  fan_of(at).insert(fan_of(at).end(), {edge.triangle, added_triangle});
  std::replace(fan_of(edge.to).begin(), fan_of(edge.to).end(), edge.triangle, added_triangle);
  if (is_tracked(edge.apex)) fan_of(edge.apex).push_back(added_triangle);
  if (!mesh_.authored_normals.empty()) {
    const auto k_from = static_cast<std::size_t>(std::find(first.begin(), first.end(), edge.from) - first.begin());
    const std::size_t k_to = (k_from + 1) % 3;
    auto& normals = mesh_.authored_normals[edge.triangle];
    const Vec3 along = position(edge.to) - position(edge.from);
    const auto share = static_cast<float>(along.dot(position(at) - position(edge.from)) / along.squaredNorm());
    const bool has_both = !normals[k_from].isZero(0.0F) && !normals[k_to].isZero(0.0F);
    const Eigen::Vector3f between =
        has_both ? Eigen::Vector3f((1.0F - share) * normals[k_from].normalized() + share * normals[k_to].normalized())
                 : Eigen::Vector3f(Eigen::Vector3f::Zero());
    auto added_normals = normals;
    normals[k_to] = between;
    added_normals[k_from] = between;
    mesh_.authored_normals.push_back(added_normals);
  }
  return true;
}

void SeamMesh::unsplit(std::uint32_t a, std::uint32_t b, std::uint32_t at) {
  const auto added_triangle = static_cast<std::uint32_t>(mesh_.triangles.size() - 1);
  const Triangle last = mesh_.triangles[added_triangle];
  const std::uint32_t to = has_vertex(last, b) ? b : a;
  const auto k_at = static_cast<std::size_t>(std::find(last.begin(), last.end(), at) - last.begin());
  const std::size_t k_to = (k_at + 1) % 3;
  const std::uint32_t apex = last[(k_at + 2) % 3];
  const std::uint32_t kept_triangle = fan_of(at)[fan_of(at).size() - 2];
  remove_edges(added_triangle);
  remove_edges(kept_triangle);
  ++zipped_;
  replace(mesh_.triangles[kept_triangle], at, to);
  mesh_.triangles.pop_back();
  sources_.pop_back();
  add_edges(kept_triangle);
  fan_of(at).resize(fan_of(at).size() - 2);
  std::replace(fan_of(to).begin(), fan_of(to).end(), added_triangle, kept_triangle);
  if (is_tracked(apex)) fan_of(apex).pop_back();
  if (!mesh_.authored_normals.empty()) {
    mesh_.authored_normals[kept_triangle][k_to] = mesh_.authored_normals[added_triangle][k_to];
    mesh_.authored_normals.pop_back();
  }
}

SeamMesh::Mapping SeamMesh::finish() {
  Mapping mapping;
  mapping.source_triangles.resize(mesh_.triangles.size());
  std::iota(mapping.source_triangles.begin(), mapping.source_triangles.end(), 0U);
  if (!sources_.empty()) mapping.source_triangles = put_parts_in_place();
  mapping.resulting_vertices.resize(mesh_.vertices.size());
  std::uint32_t kept_count = 0;
  for (std::uint32_t v = 0; v < mapping.resulting_vertices.size(); ++v) {
    if (welded_to_[v] != kNone) continue;
    mesh_.vertices[kept_count] = mesh_.vertices[v];
    mapping.resulting_vertices[v] = kept_count++;
  }
  mesh_.vertices.resize(kept_count);
  for (std::uint32_t v = 0; v < mapping.resulting_vertices.size(); ++v)
    mapping.resulting_vertices[v] = mapping.resulting_vertices[representative_of(v)];
  if (welded_ == 0) return mapping;
  for (Triangle& t : mesh_.triangles) {
    for (std::uint32_t& v : t) v = mapping.resulting_vertices[v];
  }
  return mapping;
}

std::vector<std::uint32_t> SeamMesh::put_parts_in_place() {
  std::vector<std::uint32_t> order(mesh_.triangles.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) { return source_of(i) < source_of(j); });
  std::vector<std::uint32_t> source;
  TriangleMesh ordered;
  for (const std::uint32_t t : order) {
    source.push_back(source_of(t));
    ordered.triangles.push_back(mesh_.triangles[t]);
    if (!mesh_.authored_normals.empty()) ordered.authored_normals.push_back(mesh_.authored_normals[t]);
  }
  mesh_.triangles = std::move(ordered.triangles);
  mesh_.authored_normals = std::move(ordered.authored_normals);
  return source;
}

}  // namespace hapton
