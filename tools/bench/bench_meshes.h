#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// A mesh for a benchmark; its longest side is 100 mm.
struct BenchMesh {
  std::string name;
  std::shared_ptr<const TriangleMesh> mesh;
};

// mesh_spec: a file in the mesh folder, a file anywhere, or "bumpy:20000", a bumpy sphere of at least this many triangles.
Result<BenchMesh> make_bench_mesh(const std::string& mesh_spec, const std::filesystem::path& mesh_folder);

// The folder of the project's meshes: ./meshes if it exists, otherwise the folder meshes of the source tree.
std::filesystem::path find_mesh_folder();

// The names of all mesh files in the folder, sorted; empty if there are none.
std::vector<std::string> find_mesh_files(const std::filesystem::path& folder);

// Creates the folder and tries to write there, so that a long measurement does not fail at its end. Error: one line with the path.
Result<void> ensure_writable_folder(const std::filesystem::path& folder);

// Prints "   12.3 s  what" on stderr: the progress of a long measurement.
void print_progress(double seconds, const std::string& what);

}  // namespace hapton
