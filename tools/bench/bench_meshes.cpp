#include "tools/bench/bench_meshes.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <system_error>
#include <utility>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "runtime/atomic_file.h"
#include "scene/touch_mesh.h"
#include "tools/mesh_choice.h"

namespace hapton {
namespace {

constexpr double kExtentM = 0.1;  // every mesh is scaled to 100 mm, a size for the hand
constexpr std::string_view kBumpyPrefix = "bumpy:";
constexpr std::size_t kMaxBumpyTriangles = 20'971'520;  // icosphere level 10

Result<BenchMesh> make_bumpy(const std::string& mesh_spec) {
  std::size_t triangles = 0;
  const char* const end = mesh_spec.data() + mesh_spec.size();
  const auto [parsed_end, error] = std::from_chars(mesh_spec.data() + kBumpyPrefix.size(), end, triangles);
  if (error != std::errc() || parsed_end != end || triangles < 20 || triangles > kMaxBumpyTriangles) {
    return fail("mesh '{}': give bumpy:N with N triangles, 20 to {}", mesh_spec, kMaxBumpyTriangles);
  }
  constexpr double kRelativeHeight = 0.25;  // height of the bumps relative to the radius; a free choice
  constexpr std::uint64_t kSeed = 1;
  TriangleMesh mesh = scaled_to(make_bumpy_sphere(0.045, kRelativeHeight, triangles, kSeed), kExtentM);
  const std::size_t triangle_count = mesh.triangles.size();
  return BenchMesh{triangle_count >= 1'000'000 ? fmt::format("bumpy_{:.1f}M", 1e-6 * static_cast<double>(triangle_count))
                                               : fmt::format("bumpy_{:.0f}k", 1e-3 * static_cast<double>(triangle_count)),
                   std::make_shared<TriangleMesh>(std::move(mesh))};
}

}  // namespace

Result<BenchMesh> make_bench_mesh(const std::string& mesh_spec, const std::filesystem::path& mesh_folder) {
  if (mesh_spec.starts_with(kBumpyPrefix)) return make_bumpy(mesh_spec);
  std::error_code ignored;
  const std::filesystem::path path =
      std::filesystem::exists(mesh_spec, ignored) ? std::filesystem::path(mesh_spec) : mesh_folder / mesh_spec;
  auto file = load_touch_mesh(path);
  if (!file) return tl::unexpected(file.error());
  if (!(compute_bounds(file->mesh).extent() > 0.0)) return fail("{}: the mesh has no extent; it cannot be scaled to 100 mm", path.string());
  return BenchMesh{path.stem().string(), std::make_shared<TriangleMesh>(scaled_to(std::move(file->mesh), kExtentM))};
}

std::filesystem::path find_mesh_folder() {
  std::error_code ignored;
  if (std::filesystem::is_directory("meshes", ignored)) return "meshes";
  return std::filesystem::path(HAPTON_SOURCE_FOLDER) / "meshes";
}

std::vector<std::string> find_mesh_files(const std::filesystem::path& folder) {
  constexpr std::array<std::string_view, 5> kMeshExtensions = {".glb", ".gltf", ".obj", ".ply", ".stl"};
  std::vector<std::string> files;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    if (std::find(kMeshExtensions.begin(), kMeshExtensions.end(), entry.path().extension().string()) != kMeshExtensions.end())
      files.push_back(entry.path().filename().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

Result<void> ensure_writable_folder(const std::filesystem::path& folder) {
  const std::filesystem::path test_file = folder / ".hapton-bench";
  if (auto written = write_file_atomically(test_file, ""); !written) return written;
  std::error_code ignored;
  std::filesystem::remove(test_file, ignored);
  return {};
}

void print_progress(double seconds, const std::string& what) {
  fmt::print(stderr, "{:7.1f} s  {}\n", seconds, what);
  std::fflush(stderr);
}

}  // namespace hapton
