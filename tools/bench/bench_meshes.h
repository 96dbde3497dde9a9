#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// A mesh that a benchmark works on, its longest side 100 mm.
struct BenchMesh {
  std::string name;
  std::shared_ptr<const TriangleMesh> mesh;
};

// Which: files of the mesh folder, files anywhere, and "bumpy:20000", a bumpy sphere of at least so many triangles.
Result<BenchMesh> make_bench_mesh(const std::string& which, const std::filesystem::path& mesh_folder);

// Where the project's meshes lie: ./meshes where there is one, else those this program was built beside.
std::filesystem::path find_mesh_folder();

// The names of all mesh files in the folder, in order; empty where there is none.
std::vector<std::string> find_mesh_files(const std::filesystem::path& folder);

// Makes the folder and tries to write there, so that a long measurement does not find out at its end. Error: one line with the path.
Result<void> check_writable(const std::filesystem::path& folder);

// Prints "  12.3 s  what" on stderr: what a long measurement is at.
void print_progress(double seconds, const std::string& what);

}  // namespace hapton
